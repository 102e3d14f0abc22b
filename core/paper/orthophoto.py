"""The scene from straight above, joined from all photos: where paper and table are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from ..arrays import Array
from ..camera import Camera
from ..numeric.image import perceptual, sample_bilinear, shrink
from ..sparse_model import SparseModel
from .reference_view import prominence

# Cells along what the long side of a typical photo shows.
_CELLS_PER_PHOTO = 450
# The map reaches this far from its middle, in long sides of what a typical photo shows.
_REACH = 0.85
_MIN_COVERAGE = 2
_PLANE_TRIALS = 400
# Distance from the plane, in parts of the points' median distance from their middle, that still counts as on it.
_PLANE_TOLERANCE = 0.01
# Points further from the plane than this, in the same unit, are of other things than the sheet and its table.
_HIGHEST = 0.8
# Cells darker than this (of 100) tell nothing of a photo's exposure.
_DARK = 15.0
# Exposure is matched on every so many rows and columns.
_SPARSE = 4
_HEIGHT_NODES = 36
_HEIGHT_STIFFNESS = 0.03
# Far from all points the map of the whole scene turns level within some nodes; that of a sheet runs on straight.
_HEIGHT_TENSION, _HEIGHT_PULL = 0.004, 0.0004
_SHEET_TENSION, _SHEET_PULL = 0.0005, 1e-6


@dataclass(frozen=True)
class GroundFrame:
    """A plane near the sheet, with axes in it that lie as the photos do.

    Attributes
    ----------
    origin : (3,) array
        World frame.
    axes : (3, 3) array
        Rows: right, down, and up off the plane towards the cameras; world frame, orthonormal.
    size : float
        Median distance of the photos' main points from the origin, world units.
    """

    origin: Array
    axes: Array
    size: float

    def from_world(self, points: Array) -> Array:
        """World points (..., 3) as right, down, height (..., 3)."""
        return (points - self.origin) @ self.axes.T

    def to_world(self, local: Array) -> Array:
        """Right, down, height (..., 3) as world points (..., 3)."""
        return local @ self.axes + self.origin


@dataclass(frozen=True)
class Orthophoto:
    """A map of the scene, seen at right angles to the main plane.

    Cell ``(row, column)`` has its centre at the map position ``(column + 0.5, row + 0.5)``.

    Attributes
    ----------
    frame : GroundFrame
    corner : (2,) array
        Right and down, in world units of the frame, of the map's first corner.
    cell : float
        Side of a cell, world units.
    height : (h, w) array
        Of the surface above the frame's plane, world units.
    color : (h, w, 3) float32 array
        Oklab times 100, the median over the photos that show the cell.
    coverage : (h, w) int array
        How many photos show the cell.
    disagreement : (h, w) float32 array
        Median distance of the photos' colours from ``color``: large where the cell's surface is elsewhere.
    """

    frame: GroundFrame
    corner: Array
    cell: float
    height: Array
    color: NDArray[np.float32]
    coverage: NDArray[np.int64]
    disagreement: NDArray[np.float32]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.coverage.shape[0], self.coverage.shape[1]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which cells (h, w) enough photos show."""
        return self.coverage >= _MIN_COVERAGE

    def from_world(self, points: Array) -> Array:
        """Map positions (..., 2) of world points (..., 3)."""
        return (self.frame.from_world(points)[..., :2] - self.corner) / self.cell

    def to_world(self, positions: Array) -> Array:
        """World points (..., 3) of the surface at map positions (..., 2)."""
        height = sample_bilinear(self.height[..., None], positions)
        return self.frame.to_world(np.concatenate([positions * self.cell + self.corner, height], axis=-1))

    def on_sheet(self, points: Array) -> Orthophoto:
        """The same map with the surface that the points (N, 3), world frame, of one sheet alone make."""
        rows, columns = self.shape
        height = _height_map(
            self.frame.from_world(points), self.frame, self.corner, self.cell, self.shape, _SHEET_TENSION, _SHEET_PULL
        )
        return replace(self, height=height[:rows, :columns])


