"""How the surface is reconstructed: what a user may set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..setting import Choice, setting

SurfaceMethod = Literal["developable", "ridge_aware", "poisson", "poisson_l2"]


@dataclass(frozen=True)
class SurfaceSettings:
    """How the surface is reconstructed.

    ``poisson_l2`` is plain Poisson, ``poisson`` has the l1 data term (Eq. 6), and ``ridge_aware`` is the paper's second
    solve (Eq. 12); ``ridge_curvature`` is its kappa_th and ``ridge_emphasis`` its beta. The smoothness is a factor on
    the value derived from the noise and the number of points, or, for the developable surface of
    `reconstruct_with_creases`, on the value chosen for the sheet.
    """

    method: SurfaceMethod = setting(
        "developable",
        "how the surface is fitted to the points",
        label="Surface",
        option="--surface",
        choices={
            "developable": Choice(
                "Developable",
                "smooth along straight lines, free to bend across them as paper does, sharp along creases",
            ),
            "ridge_aware": Choice("Ridge-Aware", "the published method, smooth everywhere except across the creases"),
            "poisson": Choice("Poisson", "only the first solve of the published method"),
            "poisson_l2": Choice("Poisson, Least Squares", "the same solve without robustness against wrong points"),
        },
    )
    grid_rows: int = setting(
        85,
        "nodes of the surface along the page's long side; 120 suits narrow folds",
        label="Grid Rows",
        option="--grid-rows N",
        least=20,
        most=400,
    )
    smoothness: float = setting(
        1.0,
        "factor on the smoothness derived from the points: above 1 gives fewer waves, below 1 finer bends",
        label="Smoothness",
        option="--smoothness X",
        least=1e-4,
        most=1e4,
        usual=(0.1, 10),
    )
    ridge_curvature: float = setting(
        4.0,
        "curvature above which the ridge-aware surface treats a place as a crease, per page length",
        label="Ridge Curvature",
        least=1e-3,
        most=1e4,
        only_with=("method", "ridge_aware"),
    )
    ridge_emphasis: float = setting(
        10.0,
        "how much less smooth the ridge-aware surface is across a crease than along it",
        label="Ridge Emphasis",
        least=1.001,
        most=1e6,
        usual=(None, 100),
        only_with=("method", "ridge_aware"),
    )
