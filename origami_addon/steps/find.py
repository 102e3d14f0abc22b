"""Find the sheet: its region, its reference photo, the paper's edge, and the points on the paper."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import UnusablePhotos
from ...core.paper.outline import Outline
from ...core.paper.reference_outline import find_reference_outline, given_outline
from ...core.paper.sheet_choice import choose_sheet
from ...core.paper.sheet_points import points_on_sheet
from ...core.paper.sheet_search import FoundSheet, find_sheets
from ...core.sparse_model import SparseModel
from ...core.watch import SILENT, Watch
from ..feasibility import check_reference
from ..files.kept import Arrays, kept
from ..files.photo_pixels import PhotoPixels, ReducedPhotos
from ..files.photos import Photo
from ..stages import about
from ..state import Region, edge_arrays, edges_from_arrays, sheets_arrays, sheets_from_arrays
from .work import Work, key_with_photos


def find_sheet(
    model: SparseModel,
    work: Work,
    watch: Watch = SILENT,
    *,
    one_of_all: bool = False,
    other: int = 0,
    without: Sequence[str] = (),
) -> Region:
    """Choose the reference photo, find the paper in it, and the points that lie on the paper.

    With ``one_of_all``, the other sheets in view get a page too, so no warning mentions them. ``other`` is 0 for the
    sheet in the settings, n for the n-th likeliest region outside the sheets in view. Photos named in ``without`` are
    not chosen as the reference.

    Raises
    ------
    UsageError
        If the settings name a reference photo that is not there, or an outline or creases that do not lie in it.
    UnusablePhotos
        If the reference photo that the settings name could not be placed.
    StepFailed
        If no sheet is found, or there is no such other region.
    """
    pixels, settings, report = PhotoPixels(work.photos, model), work.settings, work.report
    asked = settings.reference, settings.sheet, settings.outline, other, list(without)
    key = key_with_photos(pixels, model, *asked)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        named = check_reference(work.photos, settings)
        reference = None if named is None else _index_of(named, model)
        if settings.outline is None:
            small = ReducedPhotos(pixels)
            sheets = _sheets_in_view(pixels, small, model, work, watch.part(0, 0.6))
            in_view = [sheet.outline for sheet in sheets]
            assert settings.sheet != "all"
            sheet = choose_sheet(model, small, sheets, settings.sheet, other)
            barred = {index for index, camera in enumerate(model.cameras) if camera.name in without}
            found = find_reference_outline(
                model,
                pixels,
                small,
                sheet,
                reference=reference,
                without=barred,
                threads=settings.sfm.threads,
                watch=watch.part(0.6, 1),
            )
            reference, outline = found.reference, found.outline
            search = {
                "sheet_probability": sheet.probability,
                "hypotheses_agreement": sheet.agreement,
                "outlines_tried": {model.cameras[index].name: sure for index, sure in found.tried.items()},
                "sheets_in_view": len(sheets),
            }
        else:
            assert reference is not None
            in_view, search = [], {}
            outline = given_outline(np.array(settings.outline))
        watch.step(0.9, "Separating the sheet's points from the table's")
        arrays = {"polygon": outline.polygon, "on_sheet": points_on_sheet(model, reference, outline)}
        arrays |= edge_arrays(in_view)
        notes = {"reference": reference, "confidence": outline.confidence, "notes": outline.notes, "search": search}
        return arrays, notes

    with report.stage(about("find").reported) as figures:
        arrays, notes = kept(work.folder, "region", key, compute, work.report.warn)
        outline = Outline(arrays["polygon"], notes["confidence"], tuple(notes["notes"]))
        name = model.cameras[notes["reference"]].name
        figures |= {
            "reference": name,
            "outline_confidence": outline.confidence,
            "points_on_sheet": int(arrays["on_sheet"].sum()),
        }
        figures |= notes["search"]
        report.warn(*outline.notes)
        in_view = edges_from_arrays(arrays)
        if settings.sheet == 1 and len(in_view) > 1 and not one_of_all:
            report.warn(_others(len(in_view)))
        return Region(notes["reference"], outline, arrays["on_sheet"], in_view)


def sheets_in_view(model: SparseModel, work: Work, watch: Watch = SILENT) -> tuple[FoundSheet, ...]:
    """All sheets in view, in the order of their numbers.

    Raises
    ------
    StepFailed
    UnusablePhotos
        If a placed photo is gone or has another size.
    """
    pixels = PhotoPixels(work.photos, model)
    return _sheets_in_view(pixels, ReducedPhotos(pixels), model, work, watch)


def _sheets_in_view(
    pixels: PhotoPixels, small: ReducedPhotos, model: SparseModel, work: Work, watch: Watch
) -> tuple[FoundSheet, ...]:
    key = key_with_photos(pixels, model)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        watch.step(0, "Looking for the sheet in all photos")
        found = find_sheets(model, list(small))
        return sheets_arrays(found), {}

    arrays, _ = kept(work.folder, "sheets", key, compute, work.report.warn)
    return sheets_from_arrays(arrays)


def _index_of(photo: Photo, model: SparseModel) -> int:
    """Index of the photo's camera."""
    for index, camera in enumerate(model.cameras):
        if camera.name == photo.name:
            return index
    raise UnusablePhotos(f"The reference photo {photo.name} could not be placed; choose another one, or none.")


def _others(sheets: int) -> str:
    numbers = "2" if sheets == 2 else f"2 to {sheets}"
    return (
        f"{sheets} sheets are in view; the one in the middle that most photos show was taken. Choose another by its "
        f"number, {numbers} (--sheet, or Sheet in Blender)."
    )
