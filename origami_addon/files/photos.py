"""The photos of one document: found, checked, read."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ...core.errors import UnusablePhotos
from ...core.photos.bursts import ENOUGH, near_duplicates
from ...core.photos.view import View, view_of
from ...core.placing.photo import FEWEST_PHOTOS
from ..one_line import is_text
from .content_hash import sha256_of
from .decoded_photo import Image, decode
from .heif_boxes import HeifError
from .photo_files import photo_files, short_names
from .photo_metadata import read_metadata
from .picture_kinds import READ, kind_of_file, left_out

# EXIF orientations that mirror. Cameras do not write them; editors and selfie software do, some with mirrored pixels
# and some without. Reversed print would be worse than one photo fewer.
_MIRRORING = (2, 4, 5, 7)
_SMALLEST_SIDE = 100
_HOW_TO = "photograph the whole sheet sharply from 5 to 10 places around it"


@dataclass(frozen=True)
class Photo:
    """One usable photo.

    Attributes
    ----------
    path : Path
    name : str
        Unique in the document: the file name, with as many folders as necessary.
    width, height : int
        Pixels as stored, EXIF rotation not applied. In HEIC and AVIF, where it does not count: as shown.
    sha256 : str
        Of the file.
    orientation : int
        EXIF orientation: 1, 3, 6 or 8, the pure turns.
    focal_length_pixels : float or None
        From EXIF.
    make, model, taken : str
        From EXIF; empty if missing.
    icc_profile : bytes or None
        The colour profile of the pixels; None means sRGB.
    """

    path: Path
    name: str
    width: int
    height: int
    sha256: str
    orientation: int
    focal_length_pixels: float | None
    make: str
    model: str
    taken: str
    icc_profile: bytes | None


def gather(
    paths: str | Path | Iterable[str | Path], *, recursive: bool = False, fewest: int = FEWEST_PHOTOS
) -> tuple[list[Photo], list[str]]:
    """The usable photos among ``paths``, in natural order, and a sentence about each file left out.

    Parameters
    ----------
    paths : path or iterable of paths
        Folders and files.
    recursive : bool
        Also take the photos in subfolders.
    fewest : int
        How many photos are needed.

    Returns
    -------
    photos : list of Photo
    warnings : list of str

    Raises
    ------
    UsageError
        If no path is given, or one does not exist.
    UnusablePhotos
        If fewer usable photos are left.
    """
    files, warnings = photo_files([paths] if isinstance(paths, str | Path) else paths, recursive=recursive)
    photos: list[Photo] = []
    first_with: dict[str, Path] = {}
    copies: dict[Path, list[Path]] = {}
    views: list[View] = []
    for path, name in zip(files, short_names(files)):
        try:
            photo, pixels = _inspect(path, name)
        except UnusablePhotos as error:
            warnings.append(str(error))
            continue
        content = f"{photo.width} {pixels.dtype} {hashlib.sha256(pixels.tobytes()).hexdigest()}"
        if content in first_with:
            copies.setdefault(first_with[content], []).append(path)
            continue
        first_with[content] = path
        photos.append(photo)
        if len(files) > ENOUGH:
            views.append(view_of(pixels))
    for original, same_files in copies.items():
        same = ", ".join(other.name for other in same_files)
        warnings.append(f"{same} shows the same as {original.name}, pixel for pixel, and is left out.")
    if not photos and fewest == 1:
        raise UnusablePhotos(" ".join([f"None of the {len(files)} files can be used as a photo.", *warnings]))
    if len(photos) < fewest:
        raise UnusablePhotos(_too_few(len(files), photos, copies, warnings))
    alike = near_duplicates(views)
    for kept in sorted(set(alike.values())):
        others = ", ".join(photos[each].name for each in sorted(alike) if alike[each] == kept)
        warnings.append(f"{others} shows nearly the same view as {photos[kept].name}, which is sharper: left out.")
    return [photo for index, photo in enumerate(photos) if index not in alike], warnings


def read_pixels(photo: Photo) -> Image:
    """Decode a photo.

    Returns
    -------
    (h, w, 3) uint8 or uint16 array
        In the photo's own colour profile (sRGB without one), EXIF rotation not applied. Grey photos become three equal
        channels, transparency is ignored.

    Raises
    ------
    UnusablePhotos
        If the file has become unreadable, or is another one than `gather` saw.
    """
    try:
        before = _state_of(photo.path)
        same = sha256_of(photo.path) == photo.sha256
        pixels = decode(photo.path) if same else None
        same = same and _state_of(photo.path) == before
    except OSError as error:
        raise UnusablePhotos(
            f"{photo.path.name} cannot be read ({error.strerror}): put its file back as it was, and run again."
        ) from error
    if pixels is None or not same:
        raise UnusablePhotos(f"{photo.path.name} changed during the run: leave the photos alone and run again.")
    return pixels


def _inspect(path: Path, name: str) -> tuple[Photo, Image]:
    """The photo at ``path`` and its pixels."""
    if not is_text(path):
        raise UnusablePhotos(
            f"{path.name} is left out: its name, or that of its folder, is not text in this system's encoding (UTF-8), "
            "and Blender cannot open it; rename it."
        )
    try:
        before = _state_of(path)
        if not path.stat().st_size:
            raise UnusablePhotos(f"{path.name} is empty (zero bytes) and is left out: copy it again.")
        kind = kind_of_file(path)
        if kind not in READ:
            raise UnusablePhotos(left_out(path.name, kind))
        data = path.read_bytes()
    except OSError as error:
        raise UnusablePhotos(f"{path.name} cannot be read ({error.strerror}) and is left out.") from error
    try:
        metadata = read_metadata(data)
    except HeifError as error:
        raise UnusablePhotos(f"{path.name} {error}") from error
    if not metadata.whole:
        raise UnusablePhotos(f"{path.name} is cut short and is left out: copy it again.")
    if metadata.orientation in _MIRRORING:
        raise UnusablePhotos(
            f"{path.name} is marked as mirrored (EXIF orientation {metadata.orientation}) and is left out, because "
            "its print may be reversed; use the photo as the camera took it, or save it the right way round."
        )
    pixels = decode(path)
    if _state_of(path) != before:
        raise UnusablePhotos(f"{path.name} changed while it was read and is left out: wait until it is copied.")
    height, width = pixels.shape[:2]
    if min(height, width) < _SMALLEST_SIDE:
        raise UnusablePhotos(f"{path.name} is too small ({width} x {height} pixels) and is left out.")
    photo = Photo(
        path,
        name,
        width,
        height,
        hashlib.sha256(data).hexdigest(),
        metadata.orientation,
        metadata.focal_length_pixels(width, height),
        metadata.make,
        metadata.model,
        metadata.taken,
        metadata.icc_profile,
    )
    return photo, pixels


def _state_of(path: Path) -> tuple[int, ...]:
    """What changes when a file is written or replaced.

    Raises
    ------
    OSError
    """
    status = path.stat()
    return status.st_ino, status.st_size, status.st_mtime_ns


def _too_few(given: int, photos: list[Photo], copies: dict[Path, list[Path]], warnings: list[str]) -> str:
    if copies and len(photos) == 1:
        original, others = next(iter(copies.items()))
        return (
            f"The same photo was given {len(others) + 1} times ({original.name}), but only photos from different "
            f"places show the shape of the sheet; {_HOW_TO}."
        )
    left_out = " ".join(warnings)
    usable = f"{len(photos)} of {given} files can be used, but at least {FEWEST_PHOTOS} photos are needed: {_HOW_TO}."
    return f"{usable} {left_out}".strip()
