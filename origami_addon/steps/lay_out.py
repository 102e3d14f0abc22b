"""Lay out the page: straight, upright, and in true size if the paper's size is known."""

from __future__ import annotations

from dataclasses import asdict, astuple
from typing import Any

from ...core.checks.open_book import is_open_book
from ...core.checks.page_bound import page_within
from ...core.page.page import PaperSize, lay_out, other_shape
from ...core.page.upright_page import lay_out_upright, up_after, up_of_exif
from ...core.sheet import FlatMap, Sheet
from ...core.watch import SILENT, Watch
from ..files.kept import Arrays, kept
from ..files.photo_pixels import PhotoPixels
from ..stages import HALF_WITHIN, WITHIN, about
from ..state import Unwrapped
from .work import Work, digest_of_flat, key_with_photos

_OPEN_BOOK = (
    "The sheet bends like an open book, so both pages were probably taken for one sheet; for a single page, give its "
    "outline (--outline, or Edit Outline in Blender)."
)


def lay_out_page(state: Unwrapped, work: Work, watch: Watch = SILENT) -> FlatMap:
    """The page: straight, upright, and in true size if the paper's size is known."""
    sheet, uv, reference, settings = state.sheet, state.uv, state.sheet_reference, work.settings.page
    size = settings.paper_size_mm
    paper = None if size is None else PaperSize(*size)
    with work.report.stage(about("lay_out").reported) as figures:
        if settings.turn != "auto":
            flat = lay_out(sheet, uv, reference, up_after(int(settings.turn)), paper)
        else:
            flat = _upright(state, work, paper, figures, watch)
        figures |= {"width": flat.width, "height": flat.height, "unit": flat.unit} | _accuracy(sheet, flat)
        if is_open_book(sheet, flat.uv):
            work.report.warn(_OPEN_BOOK)
        if (shapes := other_shape(flat, paper)) is not None:
            work.report.warn(
                f"The page came out as 1 : {shapes[0]:.3f} and the paper size that was named is 1 : {shapes[1]:.3f}; "
                "check the size, or whether the whole sheet was found."
            )
        return flat


def _accuracy(sheet: Sheet, flat: FlatMap) -> dict[str, float | None]:
    """How far half of the page, and nine tenths of it, are at most from their place, in the page's unit."""
    half, most = page_within(sheet, flat, (0.5, 0.9)) or (None, None)
    return {HALF_WITHIN: half, WITHIN: most}


def _upright(state: Unwrapped, work: Work, paper: PaperSize | None, figures: dict[str, Any], watch: Watch) -> FlatMap:
    """The page, turned so that its text stands upright."""
    sheet, uv = state.sheet, state.uv
    pixels, index = PhotoPixels(work.photos, state.model), state.region.reference
    size = None if paper is None else astuple(paper)
    key = key_with_photos(pixels, state.model, digest_of_flat(state, uv), index, size)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        up = up_of_exif(pixels.photos[index].orientation)
        page = lay_out_upright(sheet, uv, state.cameras, pixels.__getitem__, index, up, paper, watch)
        flat = asdict(page.flat)
        text = {"quarter_turns_by_text": page.quarter_turns, "text_confidence": page.confidence}
        return {"uv": flat.pop("uv")}, {"flat": flat, "text": text}

    arrays, notes = kept(work.folder, "upright", key, compute, work.report.warn)
    figures |= notes["text"]
    return FlatMap(arrays["uv"], **notes["flat"])
