"""What shows how exact a page is: how far it moves after other errors, how much it is strained, and its gaps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..camera import Camera
from ..flat.distortion import apply_affine, fit_similarity
from ..flat.flatten import flatten
from ..numeric.threads import in_threads
from ..numeric.triangles import areas, local_coordinates
from ..sheet import Sheet
from ..surface.other_surfaces import OtherSurfaces
from ..surface.surface import Surface
from ..surface.surface_settings import SurfaceSettings
from ..tracks.resampling import resampled
from ..watch import SILENT, Watch

# Pages after other errors. The standard deviation that twelve give scatters by a fifth.
_TIMES = 12
# Radius of the discs in page lengths, and how many of them. On ten rendered sheets, folded, curled and flat, the page
# is off by .78 to 1.47 times what strain and scatter together say with this radius, and by .46 to 1.9 times with the
# strain of single triangles.
_DISC, _DISCS = 0.2, 400


@dataclass(frozen=True)
class PageScatter:
    """Lengths that grow with the error of a page, world units.

    Attributes
    ----------
    by_errors : (V,) array
        Of each vertex on the page: standard deviation, both directions together, after other errors of the
        observations. They move points, cameras and lens.
    strain : float
        How much the sheet would have to stretch to lie on the page of a surface that is as stiff along this one's
        rulings: paper does not stretch, and a surface that is right does not change. Root mean square, times the
        page's length, of means over discs, in which what rounds a crease here and there cancels.
    gap : (V,) array
        Distance to the nearest point, page lengths.
    """

    by_errors: Array
    strain: float
    gap: Array


def page_scatter(
    sheet: Sheet,
    surface: Surface,
    points: Array,
    observed: Array,
    cameras: Sequence[Camera],
    reference: int,
    settings: SurfaceSettings,
    seed: int = 0,
    threads: int = 1,
    watch: Watch = SILENT,
) -> PageScatter | None:
    """Make the page again, with other errors; None if no photo shows any of the points.

    Parameters
    ----------
    sheet : Sheet
        Cut out of the surface.
    surface : Surface
        Developable, fitted to the points.
    points : (N, 3) array
    observed : (N, C, 2) array
        Where the photos show the points, distorted pixels; NaN where they do not.
    cameras : sequence of Camera
    reference : int
        The camera over whose photo the surface lies.
    settings : SurfaceSettings
        As the surface was fitted with.
    seed : int
    threads : int
        How many pages are made at once.
    watch : Watch

    Raises
    ------
    Cancelled, StepFailed
    """
    if not np.isfinite(observed).any():
        return None
    others = OtherSurfaces.of(surface, points, settings)
    frame = others.grid.frame
    plane = frame.from_world(sheet.vertices)[0]
    pixels = cameras[reference].project(sheet.vertices)
    slope = others.slopes(plane)
    random = np.random.default_rng(seed)
    place = frame.from_world(points)[0]

    def moves() -> Iterator[tuple[Array, Camera]]:
        for there, seen_by in resampled(cameras, points, observed, place, _TIMES, random):
            yield there, seen_by[reference]

    def page(item: tuple[Array, Camera]) -> Array:
        """The flat place of what the reference photo shows in each vertex's pixel."""
        solution, camera = item
        seen_from = replace(frame, camera=camera)
        there = seen_from.from_pixels(pixels)
        inverse_depth = others.grid.interpolate(solution, plane) + (slope * (there - plane)).sum(axis=1)
        return flatten(replace(sheet, vertices=seen_from.to_world(there, inverse_depth)), robust_start=False)

    own = page((others.solution, frame.camera))
    squares = np.zeros(len(own))
    for done, uv in enumerate(in_threads(page, others.after(moves()), threads), 1):
        squares += np.square(apply_affine(fit_similarity(uv, own), uv) - own).sum(axis=1)
        watch.step(done / _TIMES, "Estimating how exact the page is")
    return PageScatter(
        np.sqrt(squares / _TIMES),
        wide_strain(sheet, own, _DISC * frame.unit) * frame.unit,
        cKDTree(others.problem.plane).query(plane)[0],
    )


def wide_strain(sheet: Sheet, uv: Array, radius: float) -> float:
    """Root mean square of the sheet's strain on a flat map (V, 2), as means over discs of a radius in its unit."""
    corners = local_coordinates(sheet.vertices, sheet.triangles)
    sides = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2) * [[1.0], [-1.0]]
    flat = uv[sheet.triangles]
    stretch = np.swapaxes(flat[:, 1:] - flat[:, :1], 1, 2) @ np.linalg.inv(sides)
    axes, values, _ = np.linalg.svd(stretch)
    area = areas(sheet.vertices, sheet.triangles)
    scale = np.sqrt(area @ values.prod(axis=1) / area.sum())
    weighted = area[:, None, None] * ((axes * (values / scale)[:, None]) @ np.swapaxes(axes, 1, 2) - np.eye(2))
    middle = flat.mean(axis=1)
    some = slice(None, None, -(-len(middle) // _DISCS))
    squares = [
        np.square(weighted[inside].sum(axis=0) / area[inside].sum()).sum()
        for inside in cKDTree(middle).query_ball_point(middle[some], radius)
    ]
    return float(np.sqrt(np.average(squares, weights=area[some])))
