"""Photos out of movies: the frames that serve best, written as pictures that are used like any other photo."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import StepFailed, UnusablePhotos
from ...core.photos.frame_choice import choose_frames
from ...core.photos.view import SHARPNESS_SIDE, View, view_of
from ...core.watch import SILENT, Watch
from .atomic import replacing, write_text_at_once
from .content_hash import sha256_of
from .heif import MOST_PIXELS
from .json_files import parsed_json
from .movie_frames import MovieError, bmp_pixels, movie_scene
from .picture_kinds import MOVIE, kind_of_file

# Frames that are looked at: with twelve to choose, ten for each, because the hand's tremor blurs some in any second.
_MOST_CANDIDATES = 120
_LOOKING = 0.8  # of the time goes into looking at the frames
# Of a PNG; more makes it little smaller and takes much longer.
_COMPRESSION = 15  # percent
_RECORD = "frames.json"
# This many characters of a movie's digest distinguish its folder from that of another movie with its name.
_OF_DIGEST = 8


@dataclass(frozen=True)
class Frame:
    """A frame of a movie that was written as a picture.

    Attributes
    ----------
    name : str
        Of its file.
    number : int
        In the movie, from 1.
    seconds : float
        From the movie's beginning.
    sha256 : str
        Of its file.
    """

    name: str
    number: int
    seconds: float
    sha256: str


@dataclass(frozen=True)
class MoviePhotos:
    """What was taken from a movie.

    Attributes
    ----------
    path : Path
        The movie.
    sha256 : str
        Of the movie.
    folder : Path
        Holds the pictures.
    frames : tuple of Frame
    """

    path: Path
    sha256: str
    folder: Path
    frames: tuple[Frame, ...]

    @property
    def pictures(self) -> list[Path]:
        """The files of the frames."""
        return [self.folder / frame.name for frame in self.frames]


def movies_among(files: Sequence[Path]) -> list[Path]:
    """The files that are movies by their content."""
    return [path for path in files if _is_movie(path)]


def with_photos_of_movies(
    files: Sequence[Path],
    folder_of: Callable[[Path], Path],
    warn: Callable[[str], None],
    watch: Watch = SILENT,
    *,
    again: bool = False,
) -> tuple[list[Path], list[MoviePhotos]]:
    """The files, with photos in the place of each movie.

    Parameters
    ----------
    files : sequence of Path
    folder_of : callable
        Where the photos of a movie go.
    warn : callable
        Receives a sentence about each movie that cannot be used.
    watch, again
        As for `take_photos`.

    Returns
    -------
    files : list of Path
    taken : list of MoviePhotos
        What was taken from the movies.

    Raises
    ------
    UnusablePhotos
        If there are only movies, and none can be used.
    StepFailed, Cancelled
    """
    movies = movies_among(files)
    photos_of: dict[Path, list[Path]] = {}
    taken = []
    for index, movie in enumerate(movies):
        part = watch.part(index / len(movies), (index + 1) / len(movies))
        try:
            taken.append(take_photos(movie, folder_of(movie), part, again=again))
            photos_of[movie] = taken[-1].pictures
        except UnusablePhotos as error:
            if len(movies) == len(files) == index + 1 and not taken:
                raise
            photos_of[movie] = []
            warn(str(error))
    return [photo for path in files for photo in photos_of.get(path, [path])], taken


def take_photos(movie: Path, folder: Path, watch: Watch = SILENT, *, again: bool = False) -> MoviePhotos:
    """Write the frames of a movie that serve best as photos; what was written before is used again.

    Parameters
    ----------
    movie : Path
    folder : Path
        The pictures go into a folder of their own there, named after the movie.
    watch : Watch
    again : bool
        Do not use what was written before.

    Returns
    -------
    MoviePhotos

    Raises
    ------
    UnusablePhotos
        If Blender cannot decode the movie, or its frames are larger than any camera's.
    StepFailed
        If a picture could not be written.
    Cancelled
    """
    try:
        digest = sha256_of(movie)
    except OSError as error:
        raise UnusablePhotos(f"{movie.name} cannot be read ({error.strerror}) and is left out.") from error
    own = folder / f"{movie.stem} {digest[:_OF_DIGEST]}"
    if not again and (known := _written_before(movie, digest, own)):
        return known
    try:
        own.mkdir(parents=True, exist_ok=True)
        _clear(own, movie)
    except OSError as error:
        raise StepFailed(
            f"The photos of {movie.name} cannot be written into {folder} ({error.strerror}): copy the movie to a "
            "folder that can be written to."
        ) from error
    try:
        with movie_scene(movie) as (scene, strip):
            frames = _write_frames(movie, own, scene, strip, watch)
    except (MovieError, UnusablePhotos) as error:
        _clear(own, movie)
        with suppress(OSError):
            own.rmdir()
        if isinstance(error, UnusablePhotos):
            raise
        raise UnusablePhotos(
            f"{movie.name} is a movie that Blender cannot decode and is left out: save it as MP4 (H.264), or take "
            "photos."
        ) from error
    taken = MoviePhotos(movie, digest, own, tuple(frames))
    record = {"movie": digest, "frames": [asdict(frame) for frame in frames]}
    write_text_at_once(own / _RECORD, json.dumps(record, indent=1, ensure_ascii=False) + "\n")
    return taken


def _is_movie(path: Path) -> bool:
    try:
        return kind_of_file(path) == MOVIE
    except OSError:
        return False


def _written_before(movie: Path, digest: str, own: Path) -> MoviePhotos | None:
    """The pictures that are already there, if they are all there and as they were written."""
    try:
        record = parsed_json(own / _RECORD)
        frames = tuple(Frame(**frame) for frame in record["frames"])
        whole = record["movie"] == digest and all(sha256_of(own / frame.name) == frame.sha256 for frame in frames)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return MoviePhotos(movie, digest, own, frames) if whole and frames else None


def _clear(own: Path, movie: Path) -> None:
    """Delete what an earlier choice wrote; anything else in the folder is the user's."""
    for path in own.iterdir():
        if path.name == _RECORD or re.fullmatch(rf"{re.escape(movie.stem)}-\d+\.png", path.name):
            path.unlink()


