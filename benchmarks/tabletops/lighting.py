"""A lamp and the light from all around: shadows on planes and on the sheet itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .shapes import Array, Facet

Map = NDArray[np.float32]

# Directions that stand for the lamp's disc, and for the whole sky.
_LAMP_RAYS, _SKY_RAYS = 24, 28
# Millimetres of blur that hides the steps between them, and its share; the rest keeps the edge at a contact sharp.
_SOFTEN, _SOFTENED = 2.0, 0.7
# Millimetres between the places of the sheet at which its light is computed; steps of a ray towards a light.
_SHEET_STEP, _RAY_STEPS = 2.0, 22


@dataclass(frozen=True)
class Light:
    """``lamp`` (3,) points to the lamp; its share of the light on a level place, the rest comes from the sky."""

    lamp: Array
    share: float
    distance: float
    radius: float
    seed: int

    def rays(self) -> tuple[Array, Array]:
        """Directions to the lamp's disc and to the sky, the latter by the cosine law."""
        random = np.random.default_rng(self.seed)
        lamp = self.lamp + self.radius * random.uniform(-1, 1, (_LAMP_RAYS, 3))
        turn, sine = random.uniform(0, 2 * np.pi, _SKY_RAYS), np.sqrt(random.uniform(0, 0.97, _SKY_RAYS))
        sky = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1 - sine**2)], -1)
        return lamp / np.linalg.norm(lamp, axis=1, keepdims=True), sky

    def falloff(self, points: Array) -> Array:
        """How much stronger the lamp is at points (..., 3) than at the scene's middle."""
        return (self.distance / np.linalg.norm(self.lamp * self.distance - points, axis=-1)) ** 2

    def on_face(self, normal: Array) -> float:
        """Light on a face without shadows, 1 on a level one."""
        lamp = max(0.0, float(normal @ self.lamp)) / self.lamp[2]
        return self.share * lamp + (1 - self.share) * (0.5 + 0.5 * float(normal[2]))

    def on_plane(self, casters: Sequence[Array], corner: Array, axes: Array, size: int, scale: float) -> Map:
        """Light on a level plane, (size, size).

        Parameters
        ----------
        casters : sequence of (K, 3) arrays
            Convex polygons that may cast shadows.
        corner : (3,) array
            Where the map's top left corner is.
        axes : (2, 2) array
            Unit vectors of the map's columns and rows in x and y.
        scale : float
            Pixels per millimetre.
        """
        lamp, sky = self._open_share(casters, corner, axes, (size, size), scale)
        steps = (np.arange(0, size, 16) + 0.5) / scale
        x, y = np.meshgrid(steps, steps)
        places = corner + np.pad(x[..., None] * axes[0] + y[..., None] * axes[1], ((0, 0), (0, 0), (0, 1)))
        gradient = cv2.resize(self.falloff(places).astype(np.float32), (size, size))
        return self.share * gradient * lamp + (1 - self.share) * sky

    def _open_share(
        self, casters: Sequence[Array], corner: Array, axes: Array, shape: tuple[int, int], scale: float
    ) -> tuple[Map, Map]:
        """The shares of the lamp and of the sky that places of a level plane see."""
        result = []
        for rays in self.rays():
            hidden = np.zeros(shape, np.float32)
            for ray in rays:
                mask = np.zeros(shape, np.uint8)
                for polygon in casters:
                    above = np.maximum(polygon[:, 2:] - corner[2], 0)
                    ground = polygon[:, :2] - above * ray[:2] / ray[2] - corner[:2]
                    pixels = np.clip(ground @ axes.T * scale * 16, -(2**20), 2**20)
                    cv2.fillConvexPoly(mask, np.round(pixels).astype(np.int32), 1, cv2.LINE_8, 4)
                cv2.accumulate(mask, hidden)
            # So few directions would leave steps in a soft shadow.
            soft = cv2.GaussianBlur(hidden, (0, 0), _SOFTEN * scale) * _SOFTENED + hidden * (1 - _SOFTENED)
            result.append(1 - soft / len(rays))
        return result[0], result[1]

    def on_sheet(
        self, facets: Sequence[Facet], width: float, height: float, others: Sequence[Array], more: Sequence[Facet] = ()
    ) -> tuple[Map, float]:
        """Light on a bent page, and the pixels per millimetre of that map.

        ``others`` are polygons beside the sheet that may shade it, ``more`` facets that belong to its relief.
        """
        shape = (int(np.ceil(height / _SHEET_STEP)) + 1, int(np.ceil(width / _SHEET_STEP)) + 1)
        label = np.zeros(shape, np.int32)
        for index, facet in enumerate(facets):
            cv2.fillConvexPoly(label, np.round(facet.flat / _SHEET_STEP * 16).astype(np.int32), index, cv2.LINE_8, 4)
        flat = np.stack(np.meshgrid(np.arange(shape[1]), np.arange(shape[0])), -1) * _SHEET_STEP
        rotation = np.stack([facet.rotation for facet in facets])[label]
        origin = np.stack([facet.origin for facet in facets])[label]
        place = np.einsum("...ij,...j->...i", rotation[..., :2], flat * [1.0, -1.0]) + origin
        normal = cv2.GaussianBlur(rotation[..., 2].copy(), (0, 0), 1.3, borderType=cv2.BORDER_REPLICATE)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        relief = Relief.of([*facets, *more])
        lamp_rays, sky_rays = self.rays()
        cosine = np.maximum(normal @ self.lamp, 0) / self.lamp[2]
        lamp = np.mean([relief.open(place, ray) for ray in lamp_rays[::2]], axis=0)
        sky_cosine = [np.maximum(normal @ ray, 0) / max(ray[2], 0.15) for ray in sky_rays]
        sky = np.mean([c * relief.open(place, ray) for c, ray in zip(sky_cosine, sky_rays)], axis=0)
        if others:
            corner, scale = np.array([*(place.reshape(-1, 3).min(0)[:2] - 1), 0.0]), 0.5
            size = np.ceil((np.ptp(place.reshape(-1, 3), axis=0)[:2] + 2) * scale).astype(int)
            open_lamp, open_sky = self._open_share(others, corner, np.eye(2), (size[1], size[0]), scale)
            x, y = ((place[..., :2] - corner[:2]) * scale).astype(np.float32).transpose(2, 0, 1)
            lamp = lamp * cv2.remap(open_lamp, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            sky = sky * cv2.remap(open_sky, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        light = self.share * cosine * self.falloff(place) * lamp + (1 - self.share) * sky
        light = cv2.GaussianBlur(light.astype(np.float32), (0, 0), 1.0, borderType=cv2.BORDER_REPLICATE)
        return np.maximum(light, 0.02), 1 / _SHEET_STEP


@dataclass(frozen=True)
class Relief:
    """Heights over a grid in x and y, for shadows of the sheet on itself."""

    height: Map
    corner: Array
    step: float = 2.0

    @classmethod
    def of(cls, facets: Sequence[Facet]) -> Relief:
        corners = np.concatenate([facet.corners for facet in facets])
        low, high = corners.min(0)[:2], corners.max(0)[:2]
        shape = np.ceil((high - low) / cls.step).astype(int) + 2
        height = np.full((shape[1], shape[0]), -1e3, np.float32)
        y, x = np.mgrid[: shape[1], : shape[0]] * cls.step
        for facet in facets:
            pixels = (facet.corners[:, :2] - low) / cls.step
            mask = np.zeros(height.shape, np.uint8)
            cv2.fillConvexPoly(mask, np.round(pixels * 16).astype(np.int32), 1, cv2.LINE_8, 4)
            on, normal = mask.astype(bool), facet.normal
            if abs(normal[2]) < 0.1:
                continue
            offset = np.stack([x[on] + low[0], y[on] + low[1]], -1) - facet.origin[:2]
            height[on] = np.maximum(height[on], facet.origin[2] - offset @ normal[:2] / normal[2])
        return cls(height, low)

    def open(self, places: Array, ray: Array) -> NDArray[np.bool_]:
        """Whether a ray from places (..., 3) meets nothing."""
        free = np.ones(places.shape[:-1], bool)
        for distance in np.geomspace(4, 160, _RAY_STEPS):
            at = places + distance * ray
            pixel = np.round((at[..., :2] - self.corner) / self.step).astype(int)
            inside = ((pixel >= 0) & (pixel < self.height.shape[::-1])).all(-1)
            pixel = np.where(inside[..., None], pixel, 0)
            free &= ~(inside & (self.height[pixel[..., 1], pixel[..., 0]] > at[..., 2] + 0.6 + 0.02 * distance))
        return free
