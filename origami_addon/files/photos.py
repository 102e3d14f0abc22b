"""The photos of one document: found, checked, decoded."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import UnusablePhotos, UsageError
from ...core.sparse_model import FEWEST_VIEWS
from .photo_metadata import read_metadata

Image = NDArray[np.uint8] | NDArray[np.uint16]

EXTENSIONS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp")
# As many as must see a point.
FEWEST_PHOTOS = FEWEST_VIEWS
# Kinds of files that cameras and phones write and that not every Blender can decode.
_OTHER_KINDS = frozenset(
    ".heic .heif .hif .avif .jxl .jp2 .j2k .bmp .gif .dng .raw .cr2 .cr3 .crw .nef .nrw .arw .raf .orf .rw2 .pef .srw "
    ".3fr .iiq .x3f .pdf".split()
)
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
        Pixels as stored, EXIF rotation not applied.
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


def gather(paths: str | Path | Iterable[str | Path], fewest: int = FEWEST_PHOTOS) -> tuple[list[Photo], list[str]]:
    """The usable photos among ``paths``, in natural order, and a sentence about each file left out.

    Parameters
    ----------
    paths : path or iterable of paths
        Folders (their photos, not those in subfolders) and files.
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
    files, warnings = _files(paths)
    photos: list[Photo] = []
    first_with: dict[str, Path] = {}
    copies: dict[Path, list[Path]] = {}
    for path, name in zip(files, short_names(files)):
        try:
            photo, content = _inspect(path, name)
        except UnusablePhotos as error:
            warnings.append(str(error))
            continue
        if content in first_with:
            copies.setdefault(first_with[content], []).append(path)
            continue
        first_with[content] = path
        photos.append(photo)
    for original, others in copies.items():
        same = ", ".join(other.name for other in others)
        warnings.append(f"{same} shows the same as {original.name}, pixel for pixel, and is left out.")
    if not photos and fewest == 1:
        raise UnusablePhotos(" ".join([f"None of the {len(files)} files can be used as a photo.", *warnings]))
    if len(photos) < fewest:
        raise UnusablePhotos(_too_few(len(files), photos, copies, warnings))
    return photos, warnings


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
        If the file has become unreadable.
    """
    pixels = _decode(photo.path)
    if pixels.shape[:2] != (photo.height, photo.width):
        raise UnusablePhotos(f"{photo.path.name} changed during the run: leave the photos alone and run again.")
    return pixels


def _files(paths: str | Path | Iterable[str | Path]) -> tuple[list[Path], list[str]]:
    """The files to inspect, in natural order, and a sentence about each folder with pictures of other kinds."""
    given = [paths] if isinstance(paths, str | Path) else list(paths)
    if not given:
        raise UsageError("No photos were given: name a folder of photos, or at least three files.")
    files: list[Path] = []
    warnings: list[str] = []
    for path in map(Path, given):
        if path.is_dir():
            visible = [file for file in path.iterdir() if file.is_file() and not file.name.startswith(".")]
            inside = [file for file in visible if file.suffix.lower() in EXTENSIONS]
            others = Counter(kind for file in visible if (kind := file.suffix.lower()) in _OTHER_KINDS)
            if others:
                counts = ", ".join(f"{count} {kind}" for kind, count in sorted(others.items()))
                warnings.append(
                    f"Origami cannot read some pictures in {path.name} and leaves them out ({counts}): save them as "
                    "JPEG to use them."
                )
            if not inside and len(given) == 1:
                kinds = " ".join(EXTENSIONS)
                raise UnusablePhotos(
                    " ".join([f"There are no photos in {path}: use files of these kinds: {kinds}.", *warnings])
                )
            files += inside
        elif path.is_file():
            files.append(path)
        else:
            raise UsageError(f"There is no file or folder {path}: check the path.")
    return sorted(dict.fromkeys(file.absolute() for file in files), key=_natural), warnings


def _natural(path: Path) -> list[Any]:
    """Sorts 2.jpg before 10.jpg."""
    parts = re.split(r"(\d+)", str(path).lower())
    return [(part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts]


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


def _inspect(path: Path, name: str) -> tuple[Photo, str]:
    """The photo at ``path`` and a digest of its pixels."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UnusablePhotos(f"{path.name} cannot be read ({error.strerror}) and is left out.") from error
    if not data:
        raise UnusablePhotos(f"{path.name} is empty (zero bytes) and is left out: copy it again.")
    metadata = read_metadata(data)
    if not metadata.whole:
        raise UnusablePhotos(f"{path.name} is cut short and is left out: copy it again.")
    if metadata.orientation in _MIRRORING:
        raise UnusablePhotos(
            f"{path.name} is marked as mirrored (EXIF orientation {metadata.orientation}) and is left out, because "
            "its print may be reversed; use the photo as the camera took it, or save it the right way round."
        )
    pixels = _decode(path)
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
    return photo, f"{width} {pixels.dtype} {hashlib.sha256(pixels.tobytes()).hexdigest()}"


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


def _decode(path: Path) -> Image:
    """Pixels of the file, decoded by OpenImageIO if Blender has its Python module, otherwise by Blender itself."""
    try:
        return _decode_with_oiio(path)
    except ImportError:
        return _decode_with_blender(path)


def _decode_with_oiio(path: Path) -> Image:
    import bpy

    bpy.utils.expose_bundled_modules()
    import OpenImageIO as oiio

    wanted = oiio.ImageSpec()
    wanted.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), wanted)
    if source is None:
        oiio.geterror()
        raise UnusablePhotos(f"{path.name} is not a photo that can be decoded and is left out.")
    deep = source.spec().format != oiio.UINT8
    pixels = source.read_image(oiio.UINT16 if deep else oiio.UINT8)
    failed = source.has_error
    if failed:
        source.geterror()
    source.close()
    if pixels is None or failed:
        raise UnusablePhotos(f"{path.name} is damaged and is left out: copy it again.")
    return _three_channels(pixels)


def _decode_with_blender(path: Path) -> Image:
    import bpy

    image = bpy.data.images.load(str(path), check_existing=False)
    try:
        image.colorspace_settings.name = "Non-Color"
        image.alpha_mode = "CHANNEL_PACKED"
        width, height = image.size
        values = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(values)
        if not values.size or not image.has_data:
            raise UnusablePhotos(f"{path.name} is not a photo that can be decoded and is left out.")
        values = values.reshape(height, width, image.channels)[::-1]
        if image.is_float:
            return _three_channels((values * 65535 + 0.5).clip(0, 65535).astype(np.uint16))
        return _three_channels((values * 255 + 0.5).clip(0, 255).astype(np.uint8))
    finally:
        bpy.data.images.remove(image)


def _three_channels(pixels: Image) -> Image:
    pixels = pixels.reshape(*pixels.shape[:2], -1)
    return pixels[..., :3].copy() if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
