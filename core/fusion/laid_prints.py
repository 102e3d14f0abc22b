"""The prints of all photos laid on each other: on the reference's first, and then on those of the sharpest photos."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..numeric.image import shrink
from ..numeric.threads import in_threads
from ..page.page_cells import enlarge
from ..tracks.alignment import FARTHEST, Template, align_prints, shifted, with_those_around
from ..tracks.page_print import CELL, Picture, printed_share
from ..watch import SILENT, Watch
from .confirmed_prints import confirmed_prints
from .photo_views import PhotoViews
from .regions import choose_regions

# Values without a figure are choices; no measurement of each is recorded (`benchmarks/tabletops/heal.py` measures what
# they give together).
_ROUNDS = 2  # of alignment to the photos that are best at each place
_SEAM = 1.0  # cells, standard deviation: from one of them to the next in the picture to which all are aligned
_KNOWN = 0.5  # share of a cell of that picture that photos must show
# Where the reference has this share of the sharpest photo's detail or less, the shifts around count instead, within a
# standard deviation (cells), and with less than a share of trusted cells there none.
_BLURRED, _AROUND, _LEAST_TRUST = 0.3, 6.0, 0.02


@dataclass(frozen=True)
class LaidPrints:
    """The prints of n photos laid on those of the best ones, on a page of (h, w) cells.

    Attributes
    ----------
    moves : list of (h, w, 2) arrays
        What is added to places in each photo, pixels.
    score : (n, h, w) array
        The photos' quality, as far as others confirm what they show.
    agreement : (n, h, w) array
        0 to 1: how well a photo's print lies on that of the photo that is best there.
    printed : (h, w) array
        0 to 1: how much print there is.
    """

    moves: list[Picture]
    score: NDArray[np.float32]
    agreement: NDArray[np.float32]
    printed: Picture


def lay_prints(
    views: PhotoViews, score: NDArray[np.float32], reference: int, threads: int = 1, watch: Watch = SILENT
) -> LaidPrints:
    """Lay the prints of all photos on those of the best ones; ``score`` is by `photo_weights.quality`.

    Raises
    ------
    Cancelled
    """
    prints = views.prints
    shifts = _trusted(views, align_prints(prints, reference, threads, watch.part(0, 0.6)), reference, threads)
    on_reference = list(
        in_threads(lambda index: shifted(prints[index].picture, shifts[index], 1), range(len(prints)), threads)
    )
    score = score * confirmed_prints(np.stack([shrink(each, CELL) for each in on_reference]), views.visible)
    label = choose_regions(score, score > 0)
    total = np.zeros_like(prints[0].picture)
    sum_of_shares = np.zeros_like(total)
    for index, print_ in enumerate(prints):
        share = ndimage.gaussian_filter((label == index).astype(np.float32), _SEAM) * print_.known
        if share.any():
            share = enlarge(share, total.shape)
            total += share * on_reference[index]
            sum_of_shares += share
    best = Template(total / np.maximum(sum_of_shares, 1e-6), shrink(sum_of_shares, CELL) > _KNOWN)
    limit = FARTHEST * max(total.shape)

    def lay(index: int) -> tuple[Picture, Picture]:
        print_ = prints[index]
        if not print_.known.any():
            return shifts[index], np.zeros(print_.known.shape, np.float32)
        shift = best.align(print_.picture, print_.known, shifts[index], limit, _ROUNDS, order=1)
        fit = best.fit(shifted(print_.picture, shift, 1), print_.known)
        return shift, (1 - printed * (1 - fit.trust**2)).astype(np.float32)

    printed = printed_share(best.picture, best.known)
    laid = []
    for each in in_threads(lay, range(len(prints)), threads):
        laid.append(each)
        watch.step(0.6 + 0.4 * len(laid) / len(prints), "Laying the photos on each other")
    shifts, agreement = (list(part) for part in zip(*laid, strict=True))
    moves = [in_photo(print_.position, shift) for print_, shift in zip(prints, shifts, strict=True)]
    return LaidPrints(moves, score, np.stack(agreement), printed)


def _trusted(views: PhotoViews, shifts: list[Picture], reference: int, threads: int) -> list[Picture]:
    """Shifts onto the reference where its print is sharp enough; elsewhere those around, which fade to none."""
    prints = views.prints
    fixed = Template(prints[reference].picture, prints[reference].known)
    detail = views.detail[reference] / np.maximum(views.detail.max(axis=0), 1e-12)
    sharp = np.clip((detail - _BLURRED) / (1 - _BLURRED), 0, 1)

    def trusted(index: int) -> Picture:
        print_, shift = prints[index], shifts[index]
        if index == reference or not print_.known.any():
            return shift
        fit = fixed.fit(shifted(print_.picture, shift, 1), print_.known)
        trust = fit.trust * sharp * print_.known
        return with_those_around(shift, trust, _AROUND, _LEAST_TRUST).astype(np.float32)

    return list(in_threads(trusted, range(len(prints)), threads))


def in_photo(position: NDArray[np.float32], shift: Picture) -> Picture:
    """Shifts (h, w, 2) of page pixels in a photo's pixels, at cells with these positions in it."""
    moved = np.zeros_like(position)
    for axis in (0, 1):
        moved += np.nan_to_num(np.gradient(position, axis=axis)) * shift[..., 1 - axis, None] / CELL
    return moved
