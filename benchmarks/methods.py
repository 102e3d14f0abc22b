"""The compared methods: the paper's two surfaces with its three unwrappings, ARAP, the project's default, and its
ablation: the default with one of its parts left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any, Literal
from unittest import mock

import numpy as np

from ..core.flat.flatten import FlattenMethod, FlattenSettings
from ..core.surface import creased_surface, smoothness, solvers
from ..core.surface.surface_settings import SurfaceMethod, SurfaceSettings
from ..core.tracks import dense_tracks, equations, measured_points
from ..origami_addon.settings import RunSettings
from ..origami_addon.state import Found
from ..origami_addon.steps import surface as surface_step

# What the steps keep of their results, in order.
Kept = Literal["tracks", "sheet", "flat"]
KEPT: tuple[Kept, ...] = ("tracks", "sheet", "flat")


@dataclass(frozen=True)
class Swap:
    """Something else in the place of a module's function or constant, for what no setting switches off."""

    module: ModuleType
    name: str
    stand_in: Any


@dataclass(frozen=True)
class Method:
    """A way from points to page, named as in the paper's Fig. 7 if it is there.

    Attributes
    ----------
    name : str
    surface : SurfaceSettings
    flatten : FlattenSettings
    swaps : tuple of Swap
        In force while the method computes.
    changed : {"tracks", "sheet", "flat"}
        The first kept result that the swaps change; those before it are shared with the default.
    """

    name: str
    surface: SurfaceSettings = field(default_factory=SurfaceSettings)
    flatten: FlattenSettings = field(default_factory=FlattenSettings)
    swaps: tuple[Swap, ...] = ()
    changed: Kept = "flat"

    def settings(self) -> RunSettings:
        """The defaults of everything else."""
        return replace(RunSettings(), surface=self.surface, flatten=self.flatten)

    @property
    def shared(self) -> tuple[Kept, ...]:
        """The kept results that the swaps leave as they are."""
        return KEPT[: KEPT.index(self.changed)]

    @contextmanager
    def in_force(self) -> Iterator[None]:
        """With the swaps made.

        Raises
        ------
        AttributeError
            If a module has nothing of a swap's name.
        """
        with ExitStack() as stack:
            for swap in self.swaps:
                stack.enter_context(mock.patch.object(swap.module, swap.name, swap.stand_in))
            yield


def _cell(name: str, surface: SurfaceMethod, flatten: FlattenMethod, *, rows: bool = False) -> Method:
    unwrapping = FlattenSettings(method=flatten, ridge_rows=rows, boundary_rows=rows)
    return Method(name, SurfaceSettings(method=surface), unwrapping)


def _sparse_points(state: Found, *_: Any) -> Any:
    """Without the first surface, too, which only serves to follow the print."""
    on_sheet = state.model.select(state.region.on_sheet)
    return on_sheet.cameras, on_sheet.points, on_sheet.observations()


def _by_the_rule(*given: Any, **named: Any) -> Any:
    return replace(_assess(*given, **named), stiffness=1.0)


def _solved_in_place(problem: Any, start: Any, _: Any) -> Any:
    return problem, solvers.stiffened(problem, start)


def _isotropic(grid: Any, _: Any) -> Any:
    return smoothness.isotropic_smoothness(grid.second_differences()) / solvers._DEVELOPABLE_SHARE


# Before it is swapped.
_assess = creased_surface.assess

_NO_TRACKS = Swap(surface_step, "points_to_fit", _sparse_points)
_RULE = Swap(creased_surface, "assess", _by_the_rule)

PAPER = _cell("RA+L1 with rows", "ridge_aware", "conformal_l1", rows=True)
PAPER_WITHOUT_ROWS = _cell("RA+L1", "ridge_aware", "conformal_l1")
DEFAULT = Method("default")
STIFFNESS_BY_RULE = Method("default, stiffness by the rule", swaps=(_RULE,), changed="sheet")
BROWN = _cell("l2 Po+L2", "poisson_l2", "lscm")
ZHANG = _cell("l2 Po+Geo", "poisson_l2", "geodesic")

# What every table shows beside the default.
BASELINES = (PAPER, PAPER_WITHOUT_ROWS, STIFFNESS_BY_RULE)

ON_PHOTOS = (
    PAPER,
    PAPER_WITHOUT_ROWS,
    _cell("RA+L2", "ridge_aware", "lscm"),
    _cell("RA+Geo", "ridge_aware", "geodesic"),
    _cell("RA+ARAP", "ridge_aware", "arap"),
    _cell("Po+L1 with rows", "poisson", "conformal_l1", rows=True),
    _cell("Po+L1", "poisson", "conformal_l1"),
    _cell("Po+L2", "poisson", "lscm"),
    _cell("Po+Geo", "poisson", "geodesic"),
    _cell("Po+ARAP", "poisson", "arap"),
    DEFAULT,
    STIFFNESS_BY_RULE,
)

# In the paper's Fig. 9 the other methods use the points without robustness, because both were made for range scans.
ON_SYNTHETIC_POINTS = (PAPER, PAPER_WITHOUT_ROWS, BROWN, ZHANG, DEFAULT, STIFFNESS_BY_RULE)

# One part after the other is left out, in the order in which a run comes to it; the stiffness chosen for each sheet is
# left out in a baseline. The page's turn and its cut along the sides are not among them: the scores lay the page on the
# original themselves.
ABLATION = (
    Method("no dense tracks", swaps=(_NO_TRACKS,), changed="tracks"),
    Method(
        "tracks on the reference photo, not on the mean of all",
        swaps=(Swap(dense_tracks, "_mean", lambda prints, shifts, fixed: fixed),),
        changed="tracks",
    ),
    Method(
        "cameras not adjusted to the tracks",
        swaps=(Swap(measured_points, "adjust", lambda cameras, observed: tuple(cameras)),),
        changed="tracks",
    ),
    Method(
        "cameras adjusted, the lens not",
        swaps=(Swap(equations, "LENS_CHANGE", np.full_like(equations.LENS_CHANGE, 1e-9)),),
        changed="tracks",
    ),
    Method(
        "no points of structure from motion where no track is",
        swaps=(Swap(measured_points, "_LONELY", np.inf),),
        changed="tracks",
    ),
    Method("no doubt of creases", swaps=(Swap(creased_surface, "_SURE", 0.0),), changed="sheet"),
    Method("no creases", swaps=(Swap(creased_surface, "find_ridges", lambda *_, **__: []),), changed="sheet"),
    Method(
        "found creases not joined",
        swaps=(Swap(creased_surface, "extend_to_each_other", lambda lines, _: lines),),
        changed="sheet",
    ),
    Method("creases stay where found", swaps=(Swap(solvers, "_with_moved_hinges", _solved_in_place),), changed="sheet"),
    Method(
        "isotropic smoothness instead of developable",
        swaps=(Swap(solvers, "developable_smoothness", _isotropic),),
        changed="sheet",
    ),
    Method(
        "not fitted to the paper's edge",
        swaps=(Swap(surface_step, "fit_to_edge", lambda surface, *_: surface),),
        changed="sheet",
    ),
    Method("conformal l1 instead of ARAP", flatten=FlattenSettings(method="conformal_l1")),
    Method("sides and creases made straight", flatten=FlattenSettings(ridge_rows=True, boundary_rows=True)),
    Method("no dense tracks, stiffness by the rule", swaps=(_NO_TRACKS, _RULE), changed="tracks"),
)
