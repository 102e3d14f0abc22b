"""The values that the paper and its journal version report for the three published photo sets.

The paper has no tables: these values are read off the bars of its Fig. 7 and are accurate to about one unit of the last
digit. Its flow (SIFT-flow), its structure from motion and its crops differ from ours; a comparison is indicative.
"""

from __future__ import annotations

from dataclasses import dataclass

NOTE = "read off the paper's Fig. 7, which is no table: good to about one unit of the last digit; other flow, other SfM"


@dataclass(frozen=True)
class Reported:
    """``bins``: share of the page's pixels displaced by 0-1, 1-2, ... px at 1000 px page height; ``mean`` from them."""

    global_distortion: float
    mean: float
    bins: tuple[float, ...]


RA_L1 = {
    "I": Reported(1.0035, 0.87, (0.66, 0.31, 0.03)),
    "IV": Reported(1.004, 1.01, (0.55, 0.39, 0.06)),
    "XII": Reported(1.0065, 0.87, (0.73, 0.19, 0.06, 0.02)),
}
