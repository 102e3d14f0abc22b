"""Pages of other photos of the same sheet: in ultraviolet, infrared or raking light, after treatment, or better."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.camera import Camera
from ..core.errors import UnusablePhotos, UsageError
from ..core.fusion.other_light import PageEdges, fuse_on_page
from ..core.page.photo_colors import Photo as Pixels
from ..core.page.raster import interpolate, page_lookup
from ..core.page.texture import PageTexture
from ..core.sparse_model import camera_arrays, cameras_from_arrays
from ..core.watch import SILENT, Watch
from .export.output import Finished
from .export.outputs import sheet_with_page
from .files.kept import Arrays, digest_of, key_of
from .files.photo_pixels import PhotoPixels
from .files.photos import Photo, gather, read_pixels
from .sfm.page_client import OnPage, place_on_page
from .sfm.worker_process import worker_source
from .state import Page, Paged
from .steps.page import as_photographed
from .steps.work import OTHER_IMAGE, Work, code, kept_image

# A sheet is in another shape if its print lies so far from where the page's shape puts it (95th percentile, parts of
# the page's longer side); if this many of its matches, as a share of those that agree, agree with another camera; or if
# that share of the matches is so far (parts of the photo's longer side) from where the print's camera puts them.
# On rendered sheets of the same shape, print was .0002 to .0012 off.
_FARTHEST_OFF, _MOST_CONTRARY, _MOST_ASTRAY, _ASTRAY = 0.004, 0.1, 0.15, 0.002
# Below this share of the print aligned, a warning says so.
_LITTLE_ALIGNED = 0.5
OTHER_PHOTOS = "lay other photos"  # the step, as the report names it


@dataclass(frozen=True)
class OtherPhotos:
    """Photos that get a page of their own; ``name`` is what the user calls them."""

    name: str
    photos: Sequence[Photo]
    warnings: Sequence[str]


@dataclass(frozen=True)
class OtherPage:
    """The page of other photos: the state of the page's document with these photos' cameras and page image."""

    photos: OtherPhotos
    state: Paged


@dataclass(frozen=True)
class _Laid:
    """A photo on the page, with figures for the report; without a camera, ``failure`` says why."""

    camera: Camera | None
    figures: dict[str, Any]
    failure: str = ""
    moved: bool = False


def gather_others(paths: Sequence[Path], *, recursive: bool = False) -> list[OtherPhotos]:
    """The photos of each folder (or file), named after it.

    With ``recursive``, also those in its subfolders.

    Raises
    ------
    UsageError
        If two have the same name.
    UnusablePhotos
        If a folder has no usable photo.
    """
    names = [Path(os.path.abspath(path)).name if path.is_dir() else path.stem for path in paths]  # of ../uv/.. too
    twice = [name for name, count in Counter(name.lower() for name in names).items() if count > 1]
    if twice:
        raise UsageError(
            f"Two folders of other photos are called {twice[0]}, and their pages are named after them: rename one."
        )
    return [
        OtherPhotos(name, *gather(path, recursive=recursive, fewest=1)) for name, path in zip(names, paths, strict=True)
    ]


def lay_other_photos(state: Paged, others: OtherPhotos, work: Work, watch: Watch = SILENT) -> OtherPage:
    """The page of other photos, pixel by pixel on the page that there is. Its light stays as photographed.

    Parameters
    ----------
    state : Paged
    others : OtherPhotos
    work : Work
        With which the page was made.
    watch : Watch

    Raises
    ------
    Cancelled, StepFailed
    UnusablePhotos
        If none of them shows the sheet as it is on the page.
    """
    height, width = state.page.texture.image.shape[:2]
    pixels = PhotoPixels(work.photos, state.model)
    report, settings, photos = work.report, work.settings.sfm, others.photos
    with report.stage(OTHER_PHOTOS) as figures:
        report.warn(*_about(others, others.warnings))
        # not in its own light, which a setting changes
        page = as_photographed(state, work, pixels, (width, height), watch.part(0, 0.1))[0].image
        contents = [(photo.name, photo.sha256) for photo in photos]
        how = asdict(replace(settings, threads=1))
        key = key_of(code(), worker_source().decode(), contents, digest_of(page, state.flat.uv), how)

        def compute() -> tuple[Arrays, dict[str, Any]]:
            edges = PageEdges(state.sheet, state.flat, page)
            laid = _lay_each(state, page, photos, edges, work, watch.part(0.1, 0.7))
            placed = [photo for photo, each in zip(photos, laid, strict=True) if each.camera is not None]
            cameras = [each.camera for each in laid if each.camera is not None]
            notes: dict[str, Any] = {
                "photos": {photo.name: each.figures for photo, each in zip(photos, laid, strict=True)},
                "left_out": [each.failure for each in laid if each.camera is None],
                "moved": any(each.moved for each in laid),
            }
            if not cameras:
                return {}, notes
            texture = fuse_on_page(
                edges,
                state.flat,
                cameras,
                lambda index: read_pixels(placed[index]),
                (width, height),
                settings.threads,
                watch.part(0.7, 1),
            )
            arrays = {"image": texture.image, "photo": texture.photo, "position": texture.position}
            return arrays | camera_arrays(cameras), notes | {"blank_share": texture.blank_share}

        arrays, notes = kept_image(work, OTHER_IMAGE, key, compute)
        if not arrays:
            raise UnusablePhotos(_none_placed(others, notes["moved"], notes["left_out"]))
        report.warn(*_about(others, [*notes["left_out"], *_little_aligned(notes["photos"])]))
        figures |= {"name": others.name, "photos": notes["photos"], "blank_share": notes["blank_share"]}
        texture = PageTexture(arrays["image"], arrays["photo"], arrays["position"], notes["blank_share"])
        paged = replace(state, cameras=cameras_from_arrays(arrays), page=Page(texture, state.page.dpi, texture.image))
        return OtherPage(others, paged)


def finished_other(page: OtherPage, folder: Path) -> Finished:
    """Everything that the files of a page of other photos are made from; they will be in ``folder``."""
    first = page.photos.photos[0]
    return Finished(
        page.state,
        title=page.photos.name,
        photo=lambda: read_pixels(first),
        profile=first.icc_profile,
        bits=None,
        make_object=lambda done: sheet_with_page(done, folder),
        home=folder,
    )


def _lay_each(
    state: Paged, page: Pixels, photos: Sequence[Photo], edges: PageEdges, work: Work, watch: Watch
) -> list[_Laid]:
    """Place photos by their matches with the page, and then by all of its print."""
    settings = work.settings.sfm
    scale = min(settings.max_image_size / max(page.shape[:2]), 1)
    height, width = (max(round(length * scale), 1) for length in page.shape[:2])
    lookup = page_lookup(state.sheet, state.flat, (width, height))
    points = interpolate(lookup, state.sheet.triangles, state.sheet.vertices).astype(np.float32)
    folder = work.folder / "on_page"
    shutil.rmtree(folder, ignore_errors=True)
    found = place_on_page(photos, page, points, state.cameras, folder, settings, watch.part(0, 0.6))
    shutil.rmtree(folder, ignore_errors=True)
    laid: list[_Laid] = []
    for photo, each in zip(photos, found, strict=True):
        watch.step(0.6 + 0.4 * len(laid) / len(photos), f"Laying {photo.name} on the page")
        laid.append(_lay(photo, each, edges))
    return laid


def _lay(photo: Photo, found: OnPage, edges: PageEdges) -> _Laid:
    name = photo.name
    figures: dict[str, Any] = {"matches": len(found.agree), "agreeing": int(found.agree.sum())}
    unknown = f"{name} could not be placed on the page and is left out: their prints have too little in common."
    if found.camera is None:
        return _Laid(None, figures, unknown)
    figures["reprojection_error_px"] = found.error
    laid = edges.settle(found.camera, read_pixels(photo))
    if laid is None:
        return _Laid(None, figures, unknown)
    longest = max(photo.width, photo.height)
    astray = float((found.off(laid.camera) > _ASTRAY * longest).mean())
    contrary = found.contrary / figures["agreeing"]
    figures |= {
        "contrary_matches": found.contrary,
        "matches_astray_share": astray,
        "aligned_share": laid.aligned_share,
        "off_the_sheet": laid.off,
        "off_the_sheet_95th_percentile": laid.far_off,
        "focal_length_over_long_side": laid.camera.focal_length / longest,
    }
    if laid.far_off > _FARTHEST_OFF or contrary > _MOST_CONTRARY or astray > _MOST_ASTRAY:
        sentence = f"{name} is left out: it shows the sheet in another shape than the photos of the page do."
        return _Laid(None, figures, sentence, moved=True)
    return _Laid(laid.camera, figures)


def _about(others: OtherPhotos, sentences: Sequence[str]) -> list[str]:
    """Sentences that say which photos they mean: those of the page, or of another folder, may have the same names."""
    return [f"{others.name}: {sentence}" for sentence in sentences]


def _little_aligned(figures: dict[str, dict[str, Any]]) -> list[str]:
    """A sentence about each photo of which little print lies on the page's."""
    shares = {name: each["aligned_share"] for name, each in figures.items() if "aligned_share" in each}
    return [
        f"Only {100 * share:.0f} % of the print in {name} could be laid on the page's, perhaps because its light does "
        "not show the rest, which follows the shape of the sheet alone."
        for name, share in shares.items()
        if share < _LITTLE_ALIGNED
    ]


def _none_placed(others: OtherPhotos, moved: bool, left_out: Sequence[str]) -> str:
    """The failure if no photo could be laid on the page."""
    if not moved:
        return (
            f"None of the photos in {others.name} could be placed on the page: check that they show the same side of "
            "the same sheet, sharp and large, and that enough of its print is visible in their light."
        )
    cause = (
        f"The sheet was bent or unfolded between the page's photos and those in {others.name}: photograph it again "
        "in both lights without changing its shape, or rectify those photos on their own."
    )
    return " ".join([cause, *left_out])
