"""What structure from motion is told and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...core.sparse_model import SparseModel


@dataclass(frozen=True)
class SfmSettings:
    """How photos are placed.

    Attributes
    ----------
    max_image_size : int
        Pixels of the long side at which features are found; 2000 needs about 0.9 GB for each thread.
    max_features : int
        In each photo.
    threads : int
        With 1, two runs give the same bits.
    seed : int
    """

    max_image_size: int = 2000
    max_features: int = 8192
    threads: int = 2
    seed: int = 0


@dataclass(frozen=True)
class SfmResult:
    """Where the photos were taken, and how well that is known.

    Attributes
    ----------
    model : SparseModel
        Its points were seen in at least three photos.
    warnings : tuple of str
    figures : dict
        For the report: numbers, and the names of the photos that were left out.
    """

    model: SparseModel
    warnings: tuple[str, ...]
    figures: dict[str, Any]
