"""The sheet as a relief over its flat page, whose surface faces as the sheet does at every place.

A sheet that is folded far is no height over its page: parts of it lie over one another, or stand upright. What a page
can show of it is where each part faces, and a height whose slopes agree with that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from ..arrays import Array
from ..light.normals import corner_normals
from ..numeric.triangles import areas, gradient_rows, local_coordinates
from ..page.page_frame import rotation_to_page
from ..sheet import FlatMap, Sheet

# Degrees to the page's plane. Steeper paper counts as this steep: at 80 degrees a relief rises 5.7 times its width, and
# what hangs over cannot be shown at all.
_STEEPEST = 80.0
_SMALLEST = 1e-9  # area of a triangle on the page, share of the largest: smaller ones have no slope
_NO_AREA = 1e-150  # length of a normal: a triangle that has no area in space counts as level
_ANCHOR = 1e-10  # share of the system's mean diagonal: slopes leave the mean height open


@dataclass(frozen=True)
class Relief:
    """A sheet's relief over its flat page; x points right, y up and z out of the printed side.

    Attributes
    ----------
    normals : (F, 3, 3) array
        Unit normal at each corner of each triangle, as the sheet stands; it jumps at creases.
    heights : (V, 3) array
        The page's vertices raised to the relief, in page heights; the mean over the page is at 0.
    slopes : (F, 3, 2) array
        Gradient of the height at each corner of each triangle.
    """

    normals: Array
    heights: Array
    slopes: Array


def find_relief(sheet: Sheet, flat: FlatMap) -> Relief:
    """Find the relief of a sheet.

    The sheet is turned as close to its page as it can be. The heights are those whose surface is best perpendicular to
    the normals of the sheet's triangles, in the sense of least squares (Poisson's equation, weighted by how flat a
    triangle lies). They are exact if the sheet's parts turn about lines that stay parallel to the page.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap

    Returns
    -------
    Relief
    """
    rotation = rotation_to_page(sheet, flat)
    on_page = np.column_stack([flat.uv * (1, -1) / flat.height, np.zeros(len(flat.uv))])
    corner = sheet.vertices[sheet.triangles] @ rotation.T
    faces = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    on_page[:, 2] = _heights(on_page, sheet, _not_too_steep(faces))
    smooth = corner_normals(Sheet(on_page, sheet.triangles, sheet.ridges, sheet.boundary))
    return Relief(_not_too_steep(corner_normals(sheet) @ rotation.T), on_page, slopes_of(_not_too_steep(smooth)))


def slopes_of(normals: Array) -> Array:
    """Gradient (..., 2) of the height of a surface with these normals (..., 3)."""
    return np.asarray(-normals[..., :2] / normals[..., 2:])


def _not_too_steep(normals: Array) -> Array:
    """Unit normals (..., 3), those of paper that is steeper than `_STEEPEST` raised to it."""
    across = np.linalg.norm(normals[..., :2], axis=-1, keepdims=True)
    up = np.maximum(normals[..., 2:], across / np.tan(np.radians(_STEEPEST)))
    raised = np.concatenate([normals[..., :2], np.maximum(up, _NO_AREA)], axis=-1)
    return np.asarray(raised / np.linalg.norm(raised, axis=-1, keepdims=True))


def _heights(on_page: Array, sheet: Sheet, normals: Array) -> Array:
    """Heights (V,) of vertices on the page (V, 3) for normals (F, 3) of the triangles, by least squares."""
    area = areas(on_page, sheet.triangles)
    usable = area > _SMALLEST * area.max()
    triangles, normals, area = sheet.triangles[usable], normals[usable], area[usable]
    corner = on_page[triangles]
    along = corner[:, 1] - corner[:, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    local = local_coordinates(on_page, triangles)
    across = corner[:, 2] - corner[:, 0] - local[:, 2, :1] * along
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    weight = np.sqrt(area) * normals[:, 2]
    rows = sparse.vstack([each.multiply(weight[:, None]) for each in gradient_rows(on_page, triangles)]).tocsr()
    slope = slopes_of(normals)
    target = np.concatenate([weight * (slope * axis[:, :2]).sum(axis=1) for axis in (along, across)])
    system = (rows.T @ rows).tocsc()
    anchored = system + _ANCHOR * system.diagonal().mean() * sparse.eye_array(len(on_page), format="csc")
    heights = spsolve(anchored, rows.T @ target)
    return np.asarray(heights - (area * heights[triangles].mean(axis=1)).sum() / area.sum())
