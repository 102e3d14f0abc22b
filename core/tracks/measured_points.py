"""The sheet's points measured again on its print, and the cameras adjusted to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..arrays import Array
from ..camera import Camera
from ..flat.flatten import flatten
from ..page.page import lay_out
from ..page.page_cells import ReadPhoto
from ..sheet import Sheet
from ..sparse_model import SparseModel
from ..watch import SILENT, Watch
from .adjustment import adjust
from .dense_tracks import dense_tracks
from .triangulation import Triangulated, triangulate

# Pixels of the page's longer side, at least, and how many tracks are enough with that. A print of 316 photo pixels is
# off by .05 of the first surface's error with 1000 pixels, by .066 with 600 to 800. But a flat print of 180, hardly any
# of which falls into a window when it is enlarged that much, has 33 tracks with 1000 pixels and 213 with 500, off its
# plane by .1 % of its extent; its 69 points of structure from motion are off by .5 %.
_SIDES = ((1000, 300), (500, 100))
# With more scatter (pixels), the print was not followed, and the points of before serve better. A choice.
_MOST_SCATTER = 2.0
# A point of structure from motion is kept where no track lies within this part of the sheet's extent. A choice.
_LONELY = 0.04
# This many tracks, spread evenly, fix the cameras. A choice.
_ADJUSTED = 5000
_UP = np.array([0.0, -1.0])


@dataclass(frozen=True)
class MeasuredPoints:
    """Points on the sheet, the cameras that see them, and how well they agree.

    Attributes
    ----------
    cameras : tuple of Camera
        As in the sparse model, with poses and a lens that suit the tracks.
    points : (N, 3) array
        World frame of these cameras.
    observed : (N, C, 2) array
        Where the photos show them, distorted pixels; NaN where they do not, or do not agree.
    tracks : int
        How many of the points are tracks of the print; the others are those of the sparse model.
    scatter : float
        Standard deviation of an observation's coordinate, pixels.
    """

    cameras: tuple[Camera, ...]
    points: Array
    observed: Array
    tracks: int
    scatter: float


def measure_points(
    model: SparseModel,
    on_sheet: NDArray[np.bool_],
    sheet: Sheet,
    reference: int,
    read_photo: ReadPhoto,
    threads: int = 1,
    watch: Watch = SILENT,
) -> MeasuredPoints | None:
    """Follow the print of a sheet that is about known through all photos.

    Where structure from motion finds a few thousand points, each to a third of a pixel, the print has ten thousand
    places that can be found to a few hundredths. They show what one radial coefficient cannot: the lens is adjusted
    with the cameras, by a second coefficient and its principal point, one for all photos.

    Parameters
    ----------
    model : SparseModel
    on_sheet : (P,) bool array
        Which of the model's points lie on the sheet.
    sheet : Sheet
        Its surface from those points.
    reference : int
        Index of the reference photo.
    read_photo : callable
        Gives the pixels of the photo with an index.
    threads : int
        How many photos are looked at at once.
    watch : Watch

    Returns
    -------
    MeasuredPoints or None
        None where too little of the print can be followed.

    Raises
    ------
    Cancelled, StepFailed
    """
    cameras = model.cameras
    flat = lay_out(sheet, flatten(sheet), cameras[reference], _UP)
    for least_side, enough in _SIDES:
        tracks = dense_tracks(sheet, flat, cameras, read_photo, reference, least_side, threads, watch.part(0, 0.9))
        if len(tracks) >= enough:
            break
    else:
        return None
    watch.step(0.9, "Adjusting the cameras to the print")
    first = triangulate(cameras, tracks)
    agreed = _kept(first, tracks)
    adjusted = adjust(cameras, agreed[:: -(-len(agreed) // _ADJUSTED)])
    found = triangulate(adjusted, tracks)
    points = found.points[found.usable]
    if len(points) < enough or found.deviation > _MOST_SCATTER:
        return None
    others, observed = _sparse_points(model.select(on_sheet), adjusted)
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    lonely = cKDTree(points).query(others)[0] > _LONELY * extent
    return MeasuredPoints(
        adjusted,
        np.concatenate([points, others[lonely]]),
        np.concatenate([_kept(found, tracks), observed[lonely]]),
        len(points),
        found.deviation,
    )


def _sparse_points(model: SparseModel, cameras: tuple[Camera, ...]) -> tuple[Array, Array]:
    """The model's points (N, 3) as other cameras have them, and where the photos show these points (N, C, 2)."""
    observed = model.observations()
    moved = triangulate(cameras, observed, model.points)
    return moved.points[moved.usable], _kept(moved, observed)


def _kept(found: Triangulated, observed: Array) -> Array:
    """The observations (N, C, 2) of the usable points that agree on them."""
    return np.where(found.kept[..., None], observed, np.nan)[found.usable]
