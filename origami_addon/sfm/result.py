"""What structure from motion is told and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass, field

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
        Its points were seen in at least three photos (in two, where three-photo points are too few).
    dropped : dict of str to str
        For each photo that could not be placed, its name and why.
    warnings : tuple of str
    figures : dict of str to float
        For the report.
    """

    model: SparseModel
    dropped: dict[str, str]
    warnings: tuple[str, ...]
    figures: dict[str, float] = field(default_factory=dict)