def orthophoto(model: SparseModel, photos: Sequence[NDArray[np.float32]]) -> Orthophoto:
    """Join all photos to one view from straight above.

    Parameters
    ----------
    model : SparseModel
    photos : sequence of (h, w, 3) float32 arrays
        One for each camera of the model: linear light, as `image.reduced` gives it.
    """
    weight = prominence(model)
    frame = _ground_frame(model, weight)
    footprint = float(np.median([_footprint(camera, frame) for camera in model.cameras]))
    cell = footprint / _CELLS_PER_PHOTO
    cells = round(2 * _REACH * _CELLS_PER_PHOTO)
    corner = np.full(2, -0.5 * cells * cell)
    local = frame.from_world(model.points[weight > 0])
    height = _height_map(local, frame, corner, cell, (cells, cells), _HEIGHT_TENSION, _HEIGHT_PULL)
    return _joined(model, photos, frame, corner, cell, height)


def closer(
    ortho: Orthophoto, model: SparseModel, photos: Sequence[NDArray[np.float32]], points: Array, low: Array, high: Array
) -> Orthophoto:
    """A part of the map again, on the surface that the points (N, 3) of one sheet make.

    What lies on that surface, or on its straight continuation, is sharp there; the table is not, where it is lower.

    Parameters
    ----------
    ortho : Orthophoto
    model : SparseModel
    photos : sequence of (h, w, 3) float32 arrays
        As for `orthophoto`.
    points : (N, 3) array
        World frame.
    low, high : (2,) arrays
        Map positions of the part's corners.
    """
    first = np.floor(low)
    columns, rows = np.maximum(np.ceil(high) - first, 1).astype(int)
    corner = ortho.corner + first * ortho.cell
    local = ortho.frame.from_world(points)
    height = _height_map(local, ortho.frame, corner, ortho.cell, (rows, columns), _SHEET_TENSION, _SHEET_PULL)
    return _joined(model, photos, ortho.frame, corner, ortho.cell, height)


def _joined(
    model: SparseModel,
    photos: Sequence[NDArray[np.float32]],
    frame: GroundFrame,
    corner: Array,
    cell: float,
    height: Array,
) -> Orthophoto:
    """The map at given heights (h, w) of its cells, cut to what enough photos show."""
    down, right = (np.arange(length) * cell + 0.5 * cell for length in height.shape)
    right, down = np.meshgrid(right + corner[0], down + corner[1])
    surface = frame.to_world(np.stack([right, down, height], axis=-1))
    seen = [_seen(camera, surface) for camera in model.cameras]
    shown = np.stack([np.isfinite(pixels[..., 0]) for pixels in seen])
    rows, columns = _extent(shown.sum(axis=0) >= _MIN_COVERAGE)
    shown = shown[:, rows, columns]
    colors = np.stack(
        [
            _colors(camera, photo, pixels[rows, columns], frame, cell)
            for camera, photo, pixels in zip(model.cameras, photos, seen, strict=True)
        ]
    )
    color, disagreement = _join(colors, shown)
    return Orthophoto(
        frame,
        corner + np.array([columns.start, rows.start]) * cell,
        cell,
        height[rows, columns],
        color,
        shown.sum(axis=0),
        disagreement,
    )


