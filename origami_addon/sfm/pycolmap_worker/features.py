"""SIFT features of the photos."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from .database import remove_database
from .messages import EXTRACTED, report
from .photos import name_of, picture_of, read_picture, turn


def extract(folder: Path, database: pycolmap.Database, photos: list[dict[str, Any]], settings: dict[str, Any]) -> None:
    """SIFT of every photo that has none in the database yet; its picture is removed afterwards.

    As many photos at a time as there are threads: each thread needs the memory for one, and finished photos are kept.
    """
    ids = {image.name: image.image_id for image in database.read_all_images()}
    todo = [i for i in range(len(photos)) if not database.exists_keypoints(ids[name_of(i)])]
    done = len(photos) - len(todo)
    for start in range(0, len(todo), settings["threads"]):
        batch = todo[start : start + settings["threads"]]
        for index, (found, descriptors) in zip(batch, features(folder, batch, settings)):
            pixels = read_picture(folder / picture_of(index))
            column, row = found[:, :2].astype(int).T
            colors = pixels[row.clip(0, pixels.shape[0] - 1), column.clip(0, pixels.shape[1] - 1)]
            np.save(folder / f"colors_{name_of(index)}.npy", colors)
            found[:, 0] *= photos[index]["width"] / pixels.shape[1]
            found[:, 1] *= photos[index]["height"] / pixels.shape[0]
            found[:, :2] = turn(found[:, :2], photos[index])
            with pycolmap.DatabaseTransaction(database):
                database.write_keypoints(ids[name_of(index)], found)
                database.write_descriptors(ids[name_of(index)], descriptors)
            (folder / picture_of(index)).unlink()
            done += 1
            report(EXTRACTED * done / len(photos), f"Found {len(found)} features in photo {done} of {len(photos)}")


def features(
    folder: Path, indices: list[int], settings: dict[str, Any]
) -> list[tuple[np.ndarray, pycolmap.FeatureDescriptors]]:
    """Keypoints and descriptors of some photos, in pixels of their pictures.

    pycolmap's own threads do the work: its extractor for a single picture holds Python's lock, so Python's threads
    would wait for each other. They write into a separate database, because its cameras have the pictures' size.
    """
    options = pycolmap.FeatureExtractionOptions()
    options.num_threads = len(indices)
    options.use_gpu = False
    options.max_image_size = settings["max_image_size"]
    options.sift.max_num_features = settings["max_features"]
    path = folder / "features.db"
    remove_database(path)
    pycolmap.extract_features(
        path,
        folder,
        [picture_of(index) for index in indices],
        pycolmap.CameraMode.PER_IMAGE,
        extraction_options=options,
        device=pycolmap.Device.cpu,
    )
    with pycolmap.Database.open(path) as database:
        ids = {image.name: image.image_id for image in database.read_all_images()}
        found = [
            (database.read_keypoints(ids[name]), database.read_descriptors(ids[name]))
            for name in map(picture_of, indices)
        ]
    remove_database(path)
    return found
