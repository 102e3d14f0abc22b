"""The page image from all photos: aligned to each other, in one light, each part from those that show it best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..camera import Camera
from ..page.page_cells import ReadPhoto
from ..page.raster import page_lookup
from ..page.texture import PageTexture
from ..page.warp import native_size
from ..sheet import FlatMap, Sheet
from ..watch import SILENT, Watch
from .agreed_light import agreed_light
from .blending import Layers, blend
from .laid_prints import lay_prints
from .photo_views import view_cells, view_photos
from .photo_weights import photo_weights, quality

# Values without a figure are choices; no measurement of them is recorded.
_MINOR = 0.5  # share of a photo: what it shows is mostly from others


@dataclass(frozen=True)
class Fusion:
    """A page image from all photos.

    Attributes
    ----------
    texture : PageTexture
        In the light that most photos agree on, at the reference photo's exposure.
    burnt_share : float
        Share of the page that is burnt out in every photo that shows it.
    healed_share : float
        Share of the page that the reference photo shows in a light of its own, with a reflection, a shadow or
        something passing, and that comes from other photos.
    """

    texture: PageTexture
    burnt_share: float
    healed_share: float


def fuse_page(
    sheet: Sheet,
    flat: FlatMap,
    cameras: Sequence[Camera],
    read_photo: ReadPhoto,
    reference: int,
    size_px: tuple[int, int],
    threads: int = 1,
    watch: Watch = SILENT,
) -> Fusion:
    """Make the page image from all photos.

    Parameters
    ----------
    sheet : Sheet
    flat : FlatMap
    cameras : sequence of Camera
    read_photo : callable
        As for `single_photo.page_of_photo`; each photo is read twice.
    reference : int
        Index of the photo whose print the others are aligned to, and whose exposure the page has.
    size_px : (width, height)
        Of the page image.
    threads : int
    watch : Watch

    Raises
    ------
    Cancelled
    """
    cells = view_cells(sheet, flat, native_size(sheet, flat, cameras[reference]))
    views = view_photos(sheet, flat, cameras, read_photo, cells, threads, watch.part(0, 0.3))
    light = agreed_light(views, reference)
    laid = lay_prints(views, quality(views, light), reference, threads, watch.part(0.3, 0.5))
    weight = photo_weights(views, light, laid, reference)
    layers = Layers(sheet, page_lookup(sheet, flat, size_px), weight, light.gain, laid.moves)
    texture = blend(layers, cameras, read_photo, threads, watch.part(0.5, 1))
    visible = views.visible
    burnt = visible.any(axis=0) & (views.burnt | ~visible).all(axis=0)
    healed = light.visible[reference] & ~light.well_seen(reference) & (weight[reference] < _MINOR) & ~burnt
    area = max(int(views.page.sum()), 1)
    return Fusion(texture, *(float((where & views.page).sum() / area) for where in (burnt, healed)))
