"""What structure from motion is told and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...core.setting import setting
from ...core.sparse_model import SparseModel


@dataclass(frozen=True)
class SfmSettings:
    """How photos are placed."""

    max_image_size: int = setting(
        2000,
        "pixels of the photos' long side at which they are matched; more finds more and takes more memory (2000: about "
        "0.9 GB for each thread)",
        label="Matching Size",
        option="--match-size N",
        least=400,
        most=20000,
        unit="pixels",
    )
    max_features: int = setting(
        8192,
        "most features taken from each photo; more for faint print",
        label="Features",
        least=100,
        most=100000,
    )
    threads: int = setting(
        2,
        "processor cores to use; with 1, two runs give the same bits",
        label="Threads",
        option="--threads N",
        least=1,
        most=1024,
    )
    seed: int = setting(
        0,
        "of all random choices; another one may place a photo that is missed",
        label="Seed",
        option="--seed N",
        least=0,
        most=2**31 - 1,
    )


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
