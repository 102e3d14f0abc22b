"""Place photos of any light over a sheet whose page is known."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from .descriptors import LARGEST_ANGLE, LARGEST_RATIO, inverted, unit_vectors
from .features import features
from .messages import report
from .photos import picture_of, read_picture
from .results import save

# Features that are compared with all of the page at once.
_COMPARED = 1024
# Focal lengths to try for a photo on the page, relative to the long side: from one to the next it grows by a quarter.
_TRIED_FOCAL_LENGTHS = 0.4 * 1.25 ** np.arange(10)
# How far a match may lie from its place on the sheet, relative to the long side: the surface is off by less than a
# thousandth of the page, and the dense alignment that follows takes up a hundredth.
_OFF_THE_SHEET = 0.004
# A pose from fewer matches is a coincidence: 11 of 1500 wrong ones agree with the best of all poses.
_FEWEST_ON_SHEET = 20
# The search for a pose ends when one with this share of the matches would have been found.
_LEAST_AGREEING = 0.2
# Share of the matches with which a camera is good enough to try no other focal length.
_CLEAR = 0.7


def place_on_page(request: dict[str, Any], folder: Path) -> None:
    """Place photos, of any light, over a sheet whose page is known: each on its own, from its matches with the page.

    Picture 0 is the page and ``page_points.npy`` (h, w, 3) has the world point under each of its pixels; the photos
    follow. Print that is bright in one light may be dark in another, so features match as they are or inverted.
    """
    photos, settings = request["photos"], request["settings"]
    points = np.load(folder / "page_points.npy")
    (found, descriptors), *_ = features(folder, [0], settings)
    column, row = found[:, :2].astype(int).T
    on_page = points[row.clip(0, points.shape[0] - 1), column.clip(0, points.shape[1] - 1)].astype(float)
    on_sheet = np.isfinite(on_page[:, 0])
    on_page, of_page = on_page[on_sheet], unit_vectors(descriptors.data[on_sheet])
    names = "poses", "lens", "photo", "world", "pixel", "inlier", "contrary"
    placed: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for index, photo in enumerate(photos):
        ((found, descriptors),) = features(folder, [index + 1], settings)
        height, width = read_picture(folder / picture_of(index + 1)).shape[:2]
        pixel = found[:, :2].astype(float) * [photo["width"] / width, photo["height"] / height]
        mine, its = matched(unit_vectors(descriptors.data), of_page)
        focal_lengths = [*photo["focal_lengths"], *(_TRIED_FOCAL_LENGTHS * max(photo["width"], photo["height"]))]
        pose, lens, inlier = resected(pixel[mine], on_page[its], photo, focal_lengths, settings["seed"])
        rest = mine[~inlier], its[~inlier]
        # one camera took both, so a second pose has the focal length of the first
        focal_lengths = lens[:1].tolist() if np.isfinite(lens[0]) else []
        contrary = resected(pixel[rest[0]], on_page[rest[1]], photo, focal_lengths, settings["seed"])[2].sum()
        for name, value in {
            "poses": pose[None],
            "lens": lens[None],
            "photo": np.full(len(mine), index),
            "world": on_page[its],
            "pixel": pixel[mine],
            "inlier": inlier,
            "contrary": np.array([contrary]),
        }.items():
            placed[name].append(value)
        report((index + 1) / len(photos), f"Placed photo {index + 1} of {len(photos)} on the page")
    save(folder, {name: np.concatenate(values) for name, values in placed.items()}, {})


def matched(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Features that are each other's nearest, as they are or one of them inverted: indices (N,) of both."""
    if not len(first) or len(second) < 2:
        return np.zeros(0, int), np.zeros(0, int)
    nearest, good = np.zeros(len(first), int), np.zeros(len(first), bool)
    best_of_second, nearest_of_second = np.full(len(second), -1.0), np.zeros(len(second), int)
    for begin in range(0, len(first), _COMPARED):
        part = first[begin : begin + _COMPARED]
        alike = np.maximum(part @ second.T, inverted(part) @ second.T)
        nearest[begin : begin + len(part)] = alike.argmax(1)
        next_one, best = np.arccos(np.clip(np.partition(alike, -2, axis=1)[:, -2:], -1, 1)).T
        good[begin : begin + len(part)] = (best < LARGEST_ANGLE) & (best < LARGEST_RATIO * next_one)
        better = alike.max(0) > best_of_second
        nearest_of_second[better] = begin + alike.argmax(0)[better]
        best_of_second[better] = alike.max(0)[better]
    mine = np.flatnonzero(good & (nearest_of_second[nearest] == np.arange(len(first))))
    return mine, nearest[mine]


def resected(
    pixel: np.ndarray, world: np.ndarray, photo: dict[str, Any], focal_lengths: Iterable[float], seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pose (3, 4), lens (4,) of a SIMPLE_RADIAL camera, and which matches (N,) agree; NaN if too few do.

    The focal lengths are tried in turn.
    """
    options, refinement = pycolmap.AbsolutePoseEstimationOptions(), pycolmap.AbsolutePoseRefinementOptions()
    options.ransac.max_error = _OFF_THE_SHEET * max(photo["width"], photo["height"])
    options.ransac.min_inlier_ratio = _LEAST_AGREEING
    options.ransac.random_seed = seed
    refinement.refine_focal_length = refinement.refine_extra_params = True
    best = np.full((3, 4), np.nan), np.full(4, np.nan), np.zeros(len(pixel), bool)
    for focal in focal_lengths:
        camera = pycolmap.Camera.create_from_model_name(0, "SIMPLE_RADIAL", focal, photo["width"], photo["height"])
        if len(pixel) < _FEWEST_ON_SHEET:
            break
        found = pycolmap.estimate_and_refine_absolute_pose(pixel, world, camera, options, refinement)
        if found is not None and found["num_inliers"] > max(best[2].sum(), _FEWEST_ON_SHEET - 1):
            best = found["cam_from_world"].matrix(), np.array(camera.params), np.asarray(found["inlier_mask"], bool)
        if best[2].sum() > _CLEAR * len(pixel):
            break
    return best
