"""Make the page image, in its light and its colours."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from ...core.errors import UsageError
from ...core.fusion.fusion import fuse_page
from ...core.light.black_and_white import find_ink
from ...core.light.greyscale import greyscale
from ...core.light.looks import Relit, relit
from ...core.light.paper_figures import measure_paper
from ...core.numeric.image import Image
from ...core.page.resolution import resolution_of
from ...core.page.sampling import measure_sampling
from ...core.page.single_photo import page_of_photo
from ...core.page.texture import PageTexture
from ...core.page.warp import native_size
from ...core.sheet import FlatMap, Sheet
from ...core.watch import SILENT, Watch
from ..feasibility import check_page_bytes
from ..files.icc import luminance_shares
from ..files.image_files import PageImage
from ..files.kept import Arrays
from ..files.photo_pixels import PhotoPixels
from ..settings import LONGEST_PAGE_SIDE, Colour
from ..stages import about
from ..state import LaidOut, Page
from .work import PAGE_IMAGE, Work, digest_of_flat, kept_image, key_with_photos

# The figures of a fusion; a page of the reference photo alone has none.
_HEALING = ("burnt_share", "healed_share")
# Above this share of the page, a warning says how much of it is blank: a strip of 2 mm along the long side of A4.
_BLANK_WARNING = 0.01
# Share of the page that is burnt out in all photos, above which a warning says so: a square centimetre of A4.
_BURNT_WARNING = 0.002
_NO_BLANK_PAPER = (
    "The page stays in the light of the photos, because it has too little blank paper to know its light by; to avoid "
    "this warning, choose that light (--light as-photographed, or As Photographed in Blender)."
)


def make_page(state: LaidOut, work: Work, watch: Watch = SILENT) -> Page:
    """The page image.

    Raises
    ------
    UsageError
        If the page would have too many pixels.
    """
    cameras, region, sheet, flat = state.cameras, state.region, state.sheet, state.flat
    settings, report = work.settings.image, work.report
    with report.stage(about("page").reported) as figures:
        resolution = resolution_of(flat, native_size(sheet, flat, cameras[region.reference]), settings.dpi)
        size, dpi = resolution.size_px, resolution.dpi
        _check_size(size, settings.dpi)
        pixels = PhotoPixels(work.photos, state.model)
        check_page_bytes(*size, [pixels.photos[region.reference]])
        texture, healing = as_photographed(state, work, pixels, size, watch.part(0, 0.9))
        watch.step(0.9, "Taking the light off the page")
        page = relit(texture.image, texture.photo >= 0, sheet, flat, settings.light)
        profile = pixels.photos[region.reference].icc_profile
        texture = replace(texture, image=page.image)
        image = _in_colors(page.image, settings.colour, profile)
        if settings.light != "as-photographed" and page.paper is None:
            report.warn(_NO_BLANK_PAPER)
        burnt_share = healing["burnt_share"]
        if burnt_share is not None and burnt_share > _BURNT_WARNING:
            report.warn(
                f"{100 * burnt_share:.1f} % of the page is burnt out in every photo that shows it: any print there is "
                "lost; photograph it again, with the lamp farther to the side or with less exposure."
            )
        names = [camera.name for camera in cameras]
        used = np.unique(texture.photo[texture.photo >= 0])
        figures |= {
            "width_px": size[0],
            "height_px": size[1],
            "dpi": dpi,
            "dpi_source": "paper size" if resolution.known else "assumed",
            "photos_used": [names[index] for index in used],
            "photo_shares": {names[index]: float((texture.photo == index).mean()) for index in used},
            "blank_share": texture.blank_share,
            **healing,
            "paper_linear_rgb": None if page.paper is None else page.paper.tolist(),
            **_image_figures(texture, page, sheet, flat),
        }
        if texture.blank_share > _BLANK_WARNING:
            report.warn(
                f"{100 * texture.blank_share:.1f} % of the page stays white: it lies outside the outline that was "
                "found, or no photo used shows it; look at the outline (--outline, or Edit Outline in Blender), or try "
                "another reference photo."
            )
        return Page(texture, dpi, image)


def _check_size(size: tuple[int, int], dpi: float | None) -> None:
    """Refuse a page that would be too long for a file.

    Raises
    ------
    UsageError
    """
    if max(size) > LONGEST_PAGE_SIDE:
        raise UsageError(
            f"At {dpi:g} dpi the page would be {size[0]} x {size[1]} pixels; choose fewer, at most "
            f"{dpi * LONGEST_PAGE_SIDE / max(size):.0f}."
            if dpi
            else f"The page would be {size[0]} x {size[1]} pixels; choose another reference photo, or a resolution "
            "(--dpi, or Resolution in Blender)."
        )


def _in_colors(image: Image, colour: Colour, profile: bytes | None) -> PageImage:
    """The page (H, W, 3) as the setting asks: the same, grey (H, W), or black and white (H, W) with True for white."""
    if colour == "colour":
        return image
    grey = greyscale(image, luminance_shares(profile))
    return grey if colour == "grey" else ~find_ink(grey)


def as_photographed(
    state: LaidOut, work: Work, pixels: PhotoPixels, size: tuple[int, int], watch: Watch
) -> tuple[PageTexture, dict[str, float | None]]:
    """The page image in the photos' light, and the shares of it that are burnt out in every photo and healed by others.

    It is kept, so that another light does not blend the photos again.
    """
    sheet, flat, reference, source = state.sheet, state.flat, state.region.reference, work.settings.image.source
    key = key_with_photos(pixels, state.model, digest_of_flat(state, flat.uv), reference, size, source)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        if source == "reference":
            texture = page_of_photo(sheet, flat, state.cameras, pixels.__getitem__, reference, size)
            healing = dict.fromkeys(_HEALING)
        else:
            threads = work.settings.sfm.threads
            page = fuse_page(sheet, flat, state.cameras, pixels.__getitem__, reference, size, threads, watch)
            texture, healing = page.texture, {name: getattr(page, name) for name in _HEALING}
        arrays = {"image": texture.image, "photo": texture.photo, "position": texture.position}
        return arrays, {"blank_share": texture.blank_share, **healing}

    arrays, notes = kept_image(work, PAGE_IMAGE, key, compute)
    texture = PageTexture(arrays["image"], arrays["photo"], arrays["position"], notes["blank_share"])
    return texture, {name: notes[name] for name in _HEALING}


def _image_figures(texture: PageTexture, page: Relit, sheet: Sheet, flat: FlatMap) -> dict[str, Any]:
    """What an archive asks of a page image, as far as it can be measured without a target; null is unknown."""
    covered = texture.photo >= 0
    paper = None if page.blank is None else measure_paper(page.image, covered, page.blank)
    sampling = measure_sampling(texture, sheet, flat)
    return {
        "blank_paper_share": None if page.blank is None else float(page.blank.mean()),
        "paper_lab": None if paper is None else paper.color.tolist(),
        "paper_unevenness_lightness": None if paper is None else paper.unevenness,
        "paper_noise_lightness": None if paper is None else paper.noise,
        "photo_pixels_per_page_pixel": None if sampling is None else asdict(sampling),
    }
