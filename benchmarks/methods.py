"""The compared methods: the paper's two surfaces with its three unwrappings, ARAP, and the project's default."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..core.flat.flatten import FlattenMethod, FlattenSettings
from ..core.surface.surface import SurfaceMethod, SurfaceSettings
from ..origami_addon.settings import RunSettings


@dataclass(frozen=True)
class Method:
    """A way from points to page, named as in the paper's Fig. 7 if it is there."""

    name: str
    surface: SurfaceSettings
    flatten: FlattenSettings

    def settings(self) -> RunSettings:
        """The defaults of everything else."""
        return replace(RunSettings(), surface=self.surface, flatten=self.flatten)


def _cell(name: str, surface: SurfaceMethod, flatten: FlattenMethod, *, rows: bool = False) -> Method:
    unwrapping = FlattenSettings(method=flatten, ridge_rows=rows, boundary_rows=rows)
    return Method(name, SurfaceSettings(method=surface), unwrapping)


PAPER = _cell("RA+L1 with rows", "ridge_aware", "conformal_l1", rows=True)
PAPER_WITHOUT_ROWS = _cell("RA+L1", "ridge_aware", "conformal_l1")
DEFAULT = Method("default", SurfaceSettings(), FlattenSettings())
BROWN = _cell("l2 Po+L2", "poisson_l2", "lscm")
ZHANG = _cell("l2 Po+Geo", "poisson_l2", "geodesic")

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
)

# In the paper's Fig. 9 the other methods use the points without robustness, because both were made for range scans.
ON_SYNTHETIC_POINTS = (PAPER, PAPER_WITHOUT_ROWS, BROWN, ZHANG, DEFAULT)
