"""A grid of inverse depths over the reference view: its frame, its sampling rows and its derivative rows.

Inverse depth is linear on a plane and a ray stays a ray, so a smoothness term on it does not change a plane. The rank
of its Hessian identifies a developable surface just as the depth's does. Lengths are in page lengths, units of the
paper's longer side: one threshold suits every scene.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse

from ..arrays import Array
from ..camera import Camera
from ..numeric.polygon import inside_polygon, resample
from .hinges import NO_HINGES, Hinges

# Values without a figure are choices; no measurement of them is recorded.
# Nodes that the grid keeps beyond the paper's edge, for derivatives up to the edge.
_MARGIN_CELLS = 2
# Degrees between the directions in which the paper's longer side is looked for: half of one makes A4 .6 % longer.
_ANGLE_STEP = 1.0


@dataclass(frozen=True)
class ViewFrame:
    """The plane of the reference view on which the grid lies.

    A point at camera coordinates ``(X, Y, Z)`` has plane coordinates ``(X, Y) / Z * depth / unit`` and the scaled
    inverse depth ``depth**2 / (Z * unit)``. Near ``Z = depth`` one unit of either is one page length in space.

    Attributes
    ----------
    camera : Camera
        The reference view.
    depth : float
        A typical depth of the sheet, in world units.
    unit : float
        World units in one page length (the longer side of the paper as the reference view shows it).
    """

    camera: Camera
    depth: float
    unit: float

    def from_pixels(self, pixels: Array) -> Array:
        """Distorted pixels (..., 2) to plane coordinates (..., 2)."""
        return self.camera.undistort(pixels) * (self.depth / self.unit)

    def from_world(self, points: Array) -> tuple[Array, Array]:
        """World points (..., 3) to plane coordinates (..., 2) and scaled inverse depth (...)."""
        in_camera = self.camera.to_camera_frame(points)
        scaled = self.depth / (in_camera[..., 2] * self.unit)
        return in_camera[..., :2] * scaled[..., None], self.depth * scaled

    def to_world(self, plane: Array, inverse_depth: Array) -> Array:
        """Plane coordinates (..., 2) and scaled inverse depth (...) to world points (..., 3)."""
        z = self.depth**2 / (self.unit * inverse_depth)
        in_camera = np.concatenate([plane * (self.unit / self.depth) * z[..., None], z[..., None]], axis=-1)
        return self.camera.to_world_frame(in_camera)


def frame_for(points: Array, camera: Camera, polygon: Array) -> ViewFrame:
    """The frame in which the paper's outline is about one unit long.

    Parameters
    ----------
    points : (N, 3) array
        Points on the sheet, world frame.
    camera : Camera
        The reference view.
    polygon : (K, 2) array
        The paper's outline in distorted pixels.
    """
    depth = float(np.median(camera.to_camera_frame(points)[:, 2]))
    return ViewFrame(camera, depth, depth * _long_side(camera.undistort(polygon)))


def _long_side(polygon: Array) -> float:
    """Length of the longer side of the polygon's smallest bounding rectangle."""
    angles = np.radians(np.arange(0.0, 90.0, _ANGLE_STEP))
    along = polygon @ np.stack([np.cos(angles), np.sin(angles)])
    across = polygon @ np.stack([-np.sin(angles), np.cos(angles)])
    width, height = np.ptp(along, axis=0), np.ptp(across, axis=0)
    best = np.argmin(width * height)
    return float(max(width[best], height[best]))