def _ground_frame(model: SparseModel, weight: Array) -> GroundFrame:
    """The plane most of the main points lie on: the sheet's own, its table's, or the mean plane of a bent sheet."""
    used = weight > 0
    points, weight = model.points[used], weight[used] ** 2
    middle = np.array([_weighted_median(points[:, axis], weight) for axis in range(3)])
    size = _weighted_median(np.linalg.norm(points - middle, axis=1), weight)
    near = np.linalg.norm(points - middle, axis=1) < 4 * size
    points, weight = points[near], weight[near]
    tolerance = _PLANE_TOLERANCE * size
    random = np.random.default_rng(0)
    chance = weight / weight.sum()
    running = np.cumsum(chance)
    origin, normal, most = middle, _normal(points - middle, chance), -1.0
    for _ in range(_PLANE_TRIALS):
        first, second, third = points[np.searchsorted(running, random.random(3) * running[-1])]
        across = np.cross(second - first, third - first)
        length = float(np.linalg.norm(across))
        if length < 1e-3 * size**2:
            continue
        off = (points - first) @ across / length
        on_plane = float(chance @ np.maximum(1 - (off / (3 * tolerance)) ** 2, 0))
        if on_plane > most:
            origin, normal, most = first, across / length, on_plane
    for _ in range(5):
        off = (points - origin) @ normal
        trust = chance * np.maximum(1 - (off / (4 * tolerance)) ** 2, 0) ** 2
        if (trust > 0).sum() < 3:
            break
        origin = trust @ points / trust.sum()
        normal = _normal(points - origin, trust)
    # the middle of the map is where the photos look, not where the table's grain happens to be rich
    origin = middle - ((middle - origin) @ normal) * normal
    towards = np.mean([camera.center for camera in model.cameras], axis=0) - origin
    normal = normal * np.sign(normal @ towards)
    right = sum(camera.rotation[0] for camera in model.cameras)
    right = right - (right @ normal) * normal
    if np.linalg.norm(right) < 1e-6 * len(model.cameras):
        right = np.linalg.svd(normal[None])[2][1]
    right = right / np.linalg.norm(right)
    return GroundFrame(origin, np.stack([right, np.cross(right, normal), normal]), size)


def _normal(offsets: Array, weight: Array) -> Array:
    """Of the plane through the origin that lies nearest to weighted points (N, 3)."""
    return np.asarray(np.linalg.svd(offsets * np.sqrt(weight)[:, None], full_matrices=False)[2][2])


def _weighted_median(values: Array, weight: Array) -> float:
    order = np.argsort(values)
    running = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])


def _footprint(camera: Camera, frame: GroundFrame) -> float:
    """Length in the plane that the photo's long side shows about the frame's origin, world units."""
    return float(np.linalg.norm(frame.origin - camera.center)) / camera.focal_length * max(camera.width, camera.height)


def _height_map(
    local: Array, frame: GroundFrame, corner: Array, cell: float, shape: tuple[int, int], tension: float, pull: float
) -> Array:
    """A smooth surface through the points (N, 3), robustly, at all cells of a map of this shape."""
    node = max(shape) * cell / (_HEIGHT_NODES - 1)
    at = (local[:, :2] - corner) / node
    near = (np.abs(local[:, 2]) < _HIGHEST * frame.size) & ((at > 0) & (at < _HEIGHT_NODES - 1)).all(axis=1)
    at, height = at[near], local[near, 2]
    if not len(at):
        return np.zeros(shape)
    index = np.arange(_HEIGHT_NODES**2).reshape(_HEIGHT_NODES, _HEIGHT_NODES)
    column, row = np.floor(at).astype(np.int64).T
    x, y = (at - np.floor(at)).T
    corners = [(row, column, (1 - x) * (1 - y)), (row, column + 1, x * (1 - y))]
    corners += [(row + 1, column, (1 - x) * y), (row + 1, column + 1, x * y)]
    places = np.tile(np.arange(len(at)), 4), np.concatenate([index[r, c] for r, c, _ in corners])
    sampling = sparse.csr_matrix((np.concatenate([share for _, _, share in corners]), places), (len(at), index.size))
    held = _stiffness(_HEIGHT_NODES, tension) + pull * sparse.identity(index.size)
    # points in crowds speak with one voice, or dense print would outvote sparse margins
    crowd = np.bincount(index[row, column], minlength=index.size)[index[row, column]]
    trust = 1 / crowd
    nodes = np.zeros(index.size)
    for _ in range(6):
        weighted = sparse.diags(trust) @ sampling
        nodes = spsolve((sampling.T @ weighted + held).tocsc(), weighted.T @ height)
        off = np.abs(height - sampling @ nodes)
        trust = 1 / crowd / np.maximum(off / (_PLANE_TOLERANCE * frame.size), 1)
    lowest, highest = np.quantile(height, [0.005, 0.995])
    margin = 0.5 * (highest - lowest)
    grid = np.clip(nodes, lowest - margin, highest + margin).reshape(_HEIGHT_NODES, _HEIGHT_NODES)
    down, across = ((np.arange(length) + 0.5) * cell / node + 0.5 for length in shape)
    return sample_bilinear(grid[..., None], np.stack(np.meshgrid(across, down), axis=-1))[..., 0].astype(np.float64)


