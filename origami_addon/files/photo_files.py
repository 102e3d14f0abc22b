"""Which files are photos, among those that the user names and those in the folders that the user names."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from ...core.errors import UnusablePhotos, UsageError
from .marker import MARKER
from .picture_kinds import EXTENSIONS, MOVIE, RAW, RAW_ADVICE, READ, UNKNOWN, kind_of_file

# Files looked at to say that the photos are in subfolders: more would take seconds if a whole disk was named.
_MOST_LOOKED_AT = 2000
_MOST_NAMED = 3


def photo_files(paths: Iterable[str | Path], *, recursive: bool) -> tuple[list[Path], list[str]]:
    """The files to inspect, in natural order, and a sentence about each folder with pictures of other kinds.

    Parameters
    ----------
    paths : iterable of paths
        Folders and files.
    recursive : bool
        Also look in the folders' subfolders, except hidden ones and those with Origami's results.

    Raises
    ------
    UsageError
        If no path is given, or one does not exist.
    UnusablePhotos
        If a folder is the only path and has no photos.
    """
    given = [Path(path) for path in paths]
    if not given:
        raise UsageError("No photos were given: name a folder of photos, or at least three files.")
    files: list[Path] = []
    warnings: list[str] = []
    for path in given:
        if path.is_dir():
            inside, sentences = photos_in(path, recursive=recursive)
            warnings += sentences
            if not inside and len(given) == 1:
                raise UnusablePhotos(" ".join([f"There are no photos in {path}: {instead(path)}.", *warnings]))
            files += inside
        elif path.is_file():
            files.append(path)
        elif path.exists():
            raise UsageError(f"{path} is a pipe or a device, not a photo: name files or folders.")
        else:
            raise UsageError(f"There is no file or folder {path}: check the path.")
    return sorted(dict.fromkeys(file.absolute() for file in files), key=_natural), warnings


def photos_in(folder: Path, *, recursive: bool) -> tuple[list[Path], list[str]]:
    """The photos in a folder, by their content or their name, and sentences about what is left out.

    A folder without photos gives its movies. Beside photos, a movie is more likely of something else, and the one of a
    live photo, which has the photo's name, is not worth a word.

    Raises
    ------
    UsageError
        If the folder cannot be read.
    """
    photos: list[Path] = []
    movies: list[Path] = []
    raw: Counter[str] = Counter()
    others: Counter[str] = Counter()
    unreadable: list[OSError] = []
    for file in _visible(folder, recursive, unreadable.append):
        kind = _kind(file)
        if _is_photo(file, kind):
            photos.append(file)
        elif kind == MOVIE:
            movies.append(file)
        elif kind != UNKNOWN:
            (raw if kind == RAW else others)[file.suffix.lower() or kind] += 1
    sentences = [f"The folder {error.filename} cannot be read ({error.strerror}): allow it." for error in unreadable]
    if unreadable and Path(unreadable[0].filename) == folder:
        raise UsageError(sentences[0])
    for found, advice in ((raw, RAW_ADVICE), (others, "save them as JPEG to use them")):
        if found:
            counts = ", ".join(f"{count} {kind}" for kind, count in sorted(found.items()))
            sentences.append(
                f"Origami cannot read some pictures in {folder.name} and leaves them out ({counts}): {advice}."
            )
    if not photos:
        return movies, sentences
    photographed = {photo.with_suffix("") for photo in photos}
    beside = [movie.name for movie in movies if movie.with_suffix("") not in photographed]
    if beside:
        named = ", ".join(beside[:_MOST_NAMED]) + (" and others" if len(beside) > _MOST_NAMED else "")
        sentences.append(f"{folder.name} holds photos, so its movies are left out ({named}): name a movie to use it.")
    return photos, sentences


def is_photo(file: Path) -> bool:
    """Whether a file is a photo by its content, or by its name alone, as a damaged one is."""
    return _is_photo(file, _kind(file))


def _is_photo(file: Path, kind: str) -> bool:
    return kind in READ or file.suffix.lower() in EXTENSIONS


def _kind(file: Path) -> str:
    try:
        return kind_of_file(file)
    except OSError:
        return UNKNOWN


def instead(folder: Path) -> str:
    """What to do with a folder without photos: where they are inside it, or what they should be."""
    looked_at = islice(_visible(folder, True, lambda error: None), _MOST_LOOKED_AT)
    found = Counter(file.relative_to(folder).parts[0] for file in looked_at if file.suffix.lower() in EXTENSIONS)
    if not found:
        return f"use files of these kinds: {' '.join(EXTENSIONS)}"
    named = " and ".join(sorted(found)[:_MOST_NAMED]) + (" and others" if len(found) > _MOST_NAMED else "")
    return (
        f"they are in folders inside it ({named}); name one of these, or take the photos of all with --recursive (in "
        "Blender: Subfolders)"
    )


def short_names(files: Sequence[Path]) -> list[str]:
    """File names, each with as many of its folders as necessary to make it unique.

    Parameters
    ----------
    files : sequence of Path

    Returns
    -------
    list of str
        For each file.
    """
    names = [file.name for file in files]
    for depth in range(2, max((len(file.parts) for file in files), default=1) + 1):
        clashing = {name for name in names if names.count(name) > 1}
        names = ["/".join(f.parts[-depth:]) if name in clashing else name for f, name in zip(files, names)]
    return names


def _visible(folder: Path, recursive: bool, unreadable: Callable[[OSError], None]) -> Iterator[Path]:
    """The files in a folder and perhaps in those inside it, without what is hidden and without results."""
    for place, folders, names in os.walk(folder, onerror=unreadable):
        here = Path(place)
        yield from (here / name for name in sorted(names) if not name.startswith(".") and (here / name).is_file())
        seen = [each for each in sorted(folders) if not each.startswith(".")]
        folders[:] = [each for each in seen if not (here / each / MARKER).exists()]
        if not recursive:
            return


def _natural(path: Path) -> list[Any]:
    """Sorts 2.jpg before 10.jpg."""
    parts = re.split(r"(\d+)", str(path).lower())
    return [(part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts]
