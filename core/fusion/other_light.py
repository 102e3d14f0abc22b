"""The page image from other photos of the same sheet, such as ultraviolet ones, pixel by pixel on its page.

Another light changes the print: what is dark in one may be bright in another, and some inks vanish. Its edges stay
where they are, so photos are first aligned by the strength of edges, and then by the print itself in their tones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..camera import Camera
from ..numeric.threads import in_threads
from ..page.page_cells import ReadPhoto, enlarge
from ..page.photo_colors import Photo
from ..page.raster import interpolate, page_lookup
from ..page.texture import PageTexture
from ..sheet import FlatMap, Sheet
from ..tracks.adjustment import resect
from ..tracks.alignment import FARTHEST, Template, half_size, with_those_around
from ..tracks.page_print import CELL, PagePrint, Picture, edges_of, page_print, print_of_page, printed_share
from ..tracks.toned_alignment import TonedFit, TonedTemplate
from ..watch import SILENT, Watch
from .agreed_light import agreed_light
from .blending import Layers, blend
from .laid_prints import LaidPrints, in_photo
from .photo_views import view_cells, view_photos
from .photo_weights import photo_weights, quality

# The values below are choices; what they give together is measured (`docs/page.md`): on a rendered letter two pages lie
# .05 to .2 pixels apart.
# Rounds of alignment at half size and at full size.
_ROUNDS_HALF, _ROUNDS = 6, 2
# A cell is aligned with at least this correlation, and at most this expected deviation, page pixels.
_ALIGNED, _DEVIATION = 0.6, 0.3
# Print counts from the one correlation on, and fully from the other on.
_POOR, _GOOD = 0.5, 0.8
# Cells count as printed from this share of print on. Fewer aligned ones do not say where the camera is.
_HAS_PRINT, _FEWEST_ALIGNED = 0.5, 60
# Where edges say little, the shifts around count, within a standard deviation (cells); with less than a share of
# trusted cells there, none.
_AROUND, _LEAST_TRUST = 6.0, 0.02


@dataclass(frozen=True)
class LaidPhoto:
    """A photo laid on the page.

    Attributes
    ----------
    camera : Camera
        Adjusted to the page.
    aligned_share : float
        The part of the printed cells in view whose edges lie on the page's.
    off : float
        Median distance of these places from where the camera sees them on the sheet, parts of the page's longer side.
    far_off : float
        Its 95th percentile.
    """

    camera: Camera
    aligned_share: float
    off: float
    far_off: float


class PageEdges:
    """A page to which photos in any light are aligned.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    page : (H, W, 3) uint8 or uint16 array
        Its image.
    """

    def __init__(self, sheet: Sheet, flat: FlatMap, page: Photo) -> None:
        self.sheet = sheet
        self.cells = view_cells(sheet, flat, page.shape[0] / flat.height)
        print_ = print_of_page(page, self.cells)
        edges = edges_of(print_)
        self._print = TonedTemplate(print_)
        self._edges, self._coarse = Template(edges.picture, edges.known), Template(*half_size(edges))
        self.printed = printed_share(edges.picture, edges.known)
        self._points = interpolate(self.cells, sheet.triangles, sheet.vertices)

    def lay(self, print_: PagePrint) -> tuple[Picture, TonedFit]:
        """Shifts (h, w, 2) that lay a photo's print on the page's, page pixels, and how well it then fits."""
        edges = edges_of(print_)
        limit = FARTHEST * max(edges.picture.shape)
        moving, known = half_size(edges)
        none = np.zeros((*known.shape, 2), np.float32)
        coarse = self._coarse.align(moving, known, none, limit / 2, _ROUNDS_HALF, order=1)
        shift = 2 * enlarge(coarse, edges.known.shape)
        shift = self._edges.align(edges.picture, edges.known, shift, limit, _ROUNDS, order=1)
        return self._print.align(print_, shift)

    def settle(self, camera: Camera, photo: Photo) -> LaidPhoto | None:
        """Adjust a photo's camera to the page; None if hardly any of its edges lie on the page's."""
        print_ = page_print(self.sheet, self.cells, camera, photo)
        if not print_.known.any():
            return None
        shift, fit = self.lay(print_)
        seen = print_.known & (self.printed > _HAS_PRINT)
        aligned = seen & (fit.correlation > _ALIGNED) & (fit.deviation < _DEVIATION)
        if aligned.sum() < _FEWEST_ALIGNED:
            return None
        row, column = np.nonzero(aligned)
        place = (np.column_stack([column, row]) + 0.5) * CELL
        pixel = print_.photo_pixels(place + shift[aligned])
        points = self._points[aligned]
        camera = resect(camera, points, pixel)
        # photo pixels along one page pixel
        scale = np.sqrt(np.abs(np.linalg.det(np.stack([np.gradient(print_.position, axis=a) for a in (0, 1)], -1))))
        off = np.linalg.norm(camera.project(points) - pixel, axis=1) / (scale[aligned] / CELL)
        off /= max(print_.picture.shape)
        return LaidPhoto(camera, float(aligned.sum() / seen.sum()), *np.percentile(off, [50, 95]).tolist())


def _trust(fit: TonedFit) -> Picture:
    """0 to 1 (h, w): whether the photo's print lies where the page's does."""
    trust = np.clip((fit.correlation - _POOR) / (_GOOD - _POOR), 0, 1)
    return np.asarray(np.where(fit.deviation < _DEVIATION, trust, 0), np.float32)


def fuse_on_page(
    page: PageEdges,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    size_px: tuple[int, int],
    threads: int = 1,
    watch: Watch = SILENT,
) -> PageTexture:
    """Make a page image of other photos, aligned to the page.

    Parameters
    ----------
    page : PageEdges
    flat : FlatMap
    cameras : sequence of Camera
        As `PageEdges.settle` gives them.
    read_photo : callable
        As for `single_photo.page_of_photo`; each photo is read twice.
    size_px : (width, height)
        Of the page image.
    threads : int
    watch : Watch

    Raises
    ------
    Cancelled
    """
    views = view_photos(page.sheet, flat, cameras, read_photo, page.cells, threads, watch.part(0, 0.3))
    reference = int(np.argmax((views.area * views.visible).sum(axis=(1, 2))))
    light = agreed_light(views, reference)
    score = quality(views, light)

    def lay(print_: PagePrint) -> tuple[Picture, Picture]:
        if not print_.known.any():
            return np.zeros((*print_.known.shape, 2), np.float32), np.zeros(print_.known.shape, np.float32)
        shift, fit = page.lay(print_)
        trust = _trust(fit) * print_.known
        shift = with_those_around(shift, trust, _AROUND, _LEAST_TRUST).astype(np.float32)
        return in_photo(print_.position, shift), trust.astype(np.float32)

    laid = []
    for each in in_threads(lay, views.prints, threads):
        laid.append(each)
        watch.step(0.3 + 0.3 * len(laid) / len(cameras), "Laying the photos on the page")
    moves, trust = [move for move, _ in laid], np.stack([each for _, each in laid])
    # where an ink is gone in all of them, none is worse than the others
    relative = trust / np.maximum(trust.max(axis=0), _LEAST_TRUST)
    agreement = (1 - page.printed * (1 - np.maximum(relative, 1 - trust.max(axis=0)) ** 2)).astype(np.float32)
    laid_prints = LaidPrints(moves, score, agreement, page.printed)
    weight = photo_weights(views, light, laid_prints, reference)
    layers = Layers(page.sheet, page_lookup(page.sheet, flat, size_px), weight, light.gain, moves)
    return blend(layers, cameras, read_photo, threads, watch.part(0.6, 1))
