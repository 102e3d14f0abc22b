"""From the flat map to the page: cut along its sides, in true size, the right way up."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import UsageError
from ..sheet import FlatMap, Sheet
from .page_sides import page_rectangle, turn_to_sides

# Values without a figure are choices; no measurement of them is recorded.
# Sheets whose shape differs by more are not of the named paper, or only a part was found.
_ASPECT_TOLERANCE = 0.02
# Sine of the least angle between two sides that the user draws.
_LEAST_TURN = 0.02


@dataclass(frozen=True)
class PaperSize:
    """The paper's size, as far as the user knows it.

    Attributes
    ----------
    width : float
        Millimetres. If the height is known too, the two may be in either order.
    height : float or None
        Millimetres; None for paper from a roll, whose width is the page's as it is read.
    """

    width: float
    height: float | None = None


def lay_out(
    sheet: Sheet,
    uv: Array,
    reference: Camera,
    up: Array,
    paper: PaperSize | None = None,
    *,
    quarter_turns: int = 0,
) -> FlatMap:
    """Turn, place and scale a flat map to make it a page.

    Parameters
    ----------
    sheet : Sheet
    uv : (V, 2) array
        As from `flatten`.
    reference : Camera
    up : (2,) array
        Direction in the reference photo, in pixels (y down), that points up on the page.
    paper : PaperSize, optional
    quarter_turns : int
        Further clockwise turns by 90 degrees that make the text upright.

    Returns
    -------
    FlatMap
        Cut along straight lines through the sheet's sides; parts of the mesh may be a little outside. A side that is
        torn or cannot be determined is entirely inside the page.
    """
    upright = uv @ turn_to_sides(sheet, uv).T
    quarters = _quarters_to(_photo_direction(sheet, upright, reference, up)) + quarter_turns
    for _ in range(quarters % 4):
        upright = np.stack([-upright[:, 1], upright[:, 0]], axis=1)
    low, high = page_rectangle(sheet, upright)
    extent = high - low
    if paper is None:
        return FlatMap((upright - low) / extent[1], float(extent[0] / extent[1]), 1.0, "page heights", None)
    size = _page_size(extent, paper)
    world_scale = float(np.sqrt(size.prod() / extent.prod()))
    return FlatMap((upright - low) * (size / extent), float(size[0]), float(size[1]), "mm", world_scale)


def other_shape(flat: FlatMap, paper: PaperSize | None) -> tuple[float, float] | None:
    """The longer side by the shorter, as measured and as named, if the page is not of the paper that was named."""
    if paper is None or paper.height is None:
        return None
    measured = max(flat.width, flat.height) / min(flat.width, flat.height)
    named = max(paper.width, paper.height) / min(paper.width, paper.height)
    return (measured, named) if abs(measured / named - 1) > _ASPECT_TOLERANCE else None


def framed(flat: FlatMap, corners: Array) -> FlatMap:
    """The page with other corners: cut to them if they form a rectangle, otherwise straightened into one.

    Parameters
    ----------
    flat : FlatMap
    corners : (4, 2) array
        The new page's corners on the present one, in its unit, clockwise from top left.

    Returns
    -------
    FlatMap
        As wide and high as the new sides are on average. Parts of the sheet may be outside.

    Raises
    ------
    UsageError
        If the corners are not those of a page.
    """
    check_corners(corners)
    length = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    width, height = (length[0] + length[2]) / 2, (length[1] + length[3]) / 2
    target = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    uv = _apply_homography(_homography(corners, target), flat.uv)
    if flat.unit == "mm":
        return replace(flat, uv=uv, width=float(width), height=float(height))
    return replace(flat, uv=uv / height, width=float(width / height))


def check_corners(corners: Array) -> None:
    """Refuse corners (4, 2), clockwise from top left, that are not those of a page.

    Raises
    ------
    UsageError
        If they do not go around it in order, or one is inside the others.
    """
    side = np.roll(corners, -1, axis=0) - corners
    following = np.roll(side, -1, axis=0)
    turn = side[:, 0] * following[:, 1] - side[:, 1] * following[:, 0]
    length = np.linalg.norm(side, axis=1)
    if (turn <= _LEAST_TURN * length * np.roll(length, -1)).any():
        raise UsageError(
            "The page's corners must go around it in order, none of them inside the others: move them back."
        )


def turn_of(sheet: Sheet, flat: FlatMap, reference: Camera) -> int:
    """Degrees clockwise, a multiple of 90, by which the page is turned from how the reference photo shows it."""
    up = _photo_direction(sheet, flat.uv, reference, np.array([0.0, -1.0]))
    return 90 * (-_quarters_to(up) % 4)


def _homography(source: Array, target: Array) -> Array:
    """The projective map (3, 3) that takes four points (4, 2) to four others."""
    rows = []
    for (x, y), (u, v) in zip(source, target, strict=True):
        rows.append([x, y, 1, 0, 0, 0, -u * x, -u * y])
        rows.append([0, 0, 0, x, y, 1, -v * x, -v * y])
    return np.append(np.linalg.solve(np.array(rows), target.ravel()), 1.0).reshape(3, 3)


def _apply_homography(homography: Array, points: Array) -> Array:
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return mapped[:, :2] / mapped[:, 2:]


def _page_size(extent: Array, paper: PaperSize) -> Array:
    """Width and height in mm: exactly the paper's if the shape agrees, otherwise with the paper's area."""
    if paper.height is None:
        return extent * (paper.width / extent[0])
    landscape = extent[0] > extent[1]
    named = np.sort([paper.width, paper.height])[:: -1 if landscape else 1]
    if abs(np.log((named[0] / named[1]) / (extent[0] / extent[1]))) < np.log1p(_ASPECT_TOLERANCE):
        return named
    return extent * np.sqrt(named.prod() / extent.prod())


def _photo_direction(sheet: Sheet, uv: Array, camera: Camera, direction: Array) -> Array:
    """The direction on the page, (2,), of a direction in the photo, by the best-fitting affine map."""
    pixels = camera.project(sheet.vertices)
    design = np.column_stack([pixels, np.ones(len(pixels))])
    affine = np.linalg.lstsq(design, uv, rcond=None)[0]
    return direction @ affine[:2]


def _quarters_to(up: Array) -> int:
    """Clockwise quarter turns after which a direction on the page (v down) points most nearly up."""
    return int(np.round(np.degrees(np.arctan2(-up[0], -up[1])) / 90)) % 4
