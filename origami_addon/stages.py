"""The stages of a document in their order, with one table of all their texts.

The command line, jobs, panel, report and manual read it. `advance.py` does a stage's work; the settings that a stage
depends on name it in their declarations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

Stage = Literal["place", "find", "surface", "unwrap", "lay_out", "page"]
Figures = dict[str, Any]
STAGES: tuple[Stage, ...] = get_args(Stage)

# The figures of the layout that say how exact the page is, in its unit.
HALF_WITHIN, WITHIN = "half_of_the_page_within", "90_percent_of_the_page_within"
# The parts of a document that may be edited by hand, with the first stage that an edit affects; a moved frame waits to
# be applied.
Part = Literal["points", "outline", "vertices", "creases", "page", "frame"]
EFFECT: dict[Part, Stage] = {
    "points": "surface",
    "outline": "surface",
    "vertices": "unwrap",
    "creases": "unwrap",
    "page": "page",
    "frame": "page",
}


@dataclass(frozen=True)
class About:
    """The texts of a stage.

    Attributes
    ----------
    title : str
        Its heading.
    verb : str
        Its button, its name while it runs and, in lower case, its name in the report.
    help : str
        What it finds, beginning in lower case.
    share : float
        Share of a whole run's time, percent.
    options : str
        The heading of its settings in the command line's help.
    manual : str
        The page of the manual that explains its settings.
    summary : callable
        Its result in a line or two, from its figures.
    """

    title: str
    verb: str
    help: str
    share: float
    options: str
    manual: str
    summary: Callable[[Figures], list[str]]

    @property
    def reported(self) -> str:
        """Its name in the report."""
        return self.verb.lower()


def _place(figures: Figures) -> list[str]:
    return [
        f"{figures['photos_placed']} of {figures['photos']} photos placed",
        f"{figures['points']} points, {figures['reprojection_error_mean_px']:.2f} px off",
    ]


def _find(figures: Figures) -> list[str]:
    return [
        f"In {figures['reference']}, edge {100 * figures['outline_confidence']:.0f} % sure",
        f"{figures['points_on_sheet']} points on the paper",
    ]


def _surface(figures: Figures) -> list[str]:
    residual = 100 * figures["residual_median_page_lengths"]
    return [
        f"{figures['creases']} creases, {figures['vertices']} vertices",
        f"{residual:.3f} % of the page off the points",
    ]


def _unwrap(figures: Figures) -> list[str]:
    worst, flipped = 100 * figures["stretch_95th_percentile"], figures["flipped_triangles"]
    return [
        f"Stretch {100 * figures['stretch_median']:.2f} % (median)",
        f"{worst:.2f} % in the worst twentieth",
        *([f"{flipped} triangles upside down"] if flipped else []),
    ]


def _lay_out(figures: Figures) -> list[str]:
    unit = "mm" if figures["unit"] == "mm" else "page heights"
    accuracy = accuracy_text(figures)
    size = f"{figures['width']:.4g} x {figures['height']:.4g} {unit}"
    return [size] if accuracy is None else [size, accuracy]


def accuracy_text(figures: Mapping[str, Any]) -> str | None:
    """How exact the page is, from the figures of its layout; None if that is not known."""
    within = figures.get(WITHIN)
    if within is None:
        return None
    if figures["unit"] == "mm":
        return f"90 % of the page is within {within:.2g} mm"
    return f"90 % of the page is within {100 * within:.2g} % of its height"


def _page(figures: Figures) -> list[str]:
    exact = "" if figures["dpi_source"] == "paper size" else " (assumed)"
    lines = [f"{figures['width_px']} x {figures['height_px']} pixels, {figures['dpi']:.0f} dpi{exact}"]
    if figures.get("paper_lab") is not None:  # figures of older files lack it
        lightness, green_red, blue_yellow = figures["paper_lab"]
        lines.append(f"Paper L* {lightness:.1f}, a* {green_red:+.1f}, b* {blue_yellow:+.1f}")
        lines.append(f"Uneven by {figures['paper_unevenness_lightness']:.1f} L*")
    return lines


_ABOUT: dict[str, About] = {
    "place": About(
        title="Placement",
        verb="Place Photos",
        help="where the photos were taken",
        share=60,
        options="placing the photos",
        manual="placement",
        summary=_place,
    ),
    "find": About(
        title="Sheet",
        verb="Find Sheet",
        help="where the paper is in the reference photo",
        share=10,
        options="the sheet",
        manual="sheet",
        summary=_find,
    ),
    "surface": About(
        title="Surface",
        verb="Build Surface",
        help="the sheet's surface and its creases",
        share=8,
        options="the sheet",
        manual="surface",
        summary=_surface,
    ),
    "unwrap": About(
        title="Unwrap",
        verb="Unwrap",
        help="the sheet laid flat",
        share=4,
        options="the sheet",
        manual="unwrap",
        summary=_unwrap,
    ),
    "lay_out": About(
        title="Layout",
        verb="Lay Out Page",
        help="the flat sheet as a page",
        share=6,
        options="the page",
        manual="page",
        summary=_lay_out,
    ),
    "page": About(
        title="Page",
        verb="Make Page",
        help="the page image",
        share=12,
        options="the page",
        manual="page",
        summary=_page,
    ),
}


def about(stage: str) -> About:
    """The texts of a stage."""
    return _ABOUT[stage]


def as_option(stage: Stage) -> str:
    """A stage as the command line names it."""
    return stage.replace("_", "-")


def of_option(name: str | None) -> Stage | None:
    """The stage that the command line names so; None for no name."""
    return next((stage for stage in STAGES if as_option(stage) == name), None)


def parts_of_time(stages: Sequence[str]) -> dict[str, tuple[float, float]]:
    """The start and end of each stage as shares of the time that these stages take together."""
    whole = sum(about(stage).share for stage in stages)
    parts, start = {}, 0.0
    for stage in stages:
        end = start + about(stage).share / whole
        parts[stage] = start, min(end, 1.0)
        start = end
    return parts
