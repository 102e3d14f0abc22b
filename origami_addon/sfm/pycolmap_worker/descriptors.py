"""What SIFT descriptors say of each other."""

from __future__ import annotations

import numpy as np

# COLMAP's default limits for a match: the angle between its descriptors, radians, and that as a share of the next one.
LARGEST_ANGLE, LARGEST_RATIO = 0.7, 0.8


def unit_vectors(descriptors: np.ndarray) -> np.ndarray:
    wide = descriptors.astype(np.float32)
    return wide / np.maximum(np.linalg.norm(wide, axis=1, keepdims=True), 1e-6)


def mirrored(descriptors: np.ndarray) -> np.ndarray:
    """The descriptors of the mirrored photo: across each feature's own direction, rows and angles are reversed."""
    bins = descriptors.reshape(-1, 4, 4, 8)
    return bins[:, ::-1][..., (-np.arange(8)) % 8].reshape(-1, 128)


def inverted(descriptors: np.ndarray) -> np.ndarray:
    """The descriptors of the negative: each feature's own direction turns about, and its rows and columns with it."""
    return descriptors.reshape(-1, 4, 4, 8)[:, ::-1, ::-1].reshape(-1, 128)
