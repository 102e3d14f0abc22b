"""A printed sheet before cameras that look at it from the side: flat, or bent along its height."""

from __future__ import annotations

import numpy as np
from origami.core.camera import Camera
from origami.core.sheet import FlatMap, Sheet
from scipy import ndimage

SIZE = (240, 320)
WIDTH, HEIGHT = 0.75, 1.0


def sheet_from(height_at, rows=60, columns=45):
    u, v = np.meshgrid(np.linspace(0, WIDTH, columns + 1), np.linspace(0, HEIGHT, rows + 1))
    x, z = height_at(u - WIDTH / 2)
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    vertices = np.stack([x, HEIGHT / 2 - v, z], -1).reshape(-1, 3)
    sheet = Sheet(vertices, triangles, (), np.concatenate([index[:-1, 0], index[-1, :-1]]))
    return sheet, FlatMap(np.stack([u, v], -1).reshape(-1, 2), WIDTH, HEIGHT, "page heights", None)


def flat_sheet():
    return sheet_from(lambda x: (x, np.zeros_like(x)))


def view_from(x, distance=2.0, pixels=400):
    """A camera above the sheet, moved by ``x`` and turned to look at the origin."""
    angle = np.arctan2(x, distance)
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[cosine, 0, -sine], [0, -1, 0], [-sine, 0, -cosine]])
    center = np.array([x, 0, distance])
    focal = 1.5 * pixels
    middle = np.array([pixels / 2, pixels / 2])
    return Camera(f"{x}.jpg", pixels, pixels, focal, middle, np.zeros(2), rotation, -rotation @ center)


def photo_of(view, print_at, gain=1.0, blur=0.0, white=255):
    """The printed plane z = 0 as the camera sees it, in 8 bits or 16 by its white."""
    column, row = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    ray = np.concatenate([view.undistort(np.stack([column, row], -1)), np.ones((*column.shape, 1))], -1) @ view.rotation
    hit = view.center - ray * (view.center[2] / ray[..., 2])[..., None]
    grey = gain * print_at(hit[..., 0] + WIDTH / 2, HEIGHT / 2 - hit[..., 1])
    dtype = np.uint8 if white == 255 else np.uint16
    return np.repeat(np.clip(ndimage.gaussian_filter(grey, blur), 0, white).astype(dtype)[..., None], 3, axis=2)


def letters(u, v):
    return np.where((np.sin(u * 190) * np.sin(v * 160) > 0.3) & (np.abs(u - WIDTH / 2) < 0.3), 60.0, 200.0)


def paper(u, v):
    return np.full_like(u, 200.0)
