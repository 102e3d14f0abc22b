"""How far a flat map is from an isometry, and the best-fitting affine map and similarity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Indices


@dataclass(frozen=True)
class Strain:
    """The strain of each triangle of a sheet under a flat map; an exactly unrolled sheet has ones everywhere.

    Attributes
    ----------
    singular_values : (F, 2) array
        Largest and smallest stretch from the sheet to the page, after dividing by the map's overall scale.
    area : (F,) array
        Area in space, as a share of the whole sheet.
    scale : float
        Page units in one world unit: the square root of the page's area over the sheet's.
    """

    singular_values: Array
    area: Array
    scale: float

    @property
    def angle_distortion(self) -> Array:
        """Quasi-conformal dilatation of each triangle, (F,): 1 where angles are kept, infinite where it collapses."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.nan_to_num(self.singular_values[:, 0] / self.singular_values[:, 1], nan=np.inf, posinf=np.inf)

    @property
    def area_distortion(self) -> Array:
        """Area on the page over area in space of each triangle, (F,)."""
        return self.singular_values.prod(1)

    @property
    def stretch(self) -> Array:
        """Largest relative change of length in each triangle, (F,); 0 for an isometry."""
        return np.abs(self.singular_values - 1).max(1)


def measure_strain(vertices: Array, triangles: Indices, uv: Array) -> Strain:
    """Compare each triangle on the page with the same triangle in space.

    Parameters
    ----------
    vertices : (V, 3) array
        Any units.
    triangles : (F, 3) int array
        None may have zero area in space.
    uv : (V, 2) array
        Position of each vertex on the page, any units.

    Returns
    -------
    Strain

    Examples
    --------
    >>> corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    >>> measure_strain(corners, np.array([[0, 1, 2]]), corners[:, :2] * [2, 0.5]).singular_values
    array([[2. , 0.5]])
    """
    edge, other = (vertices[triangles[:, i]] - vertices[triangles[:, 0]] for i in (1, 2))
    # Each triangle laid flat with its first edge on the x axis: the map from there to the page is two by two.
    length = np.linalg.norm(edge, axis=1)
    along = (edge * other).sum(1) / length
    normal = np.cross(edge, other)
    height = np.linalg.norm(normal, axis=1) / length
    flat_edge, flat_other = (uv[triangles[:, i]] - uv[triangles[:, 0]] for i in (1, 2))
    first = flat_edge / length[:, None]
    second = (flat_other - first * along[:, None]) / height[:, None]

    trace = (first**2).sum(1) + (second**2).sum(1)
    determinant = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    # sqrt(a^2 + b^2 +- 2 |ab|) gives sum and difference of the singular values without cancellation in an eigenproblem.
    total = np.sqrt(trace + 2 * np.abs(determinant))
    difference = np.sqrt(np.maximum(trace - 2 * np.abs(determinant), 0))
    singular = np.stack([total + difference, total - difference], -1) / 2

    area = length * height / 2
    scale = float(np.sqrt((area * np.abs(determinant)).sum() / area.sum()))
    return Strain(singular / scale, area / area.sum(), scale)


def flipped_triangles(triangles: Indices, uv: Array) -> NDArray[np.bool_]:
    """Which triangles are on the page with their printed side down or have no area, shape (F,).

    ``uv`` (V, 2) has u to the right and v down; ``triangles`` (F, 3) are counter-clockwise seen from the printed side.
    """
    first, second = (uv[triangles[:, i]] - uv[triangles[:, 0]] for i in (1, 2))
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] >= 0


def fit_affine(source: Array, target: Array) -> Array:
    """Least-squares affine (2, 3) that takes ``source`` (N, 2) to ``target`` (N, 2); its last column is the shift."""
    return np.linalg.lstsq(np.c_[source, np.ones(len(source))], target, rcond=None)[0].T


def fit_similarity(source: Array, target: Array) -> Array:
    """Least-squares rotation, scale and shift (2, 3), no reflection, from ``source`` (N, 2) to ``target`` (N, 2)."""
    a, b = source - source.mean(0), target - target.mean(0)
    spread = (a**2).sum()
    cos, sin = (a * b).sum() / spread, (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / spread
    linear = np.array([[cos, -sin], [sin, cos]])
    return np.c_[linear, target.mean(0) - linear @ source.mean(0)]


def apply_affine(affine: Array, points: Array) -> Array:
    """Points (N, 2) moved by an affine map (2, 3)."""
    return np.asarray(points @ affine[:, :2].T + affine[:, 2])
