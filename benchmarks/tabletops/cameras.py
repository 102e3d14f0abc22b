"""Hand-held cameras around a sheet on a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from .shapes import Array, Random

_UNDISTORT_ITERATIONS = 12
_FIT_ITERATIONS = 40
# Pixels between rays that are undistorted exactly; the others are interpolated.
_RAY_STEP = 8


@dataclass(frozen=True)
class View:
    """A pinhole camera with a phone's lens, in COLMAP's conventions.

    ``rotation @ x + translation`` takes millimetres to the camera's frame (x right, y down, z forward); the centre of
    the first pixel is (0.5, 0.5), the principal point ``off_middle`` pixels off the middle of the photo. The lens has
    radial terms ``k1, k2`` and those of decentering, ``p1, p2``. A rolling shutter moves each row by ``row_shift``
    pixels (right, down) for each row that it lies below the principal point.
    """

    width: int
    height: int
    focal_length: float
    k1: float
    rotation: Array
    translation: Array
    k2: float = 0.0
    off_middle: tuple[float, float] = (0.0, 0.0)
    decentering: tuple[float, float] = (0.0, 0.0)
    row_shift: tuple[float, float] = (0.0, 0.0)

    @property
    def centre(self) -> Array:
        return -self.rotation.T @ self.translation

    @property
    def middle(self) -> Array:
        """The principal point."""
        return np.array([self.width, self.height]) / 2 + self.off_middle

    def project(self, points: Array) -> Array:
        """World points (..., 3) to distorted pixels (..., 2)."""
        seen = points @ self.rotation.T + self.translation
        return self.distort(seen[..., :2] / np.maximum(seen[..., 2:], 1.0))

    def distort(self, normalized: Array) -> Array:
        off = (normalized + self._bent(normalized)) * self.focal_length
        return off + off[..., 1:] * np.array(self.row_shift) + self.middle

    def _bent(self, normalized: Array) -> Array:
        """How far the lens moves normalised image coordinates (..., 2)."""
        x, y = normalized[..., :1], normalized[..., 1:]
        r2 = x**2 + y**2
        p1, p2 = self.decentering
        aside = np.concatenate([2 * p1 * x * y + p2 * (r2 + 2 * x**2), p1 * (r2 + 2 * y**2) + 2 * p2 * x * y], -1)
        return np.asarray(normalized * (self.k1 * r2 + self.k2 * r2**2) + aside)

    def undistort(self, pixels: Array) -> Array:
        """Distorted pixels (..., 2) to normalised image coordinates (..., 2)."""
        off = pixels - self.middle
        right, down = self.row_shift
        row = off[..., 1:] / (1 + down)
        distorted = np.concatenate([off[..., :1] - right * row, row], -1) / self.focal_length
        normalized = distorted
        for _ in range(_UNDISTORT_ITERATIONS):
            normalized = distorted - self._bent(normalized)
        return normalized

    def rays(self) -> tuple[Array, Array]:
        """Normalised image coordinates of every pixel, x and y (h, w) float32."""
        step = _RAY_STEP
        across = np.arange(0, self.width + step, step) + 0.5
        down = np.arange(0, self.height + step, step) + 0.5
        coarse = self.undistort(np.stack(np.meshgrid(across, down), -1)).astype(np.float32)
        x, y = np.meshgrid(
            np.arange(self.width, dtype=np.float32) / step, np.arange(self.height, dtype=np.float32) / step
        )
        fine = cv2.remap(coarse, x, y, cv2.INTER_LINEAR)
        return np.ascontiguousarray(fine[..., 0]), np.ascontiguousarray(fine[..., 1])


def _look(azimuth: float, tilt: float, roll: float) -> Array:
    """Rotation of a camera ``tilt`` degrees off the vertical, at ``azimuth`` degrees from the page's bottom."""
    a, t, r = np.radians([azimuth, tilt, roll])
    outward = np.array([np.sin(a) * np.sin(t), -np.cos(a) * np.sin(t), np.cos(t)])
    # The photographer's up is between the forward direction and the page's up.
    up = np.array([-np.sin(0.55 * a + r), np.cos(0.55 * a + r), 0])
    right = np.cross(-outward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(-outward, right), -outward])