@dataclass(frozen=True)
class DepthGrid:
    """A regular grid of nodes over the reference view, of which those on and around the paper are in use.

    Attributes
    ----------
    frame : ViewFrame
    origin : (2,) array
        Plane coordinates of node (0, 0).
    step : float
        Distance between nodes, page lengths.
    index : (rows, columns) int array
        Number of each node in the solver's vector, -1 where it is not in use.
    hinges : Hinges
        Known creases; their unknowns follow those of the nodes.
    """

    frame: ViewFrame
    origin: Array
    step: float
    index: NDArray[np.int64]
    hinges: Hinges = NO_HINGES

    @property
    def size(self) -> int:
        """Number of nodes in use."""
        return int(self.index.max()) + 1

    @property
    def unknowns(self) -> int:
        """Number of unknowns: nodes in use and those of the hinges."""
        return self.size + self.hinges.unknowns

    def node_positions(self) -> Array:
        """Plane coordinates of the nodes in use, shape (size, 2)."""
        row, column = np.nonzero(self.index >= 0)
        return self.origin + self.step * np.stack([column, row], axis=1)

    def to_image(self, values: Array) -> Array:
        """Node values (size,) as an array (rows, columns), NaN where no node is in use."""
        image = np.full(self.index.shape, np.nan)
        image[self.index >= 0] = values
        return image

    def sampling_rows(self, positions: Array) -> tuple[sparse.csr_array, NDArray[np.bool_]]:
        """Bilinear interpolation at plane coordinates (N, 2), on each side of a hinge from that side only.

        Returns
        -------
        rows : (M, unknowns) sparse array
            One row for each position in a cell whose four nodes are in use.
        inside : (N,) bool array
            Which positions those are.
        """
        lines, columns = self.index.shape
        cell = (positions - self.origin) / self.step
        corner = np.clip(np.floor(cell).astype(int), 0, [columns - 2, lines - 2])
        fraction = cell - corner
        c, r = corner.T
        around = [self.index[r, c], self.index[r, c + 1], self.index[r + 1, c], self.index[r + 1, c + 1]]
        nodes = np.stack(around, axis=1)
        inside = (nodes >= 0).all(1) & (fraction >= 0).all(1) & (fraction <= 1).all(1)
        fx, fy = fraction[inside].T
        weights = np.stack([(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy], axis=1)
        count = int(inside.sum())
        pointer = np.arange(0, 4 * count + 1, 4)
        rows = sparse.csr_array((weights.ravel(), nodes[inside].ravel(), pointer), shape=(count, self.size))
        return self._hinged(rows, positions[inside], nodes[inside], weights), inside

    def interpolate(self, values: Array, positions: Array) -> Array:
        """Values (unknowns,) at plane coordinates (N, 2), exact for quadratics: a rounded crease keeps its crest.

        Raises
        ------
        ValueError
            If a position is off the grid.
        """
        rows, inside = self.sampling_rows(positions)
        if not inside.all():
            raise ValueError("positions off the grid")
        fraction = ((positions - self.origin) / self.step) % 1.0
        result = rows @ values
        at_nodes = rows[:, : self.size] if len(self.hinges) else rows
        differences = self.second_differences()
        for stencil, part in ((differences.xx, fraction[:, 0]), (differences.yy, fraction[:, 1])):
            bend = np.zeros(self.size)
            bend[stencil.nodes] = stencil.rows @ values
            result -= part * (1 - part) / 2 * (at_nodes @ bend)
        return result

    def second_differences(self) -> SecondDifferences:
        """Second derivatives at every node whose neighbours are in use; natural borders need no rows of their own."""
        return SecondDifferences(
            xx=self._stencil([(0, -1, 1.0), (0, 0, -2.0), (0, 1, 1.0)]),
            yy=self._stencil([(-1, 0, 1.0), (0, 0, -2.0), (1, 0, 1.0)]),
            xy=self._stencil([(0, 0, 1.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, 1.0)]),
            falling=self._stencil([(-1, -1, 0.5), (0, 0, -1.0), (1, 1, 0.5)]),
            rising=self._stencil([(-1, 1, 0.5), (0, 0, -1.0), (1, -1, 0.5)]),
        )

    def hessian_rows(self) -> tuple[sparse.csr_array, sparse.csr_array, sparse.csr_array, NDArray[np.int64]]:
        """Rows of the Hessian's entries (Eq. 10) at the nodes whose eight neighbours are in use.

        Returns
        -------
        xx, xy, yy : (K, unknowns) sparse arrays
            In 1 / page length, without the turns at hinges.
        nodes : (K,) int array
            The nodes of the rows.
        """
        used = self.index >= 0
        whole = ndimage.binary_erosion(used, np.ones((3, 3)), border_value=0)
        scale = 1 / self.step**2
        xx = self._stencil([(0, -1, scale), (0, 0, -2 * scale), (0, 1, scale)], whole)
        yy = self._stencil([(-1, 0, scale), (0, 0, -2 * scale), (1, 0, scale)], whole)
        quarter = scale / 4
        corners = [(-1, -1, quarter), (-1, 1, -quarter), (1, -1, -quarter), (1, 1, quarter)]
        return xx.rows, self._stencil(corners, whole).rows, yy.rows, self.index[whole]

    def _stencil(self, entries: list[tuple[int, int, float]], where: NDArray[np.bool_] | None = None) -> Stencil:
        padded = np.pad(self.index, 1, constant_values=-1)
        rows, columns = self.index.shape
        shifted = [padded[1 + dr : 1 + dr + rows, 1 + dc : 1 + dc + columns] for dr, dc, _ in entries]
        complete = np.all([s >= 0 for s in shifted], axis=0) & (self.index >= 0)
        if where is not None:
            complete &= where
        nodes = np.stack([s[complete] for s in shifted], axis=1)
        values = np.tile([weight for _, _, weight in entries], len(nodes))
        pointer = np.arange(0, nodes.size + 1, len(entries))
        matrix = sparse.csr_array((values, nodes.ravel(), pointer), shape=(len(nodes), self.size))
        at = self.index[complete]
        positions = self.node_positions()[at]
        return Stencil(self._hinged(matrix, positions, nodes, values.reshape(nodes.shape)), at)

    def _hinged(
        self, rows: sparse.csr_array, places: Array, nodes: NDArray[np.int64], weights: Array
    ) -> sparse.csr_array:
        """Rows over the nodes (N, size) with the hinges' columns appended; the other parameters as `Hinges.columns`."""
        if not len(self.hinges):
            return rows
        return sparse.hstack([rows, self.hinges.columns(places, self.node_positions()[nodes], weights)], format="csr")


@dataclass(frozen=True)
class Stencil:
    """Rows (N, unknowns) of one finite difference and their nodes."""

    rows: sparse.csr_array
    nodes: NDArray[np.int64]


@dataclass(frozen=True)
class SecondDifferences:
    """Undivided second differences: along x, along y, mixed (cell by cell), and along the two diagonals.

    The diagonal ones are halved: like the others they are ``step**2`` times a second derivative along a unit vector.
    """

    xx: Stencil
    yy: Stencil
    xy: Stencil
    falling: Stencil
    rising: Stencil


def grid_over(frame: ViewFrame, polygon: Array, rows: int) -> DepthGrid:
    """The grid whose nodes cover an outline.

    Parameters
    ----------
    frame : ViewFrame
    polygon : (K, 2) array
        The paper's outline in plane coordinates.
    rows : int
        Nodes along one page length.
    """
    step = 1.0 / rows
    low = polygon.min(0) - _MARGIN_CELLS * step
    columns, lines = np.ceil((polygon.max(0) + _MARGIN_CELLS * step - low) / step).astype(int) + 1
    cells = np.stack(np.meshgrid(np.arange(columns), np.arange(lines)), axis=-1) * step + low
    near = inside_polygon(cells.reshape(-1, 2), polygon).reshape(lines, columns)
    outline = np.round((resample(polygon, step / 2) - low) / step).astype(int)
    near[outline[:, 1], outline[:, 0]] = True
    used = ndimage.binary_dilation(near, np.ones((3, 3)), iterations=_MARGIN_CELLS)
    index = np.full(used.shape, -1)
    index[used] = np.arange(used.sum())
    return DepthGrid(frame, low, step, index)