def _stiffness(nodes: int, tension: float) -> sparse.spmatrix:
    """Energy of bending and, in this part, of stretching of a square grid of nodes."""
    one = sparse.identity(nodes)
    bend = sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(nodes - 2, nodes))
    step = sparse.diags([-1.0, 1.0], [0, 1], shape=(nodes - 1, nodes))
    bending = sparse.vstack([sparse.kron(one, bend), sparse.kron(bend, one), np.sqrt(2) * sparse.kron(step, step)])
    slope = sparse.vstack([sparse.kron(one, step), sparse.kron(step, one)])
    return _HEIGHT_STIFFNESS * bending.T @ bending + tension * slope.T @ slope


def _seen(camera: Camera, surface: Array) -> Array:
    """Pixels (..., 2) of the surface (..., 3) in a photo; NaN outside of it."""
    in_camera = camera.to_camera_frame(surface)
    depth = np.where(in_camera[..., 2] > 0, in_camera[..., 2], np.nan)
    normalized = in_camera[..., :2] / depth[..., None]
    frame = np.array([[0, 0], [camera.width, 0], [0, camera.height], [camera.width, camera.height]], float)
    # beyond the photo's corners a distortion polynomial may turn back into the photo
    farthest = 1.1 * float((camera.undistort(frame) ** 2).sum(axis=1).max())
    pixels = camera.distort(normalized)
    inside = ((pixels > 1) & (pixels < [camera.width - 1, camera.height - 1])).all(axis=-1)
    inside &= (normalized**2).sum(axis=-1) < farthest
    return np.asarray(np.where(inside[..., None], pixels, np.nan))


def _extent(mask: NDArray[np.bool_]) -> tuple[slice, slice]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return slice(0, mask.shape[0]), slice(0, mask.shape[1])
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


def _colors(
    camera: Camera, photo: NDArray[np.float32], pixels: Array, frame: GroundFrame, cell: float
) -> NDArray[np.float32]:
    """Colours (h, w, 3) of a reduced photo at full pixels (h, w, 2), Oklab times 100; NaN outside of it."""
    reduction = round(camera.width / photo.shape[1])
    pixels_per_cell = camera.focal_length * cell / float(np.linalg.norm(frame.origin - camera.center))
    factor = max(1, round(pixels_per_cell / reduction))
    small = perceptual(shrink(photo, factor))
    shown = np.isfinite(pixels[..., 0])
    colors = np.full((*shown.shape, 3), np.nan, np.float32)
    colors[shown] = sample_bilinear(small, pixels[shown] / (factor * reduction))
    return colors


def _join(colors: NDArray[np.float32], shown: NDArray[np.bool_]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Median colour and median distance from it, after each photo's exposure and white balance are matched."""
    some = (slice(None), slice(None, None, _SPARSE), slice(None, None, _SPARSE))
    for _ in range(2):
        few, count = colors[some], shown[some].sum(axis=0)
        joined = _median(few, count)
        for index, visible in enumerate(shown[some]):
            common = visible & (count >= _MIN_COVERAGE) & (joined[..., 0] > _DARK)
            if common.sum() < 100:
                continue
            gain = np.median(few[index][common][:, 0] / joined[common][:, 0])
            colors[index] /= np.clip(gain, 0.3, 3.0)
            colors[index][..., 1:] -= np.median((few[index] - joined)[common][:, 1:], axis=0)
    count = shown.sum(axis=0)
    joined = _median(colors, count)
    off = np.sqrt(((colors - joined) ** 2).sum(axis=-1))
    return np.nan_to_num(joined), np.nan_to_num(_median(off, count))


def _median(values: NDArray[np.float32], count: NDArray[np.int64]) -> NDArray[np.float32]:
    """Median over the first axis, of which ``count`` are not NaN."""
    ordered = np.sort(values, axis=0)
    count = count.reshape(count.shape + (1,) * (values.ndim - 3))
    lower, upper = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(values) - 1)
    low, high = (
        np.take_along_axis(ordered, np.broadcast_to(at, values.shape[1:])[None], axis=0)[0] for at in (lower, upper)
    )
    return np.asarray(0.5 * (low + high))