def _write_frames(
    movie: Path, own: Path, scene: bpy.types.Scene, strip: bpy.types.MovieStrip, watch: Watch
) -> list[Frame]:
    element = strip.elements[0]
    width, height, count = element.orig_width, element.orig_height, strip.frame_duration
    if width * height > MOST_PIXELS:
        raise UnusablePhotos(
            f"{movie.name} claims to have {width} x {height} pixels, more than any camera's movie, and is left out: "
            "save it smaller."
        )
    rate = element.orig_fps or scene.render.fps
    scene.render.fps, scene.render.fps_base = max(1, round(rate)), max(1, round(rate)) / rate
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.use_file_extension = False
    for each in scene.render.bl_rna.properties:
        if each.identifier.startswith("use_stamp"):  # the time of rendering, and other things that differ each time
            setattr(scene.render, each.identifier, False)
    candidates = range(1, count + 1, -(-count // _MOST_CANDIDATES))
    seen: dict[int, View] = {}
    for index, number in enumerate(candidates):
        watch.step(_LOOKING * index / len(candidates), f"Looking through {movie.name}")
        view = _look_at(scene, number, min(1, SHARPNESS_SIDE / max(width, height)))
        if view.sharpness > 0:  # where the movie is damaged, Blender gives black
            seen[number] = view
    if not seen:
        raise MovieError("all frames are of one tone")
    chosen = np.array(list(seen))[choose_frames(list(seen.values()))].tolist()
    frames = []
    for index, number in enumerate(chosen):
        watch.step(_LOOKING + (1 - _LOOKING) * index / len(chosen), f"Taking photos from {movie.name}")
        picture = own / f"{movie.stem}-{number:0{len(str(count))}d}.png"
        with replacing(picture) as place:
            _render(scene, number, 1, place, "PNG")
        frames.append(Frame(picture.name, number, round((number - 1) / rate, 3), sha256_of(picture)))
    return frames


def _look_at(scene: bpy.types.Scene, number: int, scale: float) -> View:
    with tempfile.TemporaryDirectory(prefix="origami-frame-") as folder:
        path = Path(folder) / "frame.bmp"
        _render(scene, number, scale, path, "BMP")
        try:
            return view_of(bmp_pixels(path))
        except (OSError, ValueError, IndexError) as error:
            raise MovieError(f"frame {number} is missing") from error


def _render(scene: bpy.types.Scene, number: int, scale: float, path: Path, file_format: str) -> None:
    """Write a frame into a file.

    Raises
    ------
    RuntimeError
    """
    scene.render.image_settings.file_format = file_format
    scene.render.image_settings.color_mode = "RGB"
    if file_format == "PNG":
        scene.render.image_settings.color_depth, scene.render.image_settings.compression = "8", _COMPRESSION
    scene.render.resolution_percentage = max(1, round(100 * scale))
    # A render of a single picture shows the sequencer's first frame, whatever the current one is.
    scene.render.filepath = f"{path}#"
    scene.frame_start = scene.frame_end = number
    bpy.ops.render.render(animation=True, scene=scene.name)
    path.with_name(f"{path.name}{number}").replace(path)