def _aim(view: View, border: Array, fill: float, shift: Array) -> View:
    """The camera moved so that the sheet's box fills ``fill`` of the frame, ``shift`` of it off the middle."""
    target, distance = border.mean(0), 600.0
    frame = np.array([view.width, view.height])
    for _ in range(_FIT_ITERATIONS):
        translation = -view.rotation @ target + [0, 0, distance]
        seen = border @ view.rotation.T + translation
        pixels = view.focal_length * seen[:, :2] / np.maximum(seen[:, 2:], 50.0)
        low, high = pixels.min(0), pixels.max(0)
        off = (low + high) / 2 - shift * frame
        target = target + (off * distance / view.focal_length) @ view.rotation[:2] * 0.8
        distance *= (((high - low) / frame).max() / fill) ** 0.7
    return View(view.width, view.height, view.focal_length, view.k1, view.rotation, translation)


def hand_held(random: Random, border: Array, count: int, size: tuple[int, int], cut_off: int) -> list[View]:
    """``count`` views of a sheet with the given edge (K, 3), the last ``cut_off`` of which show only part of it.

    ``size`` is the photo's long and short side in pixels. The photos come in the order in which they were taken.
    """
    long_side = max(size)
    focal_length = random.uniform(0.8, 1.3) * long_side
    k1 = random.choice([0.0, random.uniform(-0.06, 0.04)])
    extent = np.ptp(border[:, :2], axis=0)
    upright = (extent[1] >= extent[0]) == (random.random() < 0.85)
    mixed = random.random() < 0.15
    reach = random.choice([55.0, 75.0, 110.0], p=[0.4, 0.4, 0.2])
    azimuths = random.permutation(np.linspace(-reach, reach, count) + random.uniform(-8, 8, count))
    tilts = random.uniform(10, 45, count)
    tilts[0] = random.uniform(0, 15)
    views = []
    for index in range(count):
        portrait = upright != (mixed and random.random() < 0.4)
        width, height = (min(size), long_side) if portrait else (long_side, min(size))
        rotation = _look(azimuths[index], tilts[index], random.uniform(-8, 8))
        view = View(width, height, focal_length, k1, rotation, np.zeros(3))
        if index < count - cut_off:
            fill = random.uniform(0.62, 0.92)
            shift = random.uniform(-0.5, 0.5, 2) * (0.97 - fill)
        else:
            fill = random.uniform(0.9, 1.25)
            shift = random.uniform(0.12, 0.22) * random.choice([-1, 1], 2) * random.permutation([1.0, random.random()])
        views.append(_aim(view, border, fill, shift))
    order = random.permutation(count)
    return [views[i] for i in order]


def with_phone_lens(views: Sequence[View], random: Random) -> list[View]:
    """The views through the lens of a phone: with a second term, and the principal point off the middle.

    The four phones whose lens was measured have k1 of .02 to .05, k2 of -.08 to -.13, and principal points 5 to 20
    pixels of 2700 off the middle.
    """
    k1, k2 = random.uniform(0.01, 0.06), random.uniform(-0.15, -0.05)
    across, down = random.normal(0, 0.004 * views[0].focal_length, 2)
    # A phone turned on its side turns its sensor too.
    off = {True: (across, down), False: (-down, across)}
    return [replace(view, k1=k1, k2=k2, off_middle=off[view.height > view.width]) for view in views]


def with_unsteady_phone(views: Sequence[View], random: Random) -> list[View]:
    """The views through the lens of a phone as a hand holds it: stabilised, decentered, and read row by row.

    A stabiliser moves the lens, so the principal point wanders by 5 to 20 pixels of 2700 from photo to photo. A hand
    turns by 0.02 to 0.05 radians per second while the rows of a photo are read in 20 to 30 milliseconds.
    """
    views = with_phone_lens(views, random)
    focal_length, longest = views[0].focal_length, max(views[0].width, views[0].height)
    decentering = tuple(random.normal(0, 2e-4, 2))
    result = []
    for view in views:
        wander = random.normal(0, 0.003 * focal_length, 2)
        off = tuple(np.array(view.off_middle) + wander)
        row_shift = tuple(random.normal(0, 0.0009 * focal_length / longest, 2))
        result.append(replace(view, off_middle=off, decentering=decentering, row_shift=row_shift))
    return result


# What takes the views, in addition to a lens with one radial term.
LENSES = {"phone": with_phone_lens, "unsteady phone": with_unsteady_phone}
