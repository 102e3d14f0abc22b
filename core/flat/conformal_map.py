"""The conformal map of a sheet: the paper's section 3.2 (Eq. 13-19), and its l2 version."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..arrays import Array, Indices
from ..errors import StepFailed
from ..numeric.robust import Loss, minimize
from ..numeric.triangles import areas, gradient_rows, signed_areas
from ..sheet import Sheet
from ..watch import SILENT, Watch
from .pins import Pins
from .straight_lines import collinearity_rows

# Values without a figure are choices; no measurement of them is recorded.
# The paper's theta, for a page of unit area with triangles of unit weight on average.
_PIN_WEIGHT = 1e3
# The two pins of a conformal map are in the middle of the sheet: within this share of its width, which is a choice.
_MIDDLE = 0.1
# On a mesh of a few triangles that strip may not reach this far along the sheet; then all vertices may be pins.
_LEAST_REACH = 0.5
# Relative shear below which the l1 loss of a conformal row is quadratic.
_L1_SCALE = 1e-3
# The most iterations. They end earlier once no vertex moves by more than the tolerance, a share of the page.
_L1_ITERATIONS = 30
_TOLERANCE = 1e-6


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
        rows = sparse.vstack([rows, collinearity_rows(free, lines)], format="csr")
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
