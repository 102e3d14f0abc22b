"""What tells how exact a page is: how far it moves after other errors and without some points, gaps, and strain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Array
from ..camera import Camera
from ..flat.distortion import apply_affine, fit_similarity, measure_strain
from ..flat.flatten import flatten
from ..numeric.threads import in_threads
from ..sheet import Sheet
from ..surface.other_surfaces import OtherSurfaces
from ..surface.surface import Surface, SurfaceSettings
from ..tracks.resampling import resampled
from ..watch import SILENT, Watch

# Pages after other errors. The standard deviation that twelve give scatters by a fifth.
_TIMES = 12


@dataclass(frozen=True)
class PageScatter:
    """Lengths that grow with the error of a page, world units.

    Attributes
    ----------
    by_errors : (V,) array
        Of each vertex on the page: standard deviation, both directions together, after other errors of the
        observations. They move points, cameras and lens.
    by_gaps : (V,) array
        The same without patches of points, by the jackknife.
    reach : (V,) array
        Square of the distance to the nearest point times the sheet's usual curvature: twice as far as a plane is off
        there.
    strain : float
        Paper does not stretch: root mean square of the changes of length of the flat map, times the page's length.
    """

    by_errors: Array
    by_gaps: Array
    reach: Array
    strain: float


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
) -> PageScatter:
    """Make the page again, with other errors and with fewer points.

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

    def pages(items: Iterator[tuple[Array, Camera]], count: int, part: Watch) -> Array:
        found = []
        for uv in in_threads(page, items, threads):
            found.append(apply_affine(fit_similarity(uv, own), uv) - own)
            part.step(len(found) / count, "Estimating how exact the page is")
        return np.array(found).reshape(-1, len(own), 2)

    camera = frame.camera
    own = page((others.solution, camera))
    by_errors = pages(others.after(moves()), _TIMES, watch.part(0, 0.7))
    by_gaps = pages(((each, camera) for each in others.without_patches()), 5, watch.part(0.7, 1))
    groups = len(by_gaps)
    spread = ((by_gaps - by_gaps.mean(axis=0)) ** 2).sum(axis=(0, 2)) if groups > 1 else np.zeros(len(own))
    curvature = float(np.median(np.abs(surface.curvature.across)))
    strain = measure_strain(sheet.vertices, sheet.triangles, own)
    squares = ((strain.singular_values - 1) ** 2).sum(axis=1)
    return PageScatter(
        np.sqrt((by_errors**2).sum(axis=2).mean(axis=0)),
        np.sqrt((groups - 1) / max(groups, 1) * spread),
        cKDTree(others.problem.plane).query(plane)[0] ** 2 * curvature * frame.unit,
        float(np.sqrt(strain.area @ squares)) * frame.unit,
    )
