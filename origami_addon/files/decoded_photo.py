"""A photo's pixels, decoded by OpenImageIO or by Blender."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.errors import UnusablePhotos
from .heif import MOST_PIXELS, read_heif
from .heif_boxes import HeifError
from .heif_pixels import decode_heif
from .kept_pixels import KeptPixels
from .picture_kinds import AVIF, HEIC, kind_of_file

Image = NDArray[np.uint8] | NDArray[np.uint16]
_kept = KeptPixels()


def decode(path: Path) -> Image:
    """The pixels of a photo's file, decoded by OpenImageIO if Blender has its Python module, otherwise by Blender.

    Returns
    -------
    (h, w, 3) uint8 or uint16 array
        In the photo's own colour profile. EXIF rotation is not applied; HEIC and AVIF are as shown.

    Raises
    ------
    UnusablePhotos
    OSError
    """
    if kind_of_file(path) in (HEIC, AVIF):
        return _decode_heif(path)
    try:
        return _decode_with_oiio(path)
    except ImportError:
        return _decode_with_blender(path)


def _decode_heif(path: Path) -> Image:
    data = path.read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    pixels = _kept.get(digest)
    if pixels is None:
        try:
            pixels = decode_heif(read_heif(data))
        except HeifError as error:
            raise UnusablePhotos(f"{path.name} {error}") from error
        _kept.keep(digest, pixels)
    return pixels


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
    width, height = source.spec().width, source.spec().height
    if width * height > MOST_PIXELS:
        source.close()
        raise UnusablePhotos(
            f"{path.name} claims to have {width} x {height} pixels, more than any camera's photo, and is left out: "
            "save it smaller."
        )
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
