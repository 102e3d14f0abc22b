"""The settings and the result of structure from motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..setting import setting
from ..sparse_model import SparseModel


@dataclass(frozen=True)
class SfmSettings:
    """How the photos are placed."""

    # With 1600 instead of 2000, photos are placed in .55 of the processor's time and with two thirds of the memory; the
    # pages of sets I and IV are .777 and .569 px off instead of .779 and .574, since their print is followed
    # in the photos at full size afterwards.
    max_image_size: int = setting(
        1600,
        "long side of the photos while they are matched, in pixels; more finds more points and takes more memory "
        "(1600: about 0.6 GB per thread)",
        label="Matching Size",
        option="--match-size N",
        least=400,
        most=20000,
        unit="pixels",
    )
    max_features: int = setting(
        8192,
        "maximum number of features per photo; raise it for faint print",
        label="Features",
        least=100,
        most=100000,
    )
    threads: int = setting(
        2,
        "processor cores to use; with 1, two runs give the same result, bit for bit",
        label="Threads",
        option="--threads N",
        least=1,
        most=1024,
    )
    seed: int = setting(
        0,
        "seed of the random number generator; another seed may place a photo that was missed",
        label="Seed",
        option="--seed N",
        least=0,
        most=2**31 - 1,
    )


@dataclass(frozen=True)
class SfmResult:
    """Where the photos were taken, and how reliable that is.

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
