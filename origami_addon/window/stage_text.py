"""What the panel says of a stage: whether it is up to date, and its result in a line or two."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..scene.document import Document
from ..scene.mended import mended
from ..scene.properties import settings_to_json
from ..scene.stale import ALL, EFFECT, settings_of


@dataclass(frozen=True)
class StageState:
    """How a stage stands.

    Attributes
    ----------
    text : str
    icon : str
        Blender's name of it.
    """

    text: str
    icon: str


def state_of(document: Document, stage: str) -> StageState:
    """How a stage of the document stands, without reading the scene's meshes."""
    group = document.collection.origami
    told = getattr(group, stage)
    if not told.done:
        return StageState("Not done yet", "RADIOBUT_OFF")
    if any(ALL.index(EFFECT[each]) <= ALL.index(stage) for each in mended(document)):
        return StageState("Edited by hand: run on from there", "FILE_REFRESH")
    settings = settings_to_json(group.settings)
    if told.settings != settings_of(stage, settings):
        return StageState("Other settings since: run it again", "FILE_REFRESH")
    return StageState(f"Done in {told.seconds:.1f} s", "CHECKMARK")


def summary(stage: str, figures: dict[str, Any]) -> list[str]:
    """The result of a stage in a line or two; none where it has no figures."""
    return _SUMMARIES[stage](figures) if figures else []


def crease_text(angle: float | None) -> str:
    """What a crease is, by its fold angle in degrees; None where that could not be measured."""
    if angle is None:
        return "fold unknown"
    return f"{'valley' if angle > 0 else 'mountain'}, {abs(angle):.0f}°"


def _place(figures: dict[str, Any]) -> list[str]:
    return [
        f"{figures['photos_placed']} of {figures['photos']} photos placed",
        f"{figures['points']} points, {figures['reprojection_error_mean_px']:.2f} px off",
    ]


def _find(figures: dict[str, Any]) -> list[str]:
    return [
        f"In {figures['reference']}, edge {100 * figures['outline_confidence']:.0f} % sure",
        f"{figures['points_on_sheet']} points on the paper",
    ]


def _surface(figures: dict[str, Any]) -> list[str]:
    residual = 100 * figures["residual_median_page_lengths"]
    return [
        f"{figures['creases']} creases, {figures['vertices']} vertices",
        f"{residual:.3f} % of the page off the points",
    ]


def _unwrap(figures: dict[str, Any]) -> list[str]:
    worst, flipped = 100 * figures["stretch_95th_percentile"], figures["flipped_triangles"]
    return [
        f"Stretch {100 * figures['stretch_median']:.2f} % (median)",
        f"{worst:.2f} % in the worst twentieth",
        *([f"{flipped} triangles upside down"] if flipped else []),
    ]


def _lay_out(figures: dict[str, Any]) -> list[str]:
    unit = "mm" if figures["unit"] == "mm" else "page heights"
    return [f"{figures['width']:.4g} x {figures['height']:.4g} {unit}"]


def _page(figures: dict[str, Any]) -> list[str]:
    exact = "" if figures["dpi_source"] == "paper size" else " (assumed)"
    return [f"{figures['width_px']} x {figures['height_px']} pixels, {figures['dpi']:.0f} dpi{exact}"]


_SUMMARIES = {
    "place": _place,
    "find": _find,
    "surface": _surface,
    "unwrap": _unwrap,
    "lay_out": _lay_out,
    "page": _page,
}
