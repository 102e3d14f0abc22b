"""The frames of a movie file as arrays, decoded by Blender's ffmpeg: its sequencer renders them without any change."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

_STRIP_OFFSETS = 273

Frame = NDArray[np.uint8] | NDArray[np.uint16]


class MovieError(Exception):
    """Blender cannot decode a movie."""


def movie_frames(path: Path, width: int, height: int, count: int, *, deep: bool) -> Iterator[Frame]:
    """Each frame of a movie, at its own size and without colour management.

    The scenes stay as they are, and so do the images except the one of the last render.

    Parameters
    ----------
    path : Path
    width, height : int
        Pixels of a frame.
    count : int
        Number of frames.
    deep : bool
        Give 16 bits. Blender 4.5 decodes only 8 of them.

    Yields
    ------
    (height, width, 3) uint8 or uint16 array

    Raises
    ------
    MovieError
        If Blender cannot decode the movie, or its frames have another size or number.
    """
    with tempfile.TemporaryDirectory(prefix="origami-frames-") as folder, movie_scene(path) as (scene, strip):
        first = strip.elements[0]
        if (first.orig_width, first.orig_height, strip.frame_duration) != (width, height, count):
            raise MovieError(f"{strip.frame_duration} frames of {first.orig_width} x {first.orig_height} pixels")
        scene.frame_start, scene.frame_end = 1, count
        scene.render.resolution_x, scene.render.resolution_y = width, height
        scene.render.resolution_percentage = 100
        scene.render.filepath = str(Path(folder) / "######")
        scene.render.use_file_extension = False
        written_as = scene.render.image_settings
        written_as.file_format = "TIFF" if deep else "BMP"
        written_as.color_mode = "RGB"
        if deep:
            written_as.color_depth, written_as.tiff_codec = "16", "NONE"
        try:
            bpy.ops.render.render(animation=True, scene=scene.name)
        except RuntimeError as error:
            raise MovieError(str(error)) from error
        for number in range(1, count + 1):
            frame = Path(folder) / f"{number:06d}"
            if not frame.is_file():
                raise MovieError(f"frame {number} is missing")
            yield _tiff_pixels(frame, width, height) if deep else bmp_pixels(frame)
            frame.unlink()


@contextmanager
def movie_scene(path: Path) -> Iterator[tuple[bpy.types.Scene, bpy.types.MovieStrip]]:
    """A temporary scene whose sequencer shows the movie, and changes no colour.

    Raises
    ------
    MovieError
        If Blender cannot decode the movie.
    """
    scene = bpy.data.scenes.new("origami frames")
    try:
        editor = scene.sequence_editor_create()
        strips = editor.strips if hasattr(editor, "strips") else editor.sequences  # Blender 4.4 renamed them
        strip = strips.new_movie("frames", str(path), 1, 1, fit_method="ORIGINAL")
        if not strip.elements or not strip.elements[0].orig_width:
            raise MovieError("not a movie")
        # A movie that says which colours it has would be converted.
        strip.colorspace_settings.name = "sRGB"
        scene.sequencer_colorspace_settings.name = "sRGB"
        scene.display_settings.display_device = "sRGB"
        scene.view_settings.view_transform = "Standard"
        scene.view_settings.look = "None"
        scene.render.image_settings.color_management = "FOLLOW_SCENE"
        scene.render.use_sequencer = True
        scene.render.use_compositing = False
        scene.render.dither_intensity = 0
        yield scene, strip
    except RuntimeError as error:
        raise MovieError(str(error)) from error
    finally:
        bpy.data.scenes.remove(scene)


def bmp_pixels(path: Path) -> NDArray[np.uint8]:
    """The pixels of a BMP with 24 bits, which has its rows from below, in blue, green, red, and in steps of 4 bytes."""
    content = np.fromfile(path, np.uint8)
    start, width, height = (int(content[at : at + 4].view("<u4")[0]) for at in (10, 18, 22))
    stride = -(-3 * width // 4) * 4
    rows = content[start : start + height * stride].reshape(height, stride)
    return rows[::-1, : 3 * width].reshape(height, width, 3)[..., ::-1]


def _tiff_pixels(path: Path, width: int, height: int) -> NDArray[np.uint16]:
    """The pixels of a TIFF with 48 bits, uncompressed and little-endian."""
    content = path.read_bytes()
    folder = int.from_bytes(content[4:8], "little")
    entry = np.dtype([("tag", "<u2"), ("kind", "<u2"), ("count", "<u4"), ("value", "<u4")])
    entries = np.frombuffer(content, entry, int.from_bytes(content[folder : folder + 2], "little"), folder + 2)
    strips = entries[entries["tag"] == _STRIP_OFFSETS][0]
    start = strips["value"] if strips["count"] == 1 else np.frombuffer(content, "<u4", 1, strips["value"])[0]
    return np.frombuffer(content, "<u2", height * width * 3, start).reshape(height, width, 3)
