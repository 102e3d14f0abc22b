"""Where places of a generated scene's page truly lie."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.flat.distortion import apply_affine, fit_similarity
from ...core.numeric.polygon import signed_area
from .cameras import View
from .shapes import Array, Facet

# Places that show the table or another fold do not decide where the page lies: those that are farther off than both so
# many medians and this share of the page's height.
_FAR_MEDIANS, _FAR_HEIGHTS, _FITS = 5.0, 0.01, 3


def unfit(photo: dict[str, Any]) -> tuple[bool, bool, float]:
    """Of the photos in ``truth.json`` the best reference is the one with the least: all of the sheet from above."""
    return photo["cut_off"], photo["hand_on_sheet"], -abs(photo["rotation"][2][2])


def view_of(photo: dict[str, Any]) -> View:
    """The camera of a photo in ``truth.json``."""
    return View(
        *(photo[name] for name in ("width", "height", "focal_length", "k1")),
        np.array(photo["rotation"]),
        np.array(photo["translation"]),
        photo["k2"],
        *(tuple(photo[name]) for name in ("off_middle", "decentering", "row_shift")),
    )


def true_flat(truth: dict[str, Any], photo: dict[str, Any], pixels: Array) -> Array:
    """Flat places (N, 2), mm, of what a photo shows at ``pixels`` (N, 2); NaN where that is not the sheet."""
    view = view_of(photo)
    rays = np.column_stack([view.undistort(pixels), np.ones(len(pixels))]) @ view.rotation
    nearest, flat = np.full(len(pixels), np.inf), np.full((len(pixels), 2), np.nan)
    for described in truth["facets"]:
        facet = Facet(*(np.array(described[name]) for name in ("flat", "rotation", "origin")))
        away = (facet.origin - view.centre) @ facet.normal / (rays @ facet.normal)
        here = (view.centre + away[:, None] * rays - facet.origin) @ facet.rotation[:, :2] * [1, -1]
        turn = np.sign(signed_area(facet.flat))
        side = np.roll(facet.flat, -1, axis=0) - facet.flat
        offset = here[:, None] - facet.flat
        inside = (turn * (side[:, 0] * offset[..., 1] - side[:, 1] * offset[..., 0]) >= -1e-6).all(axis=1)
        taken = inside & (away > 0) & (away < nearest)
        nearest[taken], flat[taken] = away[taken], here[taken]
    return flat


def page_error(uv: Array, true: Array, height: float) -> tuple[Array, float]:
    """Distance (N,) of each place from its own, mm, and millimetres per unit, once the page is laid on the truth."""
    here, there = uv, true
    for _ in range(_FITS):
        laid = fit_similarity(here, there)
        off = np.linalg.norm(apply_affine(laid, here) - there, axis=1)
        near = off < max(_FAR_MEDIANS * np.median(off), _FAR_HEIGHTS * height)
        here, there = here[near], there[near]
    laid = fit_similarity(here, there)
    return np.linalg.norm(apply_affine(laid, uv) - true, axis=1), float(np.hypot(*laid[:, 0]))
