"""COLMAP's database: cameras, features and matches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from .photos import name_of, turn_back

# Of a phone's main camera, relative to the long side: 0.7 to 0.9.
_TYPICAL_FOCAL_LENGTH = 0.8


def write_cameras(database: pycolmap.Database, photos: list[dict[str, Any]]) -> None:
    """One camera with its rig for each group of photos, one image with its frame for each photo."""
    groups: dict[int, int] = {}
    for index, photo in enumerate(photos):
        if photo["group"] not in groups:
            size = (photo["width"], photo["height"])
            width, height = size[::-1] if photo["turned"] else size
            focal = photo["focal_length"] or _TYPICAL_FOCAL_LENGTH * max(size)
            camera = pycolmap.Camera.create_from_model_name(0, "SIMPLE_RADIAL", focal, width, height)
            camera.has_prior_focal_length = photo["focal_length"] is not None
            camera.camera_id = database.write_camera(camera)
            rig = pycolmap.Rig()
            rig.add_ref_sensor(camera.sensor_id)
            rig.rig_id = database.write_rig(rig)
            groups[photo["group"]] = camera.camera_id
        camera_id = groups[photo["group"]]
        image = pycolmap.Image(name=name_of(index), keypoints=np.zeros((0, 2)), camera_id=camera_id)
        image.image_id = database.write_image(image)
        frame = pycolmap.Frame()
        frame.rig_id = camera_id
        sensor = pycolmap.sensor_t(pycolmap.SensorType.CAMERA, camera_id)
        frame.add_data_id(pycolmap.data_t(sensor, image.image_id))
        database.write_frame(frame)


def set_typical_focal_length(database: pycolmap.Database) -> None:
    for camera in database.read_all_cameras():
        if not camera.has_prior_focal_length:
            camera.focal_length = _TYPICAL_FOCAL_LENGTH * max(camera.width, camera.height)
            database.update_camera(camera)


def copy_matches(source: pycolmap.Database, target: pycolmap.Database) -> None:
    """Features, matches and their geometry, for images of the same names."""
    ids = {image.name: image.image_id for image in target.read_all_images()}
    new = {image.image_id: ids[image.name] for image in source.read_all_images()}
    with pycolmap.DatabaseTransaction(target):
        for old, image_id in new.items():
            target.write_keypoints(image_id, source.read_keypoints(old))
        for pair_id, found in zip(*source.read_all_matches()):
            target.write_matches(*(new[old] for old in pycolmap.pair_id_to_image_pair(pair_id)), found)
        for pair_id, geometry in zip(*source.read_two_view_geometries()):
            target.write_two_view_geometry(*(new[old] for old in pycolmap.pair_id_to_image_pair(pair_id)), geometry)


def matches(database: pycolmap.Database, photos: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Every tentative match, as pixels in both photos, and whether it agrees with the pair's own geometry."""
    image_ids = {image.image_id: int(image.name) for image in database.read_all_images()}
    keypoints = {
        image_id: turn_back(database.read_keypoints(image_id)[:, :2].astype(float), photos[index])
        for image_id, index in image_ids.items()
    }
    verified = dict(zip(*database.read_two_view_geometries()))
    pairs, pixels, inliers = [], [], []
    for pair_id, found in zip(*database.read_all_matches()):
        first, second = pycolmap.pair_id_to_image_pair(pair_id)
        pairs.append(np.tile([image_ids[first], image_ids[second]], (len(found), 1)))
        pixels.append(np.hstack([keypoints[first][found[:, 0]], keypoints[second][found[:, 1]]]))
        agreed = verified[pair_id].inlier_matches[:, 0] if pair_id in verified else np.zeros(0, int)
        inliers.append(np.isin(found[:, 0], agreed))
    return {
        "match_pair": np.concatenate([np.zeros((0, 2), int), *pairs]),
        "match_pixel": np.concatenate([np.zeros((0, 4)), *pixels]),
        "match_verified": np.concatenate([np.zeros(0, bool), *inliers]),
    }


def remove_database(path: Path) -> None:
    """Remove a database and SQLite's files beside it, which a killed worker leaves behind."""
    for part in path.parent.glob(f"{path.name}*"):
        part.unlink()
