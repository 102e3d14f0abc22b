"""What the features alone show of photos that could not be placed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from .descriptors import LARGEST_ANGLE, LARGEST_RATIO, mirrored, unit_vectors
from .photos import name_of
from .results import save

# Features of a photo that are compared.
_SAMPLE = 600
# Two features of a photo are twins if their descriptors are within this angle (radians) and they are at least this
# share of the long side apart. Half of the true matches differ by 0.06 to 0.29.
_TWIN = 0.25
_ELSEWHERE = 0.02
# Smallest size, relative to the long side, of features that are searched for twins: the letters of any text are full of
# smaller ones. Of fewer features nothing is said.
_COARSE = 0.005
_FEWEST_COARSE = 30


def look_closer(request: dict[str, Any], folder: Path) -> None:
    """What the features alone show of photos that could not be placed; the database is one folder above.

    For each photo: the number of features, the size of its finest ones, and the share of the coarse ones that have a
    twin elsewhere in the same photo. For each requested pair: how many features agree if one photo is mirrored, and how
    many agree as they are.
    """
    photos = request["photos"]
    with pycolmap.Database.open(folder.parent / "database.db") as database:
        ids = {image.name: image.image_id for image in database.read_all_images()}
        keypoints = [database.read_keypoints(ids[name_of(i)]) for i in range(len(photos))]
        descriptors = [unit_vectors(database.read_descriptors(ids[name_of(i)]).data) for i in range(len(photos))]
    sides = [max(photo["width"], photo["height"]) for photo in photos]
    figures = {
        "features": [len(found) for found in keypoints],
        "finest_pixels": [float(np.percentile(size(found), 10)) if len(found) else 0.0 for found in keypoints],
        "repeated": [repeated(*found) for found in zip(keypoints, descriptors, sides)],
        "mirrored": [
            [i, j, agreeing(mirrored(descriptors[i]), descriptors[j]), agreeing(descriptors[i], descriptors[j])]
            for i, j in request["pairs"]
        ],
    }
    save(folder, {}, figures)


def sample(count: int) -> np.ndarray:
    """At most ``_SAMPLE`` indices below ``count``, spread evenly."""
    return np.unique(np.linspace(0, max(count - 1, 0), _SAMPLE).astype(int)) if count else np.zeros(0, int)


def size(keypoints: np.ndarray) -> np.ndarray:
    """The size of each feature, in pixels of the photo."""
    return np.sqrt(np.abs(np.linalg.det(keypoints[:, 2:6].reshape(-1, 2, 2))))


def repeated(keypoints: np.ndarray, descriptors: np.ndarray, side: int) -> float:
    """Share of a photo's coarse features that look the same as one elsewhere in it."""
    coarse = size(keypoints) >= _COARSE * side
    keypoints, descriptors = keypoints[coarse], descriptors[coarse]
    if len(keypoints) < _FEWEST_COARSE:
        return 0.0
    mine = sample(len(keypoints))
    alike = descriptors[mine] @ descriptors.T
    apart = np.linalg.norm(keypoints[mine, None, :2] - keypoints[None, :, :2], axis=2) > _ELSEWHERE * side
    return float((np.where(apart, alike, -1).max(1) > np.cos(_TWIN)).mean())


def agreeing(first: np.ndarray, second: np.ndarray) -> int:
    """How many of a sample of the first features have a match among the second, with COLMAP's default limits."""
    if not len(first) or len(second) < 2:
        return 0
    angles = np.arccos(np.clip(first[sample(len(first))] @ second.T, -1, 1))
    nearest, next_one = np.partition(angles, 1, axis=1)[:, :2].T
    return int(((nearest < LARGEST_ANGLE) & (nearest < LARGEST_RATIO * next_one)).sum())
