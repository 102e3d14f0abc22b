"""From the sheet to the plane: the paper's section 3.2 (Eq. 13-19) and the methods that it is compared with."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..errors import StepFailed
from ..numeric.robust import Loss, minimize
from ..numeric.triangles import areas, gradient_rows, signed_areas
from ..setting import Choice, setting
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .convex_map import convex_map
from .geodesic import keep_geodesic_lengths
from .least_stretch import has_flips, least_stretch
from .pins import HeldSystem, Pins
from .settle import settle
from .sides import sides

FlattenMethod = Literal["arap", "conformal_l1", "lscm", "geodesic", "least_stretch"]

# Values without a figure are choices; no measurement of them is recorded.
# The paper's gamma and theta, for a page of unit area with triangles of unit weight on average.
_COLLINEARITY_WEIGHT = 1e2
_PIN_WEIGHT = 1e3
# A side or ridge that waves by more than this share of the page without rows is notched, torn or not a line at all.
_MOST_WAVE = 0.03
# The two pins of a conformal map are in the middle of the sheet: within this share of its width, which is a choice.
_MIDDLE = 0.1
# On a mesh of a few triangles that strip may not reach this far along the sheet; then all vertices may be pins.
_LEAST_REACH = 0.5
# Relative shear below which the l1 loss of a conformal row is quadratic.
_L1_SCALE = 1e-3
# The most iterations. They end earlier once no vertex moves by more than the tolerance, a share of the page.
_L1_ITERATIONS = 30
_ARAP_ITERATIONS = 60
_TOLERANCE = 1e-6


@dataclass(frozen=True)
class FlattenSettings:
    """How the sheet is flattened.

    ``conformal_l1`` is the paper's (Eq. 19), ``lscm`` its l2 version (Brown et al.), ``geodesic`` is after Zhang et al.
    and ``least_stretch`` after Rabinovich et al. The rows are those of Eq. 16: they help on a correct surface and hurt
    on a wrong one.
    """

    method: FlattenMethod = setting(
        "arap",
        "what the flat map preserves of the surface",
        label="Method",
        option="--unwrap",
        choices={
            "arap": Choice(
                "As Rigid as Possible", "the shape and size of every triangle, as far as possible; best for paper"
            ),
            "conformal_l1": Choice("Conformal, l1", "angles, except in a few triangles; the published method"),
            "lscm": Choice("Conformal, Least Squares", "angles everywhere, as far as possible"),
            "geodesic": Choice("Geodesic", "distances along the surface"),
            "least_stretch": Choice(
                "Least Stretch", "lengths, nowhere much worse than elsewhere, and never folds over; best for cloth"
            ),
        },
    )
    ridge_rows: bool = setting(
        False,
        "make creases, including painted ones, straight lines on the page",
        label="Straighten Creases",
        option="--ridge-rows",
    )
    boundary_rows: bool = setting(
        False,
        "make the sheet's sides straight; helps where they wave, hurts where the edge was not found well",
        label="Straighten Sides",
        option="--boundary-rows",
    )


def flatten(
    sheet: Sheet,
    settings: FlattenSettings | None = None,
    watch: Watch = SILENT,
    *,
    pins: Pins | None = None,
    robust_start: bool = True,
) -> Array:
    """Flat coordinates of every vertex.

    Parameters
    ----------
    sheet : Sheet
    settings : FlattenSettings, optional
    watch : Watch
    pins : Pins, optional
        In the frame of the result. One pin moves the whole map. Two or more turn it, and bend it if they are not as far
        apart as on the sheet; the conformal methods then take the pins' scale, the others keep the sheet's.
    robust_start : bool
        Whether ``arap`` starts from the l1 conformal map or from the l2 one, with which it takes an eighth of the
        time. On sheets of paper the results agree to 1e-4 of the page.

    Returns
    -------
    uv : (V, 2) array
        In the sheet's own unit, v down, not mirrored as seen from the printed side. Without pins its rotation and
        position are arbitrary; `page.lay_out` fixes them.

    Raises
    ------
    StepFailed
        If the sheet closes on itself so far that it has no map, or the pins allow none.
    """
    settings = settings or FlattenSettings()
    size = np.sqrt(areas(sheet.vertices, sheet.triangles).sum())
    unit = replace(sheet, vertices=sheet.vertices / size)
    lines = [ridge for ridge in sheet.ridges if len(ridge) >= 3] if settings.ridge_rows else []
    if settings.boundary_rows:
        lines += sides(unit)
    robust = settings.method == "conformal_l1" or (settings.method == "arap" and robust_start)
    held = None if pins is None or len(pins.vertices) < 2 else Pins(pins.vertices, pins.uv / [size, -size])
    if settings.method == "least_stretch":
        flat = _least_stretch(unit, lines, watch, held)
    else:
        flat = conformal_map(unit, lines, robust=robust, pins=held, watch=watch.part(0, 0.5))
    if settings.method == "arap":
        flat = as_rigid_as_possible(unit, flat, lines, watch.part(0.5, 1), pins=held)
    elif settings.method == "geodesic":
        flat = keep_geodesic_lengths(unit, flat, watch.part(0.5, 1), pins=held)
    uv = flat * [size, -size]
    if pins is not None and len(pins.vertices) > 0:
        if len(pins.vertices) == 1:
            uv += pins.uv - uv[pins.vertices]
        uv[pins.vertices] = pins.uv  # avoids rounding by the unit
    return uv


def _least_stretch(unit: Sheet, lines: list[Indices], watch: Watch, held: Pins | None) -> Array:
    """The map of least stretch, from the first of three that has no flips; if pins fold all over, as rigid as possible.

    Raises
    ------
    StepFailed
        If the pins allow no map.
    """
    flat = None
    try:
        angles = conformal_map(unit, lines, robust=False, pins=held, watch=watch.part(0, 0.1))
        flat = as_rigid_as_possible(unit, angles, lines, watch.part(0.1, 0.3), pins=held)
        if has_flips(flat, unit.triangles) and not has_flips(angles, unit.triangles):
            flat = angles
    except StepFailed:
        if held is not None:
            raise
    if flat is None or has_flips(flat, unit.triangles):
        if held is not None:
            assert flat is not None
            return flat
        flat = convex_map(unit) / np.sqrt(np.pi)  # of unit area, like the sheet
    straight = _COLLINEARITY_WEIGHT * _collinearity_rows(flat, lines)
    return least_stretch(unit, flat, straight, watch.part(0.3, 1), pins=held)


def conformal_map(
    sheet: Sheet, lines: list[Indices], *, robust: bool, pins: Pins | None = None, watch: Watch = SILENT
) -> Array:
    """Conformal map (Eq. 13-19), scaled to the sheet's own area if no pins are given.

    Parameters
    ----------
    sheet : Sheet
        Of about unit area.
    lines : list of int arrays
        Runs of vertices that should become straight.
    robust : bool
        l1 instead of l2.
    pins : Pins, optional
        Two or more, u right, v up.
    watch : Watch

    Returns
    -------
    flat : (V, 2) array
        u right, v up.

    Raises
    ------
    StepFailed
        If the sheet closes on itself so far that it has no map, or the pins allow none.
    """
    count = len(sheet.vertices)
    area = areas(sheet.vertices, sheet.triangles)
    share = area / area.mean()
    along_x, along_y = (
        rows.multiply((share if robust else np.sqrt(share))[:, None]).tocsr()
        for rows in gradient_rows(sheet.vertices, sheet.triangles)
    )
    rows = sparse.block_array([[along_x, -along_y], [along_y, along_x]], format="csr")
    if lines:
        free = conformal_map(sheet, [], robust=False, pins=pins)
        rows = sparse.vstack([rows, _COLLINEARITY_WEIGHT * _collinearity_rows(free, lines)], format="csr")
    loss = Loss("l1", _L1_SCALE) if robust else Loss("squared")
    if pins is not None:
        return _pinned_map(rows, loss, pins, watch)
    places, values = _two_places(sheet)
    quadratic = sparse.csr_array((np.full(4, _PIN_WEIGHT), (places, places)), shape=(2 * count, 2 * count))
    linear = np.zeros(2 * count)
    linear[places] = _PIN_WEIGHT * values
    fit = minimize(
        rows,
        np.zeros(rows.shape[0]),
        loss,
        quadratic,
        linear=linear,
        tolerance=_TOLERANCE,
        max_iterations=_L1_ITERATIONS,
        watch=watch,
    )
    flat = fit.solution.reshape(2, count).T
    flat_area = signed_areas(flat, sheet.triangles).sum()
    if not flat_area > 0:
        raise StepFailed("The surface closes on itself so far that it has no flat map: cut it open with a seam.")
    return flat * np.sqrt(area.sum() / flat_area)


def _pinned_map(rows: sparse.csr_array, loss: Loss, pins: Pins, watch: Watch) -> Array:
    """The map (V, 2) of least loss whose pinned vertices are exactly where they are held."""
    count = rows.shape[1] // 2
    held = np.concatenate([pins.vertices, pins.vertices + count])
    solution = np.empty(2 * count)
    solution[held] = pins.uv.T.ravel()
    free = np.setdiff1d(np.arange(2 * count), held)
    if len(free):
        columns = rows.tocsc()
        fit = minimize(
            columns[:, free].tocsr(),
            -(columns[:, held] @ solution[held]),
            loss,
            sparse.csr_array((len(free), len(free))),
            tolerance=_TOLERANCE,
            max_iterations=_L1_ITERATIONS,
            watch=watch,
        )
        solution[free] = fit.solution
    return solution.reshape(2, count).T


def _two_places(sheet: Sheet) -> tuple[Indices, Array]:
    """Two vertices near the middles of opposite sides, as unknowns (u, u, v, v), and their pinned values.

    Pins at corners would make the whole map depend on the least certain places of the surface.
    """
    centred = sheet.vertices - sheet.vertices.mean(0)
    along, across = (centred @ np.linalg.svd(centred, full_matrices=False)[2][:2].T).T
    middle = np.flatnonzero(np.abs(across) < _MIDDLE * np.ptp(across))
    if len(middle) < 2 or np.ptp(along[middle]) < _LEAST_REACH * np.ptp(along):
        middle = np.arange(len(along))
    pair = middle[[np.argmin(along[middle]), np.argmax(along[middle])]]
    distance = np.linalg.norm(sheet.vertices[pair[1]] - sheet.vertices[pair[0]])
    return np.concatenate([pair, pair + len(sheet.vertices)]), np.array([0.0, distance, 0.0, 0.0])


def _wave(line: Array) -> float:
    """Largest distance of a run of points (K, 2) from the line through its ends."""
    span = line[-1] - line[0]
    length = np.linalg.norm(span)
    if length == 0:  # a ring
        return np.inf
    return float(np.abs((line - line[0]) @ np.array([-span[1], span[0]])).max() / length)


def _collinearity_rows(flat: Array, lines: list[Indices]) -> sparse.csr_array:
    """Rows of Eq. 16 for unknowns (u, v): each vertex of a line against the line through its two ends.

    As printed, the rows also fix each vertex's place along the line. On a ragged edge that place is more wrong than in
    the map without rows. So here only the offset across the line counts, with the line's direction from the map without
    rows. Lines that wave too much in that map get no rows.
    """
    count = len(flat)
    entries: list[tuple[int, int, float]] = []
    row = 0
    for line in lines:
        if _wave(flat[line]) >= _MOST_WAVE:
            continue
        first, last = int(line[0]), int(line[-1])
        span = flat[last] - flat[first]
        normal = np.array([-span[1], span[0]]) / np.linalg.norm(span)
        for vertex in line[1:-1]:
            t = float((flat[vertex] - flat[first]) @ span / (span @ span))
            for node, share in ((int(vertex), 1.0), (first, t - 1.0), (last, -t)):
                entries += [(row, node, share * normal[0]), (row, node + count, share * normal[1])]
            row += 1
    rows, columns, values = zip(*entries, strict=True) if entries else ((), (), ())
    return sparse.csr_array((values, (rows, columns)), shape=(row, 2 * count), dtype=float)


def as_rigid_as_possible(
    sheet: Sheet, start: Array, lines: list[Indices], watch: Watch = SILENT, *, pins: Pins | None = None
) -> Array:
    """Minimise ``sum_t area_t |J_t - R_t|^2`` over maps J and rotations R (Liu et al. 2008).

    Parameters
    ----------
    sheet : Sheet
        Of about unit area.
    start : (V, 2) array
        A flat map without flips.
    lines : list of int arrays
        Runs of vertices that should become straight.
    watch : Watch
    pins : Pins, optional
        Two or more, u right, v up.

    Returns
    -------
    flat : (V, 2) array
        u right, v up.
    """
    area = areas(sheet.vertices, sheet.triangles)
    along_x, along_y = gradient_rows(sheet.vertices, sheet.triangles)
    gradient = sparse.vstack([along_x, along_y], format="csr")
    weight = np.concatenate([area, area]) / area.mean()
    stiffness = gradient.T @ gradient.multiply(weight[:, None])
    straight = _COLLINEARITY_WEIGHT * _collinearity_rows(start, lines)
    matrix = sparse.block_diag([stiffness, stiffness]) + straight.T @ straight
    held = np.zeros(0, np.int64) if pins is None else np.concatenate([pins.vertices, pins.vertices + len(start)])
    values = np.zeros(0) if pins is None else pins.uv.T.ravel()
    system = HeldSystem(matrix, held)

    def turn(flat: Array) -> Array:
        rotation = _nearest_rotations(along_x @ flat, along_y @ flat)
        right = (gradient.T @ (weight[:, None] * rotation)).T.ravel()
        return system.solve(right, values).reshape(2, -1).T

    return settle(start, turn, _ARAP_ITERATIONS, watch, centred=pins is None)


def _nearest_rotations(along_x: Array, along_y: Array) -> Array:
    """Closest rotation to each Jacobian, stacked like its rows: images of the x axes, then of the y axes (2F, 2)."""
    cosine = along_x[:, 0] + along_y[:, 1]
    sine = along_x[:, 1] - along_y[:, 0]
    length = np.hypot(cosine, sine) + 1e-300
    cosine, sine = cosine / length, sine / length
    return np.concatenate([np.stack([cosine, sine], 1), np.stack([-sine, cosine], 1)])
