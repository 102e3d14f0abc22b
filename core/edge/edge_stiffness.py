"""How stiff the paper is where only its edge tells.

The stiffness of a sheet is chosen by its points. A book's page that is nearly flat where it is printed sinks into the
gutter in a blank margin: a surface as stiff as its print would allow goes on straight there, and misses the edge.
"""

from __future__ import annotations

from dataclasses import replace

from ..arrays import Array
from ..surface.left_out import STIFFNESS
from ..surface.surface import Surface, fitted_to_edge
from ..surface.surface_settings import SurfaceSettings

# A surface is too stiff if it misses more than this part of the edge, and a limper one is better if it misses at most
# this part of what the stiffer one misses. Of five rendered sheets on a table the surfaces miss 0, 0, 0, 0 and 1.2 % of
# the edge; of a rendered page of a book 4.9 % at a stiffness of 1000, 2.1 at 300, .8 at 100, .6 at 30 and .1 at 10,
# where the page is .063, .042, .018, .012 and .016 % of its height off, and a twentieth of it by more than .19, .06,
# .04, .06 and .10 %.
_TOO_STIFF, _BETTER = 0.01, 0.9


def as_stiff_as_its_edge(surface: Surface, points: Array, settings: SurfaceSettings) -> Surface:
    """The surface, or limper ones as long as it misses its edge and they miss less of it.

    Parameters
    ----------
    surface : Surface
        Fitted to the points (N, 3) and to its edge with these settings.
    points, settings
    """
    missed = surface.missed_edge
    for stiffness in reversed([each for each in STIFFNESS if each < surface.stiffness]):
        if surface.edge is None or missed <= _TOO_STIFF:
            break
        limper = fitted_to_edge(replace(surface, stiffness=stiffness), points, settings, surface.edge)
        still_missed = limper.missed_edge
        if still_missed > _BETTER * missed:
            break
        surface, missed = limper, still_missed
    return surface
