"""How far a result can be trusted: the bound on the page's error, and the measurements that it rests on.

Where the bound is known, it decides, with what it does not cover: the paper's edge and triangles upside down. Without
it, all measures decide. One is good if it is no worse than on any of the nine photo sets of the benchmark, whose pages
are accurate to 0.12 % of their height on average, and poor if it is at least three times as bad.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from ..stages import WITHIN, accuracy_text

# Of the page's height: half a millimetre of A4, which nobody sees, and a millimetre and a half, which bends rules.
_GOOD_BOUND, _POOR_BOUND = 0.0017, 0.005

Verdict = Literal["good", "fair", "poor"]
_ORDER: tuple[Verdict, ...] = ("good", "fair", "poor")


@dataclass(frozen=True)
class Measure:
    """One figure with its verdict.

    Attributes
    ----------
    text : str
    verdict : {"good", "fair", "poor"}
    decides : bool
        Whether the whole is no better than this.
    """

    text: str
    verdict: Verdict
    decides: bool = True


@dataclass(frozen=True)
class _Limit:
    figure: str
    text: str  # with the value in it
    good: float
    poor: float
    factor: float = 1.0  # from the figure to the shown value

    def judge(self, value: float) -> Measure:
        worse = value > self.good if self.poor > self.good else value < self.good
        bad = value > self.poor if self.poor > self.good else value < self.poor
        return Measure(self.text.format(self.factor * value), "poor" if bad else "fair" if worse else "good")


_LIMITS = (
    _Limit("views_per_point_mean", "Each point seen in {:.1f} photos", 4.0, 3.2),
    _Limit("viewing_angle_median_degrees", "Seen from {:.0f}° apart", 20.0, 7.0),
    _Limit("reprojection_error_mean_px", "Points {:.2f} pixels off", 0.9, 2.7),
    _Limit("residual_median_page_lengths", "Surface {:.3f} % of the page off", 0.0004, 0.0012, 100),
    _Limit("stretch_95th_percentile", "Stretch {:.2f} % in the worst twentieth", 0.0065, 0.02, 100),
)
_FEWEST_PLACED = 0.6  # share of the photos, below which their placement is poor; a choice
_EDGE = _Limit("outline_confidence", "Paper's edge {:.0f} % sure", 0.8, 0.5, 100)


def measures(figures: Mapping[str, Any]) -> list[Measure]:
    """The measures from the figures of a document's stages, as far as they exist."""
    found = []
    if "photos" in figures:
        placed, given = figures["photos_placed"], figures["photos"]
        verdict: Verdict = "good" if placed == given else "fair" if placed >= _FEWEST_PLACED * given else "poor"
        found.append(Measure(f"{placed} of {given} photos placed", verdict))
    found += [limit.judge(figures[limit.figure]) for limit in _LIMITS if figures.get(limit.figure) is not None]
    accuracy = accuracy_text(figures)
    if accuracy is not None:
        share = figures[WITHIN] / figures["height"]
        verdict = "good" if share <= _GOOD_BOUND else "poor" if share > _POOR_BOUND else "fair"
        found = [Measure(accuracy, verdict), *(replace(each, decides=False) for each in found)]
    if figures.get("outline_confidence") is not None:
        found.append(_EDGE.judge(figures["outline_confidence"]))
    if figures.get("flipped_triangles"):
        found.append(Measure(f"{figures['flipped_triangles']} triangles upside down", "poor"))
    return found


def confidence(found: list[Measure]) -> Verdict:
    """The worst verdict of those that decide."""
    return max((measure.verdict for measure in found if measure.decides), key=_ORDER.index, default="good")
