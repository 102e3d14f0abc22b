"""A model of COLMAP as arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from .photos import name_of, turn_back

_TURN_BACK = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def placed_arrays(model: pycolmap.Reconstruction, photos: list[dict[str, Any]], colors: Path) -> dict[str, np.ndarray]:
    """The model in the orientation of the photos, with the colours from the folder ``colors``."""
    arrays = model_arrays(model, [name_of(i) for i in range(len(photos))])
    arrays |= turned_back(arrays, photos)
    arrays["colors"] = point_colors(colors, arrays)
    return arrays


def model_arrays(model: pycolmap.Reconstruction, names: list[str]) -> dict[str, np.ndarray]:
    """Cameras and points of a model as arrays; cameras in the order of ``names``, without those not placed."""
    images = {image.name: image for image in model.images.values() if image.has_pose}
    used = [(index, images[name]) for index, name in enumerate(names) if name in images]
    column = {image.image_id: c for c, (_, image) in enumerate(used)}
    poses = np.array([image.cam_from_world().matrix() for _, image in used])
    parameters = np.full((len(used), 12), np.nan)
    for c, (_, image) in enumerate(used):
        parameters[c, : len(image.camera.params)] = image.camera.params
    keys = sorted(model.points3D)
    points = [model.points3D[key] for key in keys]
    tracks = [(p, e.image_id, e.point2D_idx) for p, point in enumerate(points) for e in point.track.elements]
    tracks = [track for track in tracks if track[1] in column]
    seen_at = {image.image_id: np.array([point.xy for point in image.points2D]) for _, image in used}
    return {
        "photo": np.array([index for index, _ in used], int),
        "camera_model": np.array([image.camera.model_name for _, image in used]),
        "camera_size": np.array([(image.camera.width, image.camera.height) for _, image in used], int),
        "camera_parameters": parameters,
        "poses": poses.reshape(-1, 3, 4),
        "points": np.array([point.xyz for point in points]).reshape(-1, 3),
        "colors": np.array([point.color for point in points], np.uint8).reshape(-1, 3),
        "observed_point": np.array([p for p, _, _ in tracks], int),
        "observed_camera": np.array([column[image_id] for _, image_id, _ in tracks], int),
        "observed_pixel": np.array([seen_at[i][k] for _, i, k in tracks]).reshape(-1, 2),
        "observed_feature": np.array([k for _, _, k in tracks], int),
    }


def turned_back(arrays: dict[str, np.ndarray], photos: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Undo ``turn`` for the cameras and observations of turned photos."""
    poses, sizes = arrays["poses"].copy(), arrays["camera_size"].copy()
    pixels, parameters = arrays["observed_pixel"].copy(), arrays["camera_parameters"].copy()
    for c, index in enumerate(arrays["photo"]):
        if photos[index]["turned"]:
            poses[c] = _TURN_BACK @ poses[c]
            sizes[c] = sizes[c, ::-1]
            parameters[c, 1:3] = turn_back(parameters[c : c + 1, 1:3], photos[index])[0]
            mine = arrays["observed_camera"] == c
            pixels[mine] = turn_back(pixels[mine], photos[index])
    return {"poses": poses, "camera_size": sizes, "observed_pixel": pixels, "camera_parameters": parameters}


def point_colors(folder: Path, arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Mean colour of each point's features."""
    total = np.zeros((len(arrays["points"]), 3))
    for c, index in enumerate(arrays["photo"]):
        mine = arrays["observed_camera"] == c
        colors = np.load(folder / f"colors_{name_of(index)}.npy")
        np.add.at(total, arrays["observed_point"][mine], colors[arrays["observed_feature"][mine]])
    views = np.bincount(arrays["observed_point"], minlength=len(total))
    return (total / np.maximum(views, 1)[:, None]).round().astype(np.uint8)
