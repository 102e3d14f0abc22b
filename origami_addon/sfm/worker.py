"""Structure from motion in a separate process: pycolmap can crash or be killed without taking Blender down.

It is started by path: ``python worker.py request.json``. It writes JSON lines to stdout (``{"progress": 0.4, "text":
"..."}``) and a sign of life every few seconds, exits when stdin closes (its parent is gone), and writes ``model.npz``
and then ``result.json``, each atomically, into the folder of the request. It imports numpy and pycolmap, and nothing
from the package.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

SIGN_OF_LIFE_SECONDS = 5
# A phone's main camera has 0.7 to 0.9 of the long side, a scanner-like tele lens about 3, the widest phone lens 0.4.
SANE_FOCAL_LENGTHS = (0.4, 3.0)
TYPICAL_FOCAL_LENGTH = 0.8
EXTRACTED, MATCHED = 0.62, 0.8
# Features of a photo that are compared if it could not be placed.
SAMPLE = 600
# Two features of a photo are twins if their descriptors are within this angle (radians) and they are at least this
# share of the long side apart. Half of the true matches differ by 0.06 to 0.29.
TWIN = 0.25
ELSEWHERE = 0.02
# Smallest size, relative to the long side, of features that are searched for twins: the letters of any text are full of
# smaller ones.
COARSE = 0.005
FEWEST_COARSE = 30
# COLMAP's default limits for a match: the angle between its descriptors, radians, and that as a share of the next one.
LARGEST_ANGLE, LARGEST_RATIO = 0.7, 0.8
# Features that are compared with all of the page at once.
COMPARED = 1024
# Focal lengths to try for a photo on the page, relative to the long side: from one to the next it grows by a quarter.
TRIED_FOCAL_LENGTHS = 0.4 * 1.25 ** np.arange(10)
# How far a match may lie from its place on the sheet, relative to the long side: the surface is off by less than a
# thousandth of the page, and the dense alignment that follows takes up a hundredth.
OFF_THE_SHEET = 0.004
# A pose from fewer matches is a coincidence: 11 of 1500 wrong ones agree with the best of all poses.
FEWEST_ON_SHEET = 20
# The search for a pose ends when one with this share of the matches would have been found.
LEAST_AGREEING = 0.2
# Share of the matches with which a camera is good enough to try no other focal length.
CLEAR = 0.7


def say(message: dict[str, Any]) -> None:
    """Write a line in one piece, because two threads write."""
    os.write(1, (json.dumps(message) + "\n").encode("ascii"))


def report(fraction: float, text: str) -> None:
    say({"progress": round(fraction, 4), "text": text})


def show_life() -> None:
    """Say every few seconds that this process has not been stopped."""

    def repeat() -> None:
        while True:
            time.sleep(SIGN_OF_LIFE_SECONDS)
            say({})

    threading.Thread(target=repeat, daemon=True).start()


def end_with_parent() -> None:
    """Exit when stdin closes: the parent holds the other end and uses it for nothing else."""

    def wait() -> None:
        while os.read(0, 4096):
            pass
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def save(folder: Path, arrays: dict[str, np.ndarray], content: dict[str, Any]) -> None:
    """Write the result: the arrays and, with a hash of both, the content."""
    unfinished = folder / "unfinished.npz"
    np.savez(unfinished, **arrays)
    digest = hashlib.sha256(unfinished.read_bytes() + json.dumps(content, sort_keys=True).encode("ascii"))
    put(unfinished, folder / "model.npz")
    unfinished = folder / "unfinished.json"
    unfinished.write_text(json.dumps({"sha256": digest.hexdigest(), "content": content}, indent=1), encoding="utf-8")
    put(unfinished, folder / "result.json")


def put(unfinished: Path, target: Path) -> None:
    """Rename a file once its content is on the disk, so that it is complete or absent even if the power fails."""
    with unfinished.open("rb+") as file:
        os.fsync(file.fileno())
    os.replace(unfinished, target)


def limit_memory(most: int) -> None:
    """Let the system refuse more memory than this; Windows and macOS cannot."""
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def name_of(index: int) -> str:
    return f"{index:04d}"


def turn(pixels: np.ndarray, photo: dict[str, Any]) -> np.ndarray:
    """Pixels of a photo as they would be in its group's orientation: a quarter turn to the left, or unchanged."""
    return np.stack([pixels[:, 1], photo["width"] - pixels[:, 0]], 1) if photo["turned"] else pixels


def turn_back(pixels: np.ndarray, photo: dict[str, Any]) -> np.ndarray:
    return np.stack([photo["width"] - pixels[:, 1], pixels[:, 0]], 1) if photo["turned"] else pixels


TURN_BACK = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def write_cameras(database: pycolmap.Database, photos: list[dict[str, Any]]) -> None:
    """One camera with its rig for each group of photos, one image with its frame for each photo."""
    groups: dict[int, int] = {}
    for index, photo in enumerate(photos):
        if photo["group"] not in groups:
            size = (photo["width"], photo["height"])
            width, height = size[::-1] if photo["turned"] else size
            focal = photo["focal_length"] or TYPICAL_FOCAL_LENGTH * max(size)
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


def remove_database(path: Path) -> None:
    """Remove a database and SQLite's files beside it, which a killed worker leaves behind."""
    for part in path.parent.glob(f"{path.name}*"):
        part.unlink()


def picture_of(index: int) -> str:
    return f"{name_of(index)}.ppm"


def read_picture(path: Path) -> np.ndarray:
    """The pixels (h, w, 3) of a PPM from the client: three lines of text, then the bytes."""
    with path.open("rb") as file:
        _, size, _ = (file.readline() for _ in range(3))
        width, height = map(int, size.split())
        return np.fromfile(file, np.uint8).reshape(height, width, 3)


def match(folder: Path, count: int, settings: dict[str, Any]) -> None:
    """Match each photo with all before it, except pairs that are in the database already."""
    options = pycolmap.FeatureMatchingOptions()
    options.num_threads = settings["threads"]
    options.use_gpu = False
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = settings["seed"]
    # Without a known focal length, and with a sheet on a printed desk, a pair counts as planar at the default of 0.8,
    # and all matches off the desk's plane, which are on the raised parts of the sheet, are dropped.
    verification.max_H_inlier_ratio = 1.0
    pairing = pycolmap.ImportedPairingOptions()
    pairing.match_list_path = folder / "pairs.txt"
    for second in range(1, count):
        pairs = "".join(f"{name_of(first)} {name_of(second)}\n" for first in range(second))
        (folder / "pairs.txt").write_text(pairs, encoding="utf-8")
        pycolmap.match_image_pairs(folder / "database.db", options, pairing, verification, pycolmap.Device.cpu)
        done = (second + 1) * second / (count * (count - 1))
        report(EXTRACTED + (MATCHED - EXTRACTED) * done, f"Matched {second + 1} of {count} photos")


def attempts(settings: dict[str, Any], count: int) -> Iterator[tuple[str, pycolmap.IncrementalPipelineOptions]]:
    """Ways to try in turn: the usual one, one that accepts smaller baselines, one with a typical focal length."""
    for name in ("usual", "relaxed", "fixed focal length"):
        options = pycolmap.IncrementalPipelineOptions()
        options.num_threads = settings["threads"]
        options.random_seed = settings["seed"]
        options.extract_colors = False
        options.min_model_size = 3
        options.max_num_models = 5
        options.min_focal_length_ratio, options.max_focal_length_ratio = SANE_FOCAL_LENGTHS
        options.triangulation.ignore_two_view_tracks = count > 4
        if name != "usual":
            options.mapper.init_min_num_inliers = 50
            options.mapper.init_min_tri_angle = 6.0
            options.mapper.init_max_forward_motion = 0.98
            options.mapper.abs_pose_min_num_inliers = 20
            options.mapper.abs_pose_min_inlier_ratio = 0.12
            options.mapper.filter_min_tri_angle = options.triangulation.min_angle = 1.0
        if name == "fixed focal length":
            options.ba_refine_focal_length = False
            options.mapper.abs_pose_refine_focal_length = False
        yield name, options


def largest(folder: Path, options: pycolmap.IncrementalPipelineOptions, count: int) -> Any:
    """Map incrementally; returns the model with most photos (then points), None if there is none."""
    placed = 2

    def next_image() -> None:
        nonlocal placed
        placed += 1
        done = min(placed, count)
        report(MATCHED + (1 - MATCHED) * done / (count + 1), f"Placed {done} of {count} photos")

    models = pycolmap.incremental_mapping(
        folder / "database.db", folder, folder, options, next_image_callback=next_image
    ).values()
    return max(models, key=lambda model: (model.num_reg_images(), model.num_points3D()), default=None)


def focal_lengths(model: pycolmap.Reconstruction) -> dict[int, float]:
    return {key: camera.focal_length / max(camera.width, camera.height) for key, camera in model.cameras.items()}


def sane(model: pycolmap.Reconstruction) -> bool:
    low, high = SANE_FOCAL_LENGTHS
    return all(low < ratio < high for ratio in focal_lengths(model).values())


def set_typical_focal_length(database: pycolmap.Database) -> None:
    for camera in database.read_all_cameras():
        if not camera.has_prior_focal_length:
            camera.focal_length = TYPICAL_FOCAL_LENGTH * max(camera.width, camera.height)
            database.update_camera(camera)


def place(request: dict[str, Any], folder: Path) -> None:
    photos, settings = request["photos"], request["settings"]
    count = len(photos)
    pycolmap.set_random_seed(settings["seed"])
    with pycolmap.Database.open(folder / "database.db") as database:
        if database.num_images() < count:
            database.clear_all_tables()
            write_cameras(database, photos)
        extract(folder, database, photos, settings)
    match(folder, count, settings)

    best, way = None, ""
    for name, options in attempts(settings, count):
        if name == "fixed focal length":
            if best is not None:
                break
            with pycolmap.Database.open(folder / "database.db") as database:
                set_typical_focal_length(database)
        model = largest(folder, options, count)
        if model is not None and sane(model) and (best is None or model.num_reg_images() > best.num_reg_images()):
            best, way = model, name
        if best is not None and best.num_reg_images() == count:
            break
    with pycolmap.Database.open(folder / "database.db") as database:
        arrays = matches(database, photos)
    if best is not None:
        arrays |= placed_arrays(best, photos, folder)
    save(folder, arrays, {"placed": best is not None, "way": way})


def place_with_own_lenses(request: dict[str, Any], folder: Path) -> None:
    """Place the photos again, each with its own camera, from the matches that ``place`` left one folder above."""
    photos, settings = request["photos"], request["settings"]
    count = len(photos)
    pycolmap.set_random_seed(settings["seed"])
    remove_database(folder / "database.db")
    with (
        pycolmap.Database.open(folder.parent / "database.db") as shared,
        pycolmap.Database.open(folder / "database.db") as own,
    ):
        write_cameras(own, [photo | {"group": index} for index, photo in enumerate(photos)])
        for camera in own.read_all_cameras():
            # EXIF only gives a start value: it may lack a zoom done in software.
            camera.has_prior_focal_length = False
            own.update_camera(camera)
        copy_matches(shared, own)
    best, way = None, ""
    for name, options in attempts(settings, count):
        if not options.ba_refine_focal_length:
            break
        model = largest(folder, options, count)
        if model is not None and sane(model) and (best is None or model.num_reg_images() > best.num_reg_images()):
            best, way = model, name
        if best is not None and best.num_reg_images() == count:
            break
    arrays = {} if best is None else placed_arrays(best, photos, folder.parent)
    save(folder, arrays, {"placed": best is not None, "way": way})


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


def placed_arrays(model: pycolmap.Reconstruction, photos: list[dict[str, Any]], colors: Path) -> dict[str, np.ndarray]:
    """The model in the orientation of the photos, with the colours from the folder ``colors``."""
    arrays = model_arrays(model, [name_of(i) for i in range(len(photos))])
    arrays |= turned_back(arrays, photos)
    arrays["colors"] = point_colors(colors, arrays)
    return arrays


def look_closer(request: dict[str, Any], folder: Path) -> None:
    """What the features alone show of photos that could not be placed; the database is one folder above.

    For each photo: the number of features, the size of its finest ones, and the share of the coarse ones that have a
    twin elsewhere in the same photo. For each requested pair: how many features agree if one photo is mirrored, and how
    many agree as they are.
    """
    photos = request["photos"]
    with pycolmap.Database.open(folder.parent / "database.db") as database:
        ids = {image.name: image.image_id for image in database.read_all_images()}
        keypoints = [database.read_keypoints(ids[name_of(i)]) for i in range(len(photos))]
        descriptors = [unit_vectors(database.read_descriptors(ids[name_of(i)]).data) for i in range(len(photos))]
    sides = [max(photo["width"], photo["height"]) for photo in photos]
    figures = {
        "features": [len(found) for found in keypoints],
        "finest_pixels": [float(np.percentile(size(found), 10)) if len(found) else 0.0 for found in keypoints],
        "repeated": [repeated(*found) for found in zip(keypoints, descriptors, sides)],
        "mirrored": [
            [i, j, agreeing(mirrored(descriptors[i]), descriptors[j]), agreeing(descriptors[i], descriptors[j])]
            for i, j in request["pairs"]
        ],
    }
    save(folder, {}, figures)


def unit_vectors(descriptors: np.ndarray) -> np.ndarray:
    wide = descriptors.astype(np.float32)
    return wide / np.maximum(np.linalg.norm(wide, axis=1, keepdims=True), 1e-6)


def sample(count: int) -> np.ndarray:
    """At most ``SAMPLE`` indices below ``count``, spread evenly."""
    return np.unique(np.linspace(0, max(count - 1, 0), SAMPLE).astype(int)) if count else np.zeros(0, int)


def size(keypoints: np.ndarray) -> np.ndarray:
    """The size of each feature, in pixels of the photo."""
    return np.sqrt(np.abs(np.linalg.det(keypoints[:, 2:6].reshape(-1, 2, 2))))


def repeated(keypoints: np.ndarray, descriptors: np.ndarray, side: int) -> float:
    """Share of a photo's coarse features that look the same as one elsewhere in it."""
    coarse = size(keypoints) >= COARSE * side
    keypoints, descriptors = keypoints[coarse], descriptors[coarse]
    if len(keypoints) < FEWEST_COARSE:
        return 0.0
    mine = sample(len(keypoints))
    alike = descriptors[mine] @ descriptors.T
    apart = np.linalg.norm(keypoints[mine, None, :2] - keypoints[None, :, :2], axis=2) > ELSEWHERE * side
    return float((np.where(apart, alike, -1).max(1) > np.cos(TWIN)).mean())


def mirrored(descriptors: np.ndarray) -> np.ndarray:
    """The descriptors of the mirrored photo: across each feature's own direction, rows and angles are reversed."""
    bins = descriptors.reshape(-1, 4, 4, 8)
    return bins[:, ::-1][..., (-np.arange(8)) % 8].reshape(-1, 128)


def agreeing(first: np.ndarray, second: np.ndarray) -> int:
    """How many of a sample of the first features have a match among the second, with COLMAP's default limits."""
    if not len(first) or len(second) < 2:
        return 0
    angles = np.arccos(np.clip(first[sample(len(first))] @ second.T, -1, 1))
    nearest, next_one = np.partition(angles, 1, axis=1)[:, :2].T
    return int(((nearest < LARGEST_ANGLE) & (nearest < LARGEST_RATIO * next_one)).sum())


def place_on_page(request: dict[str, Any], folder: Path) -> None:
    """Place photos, of any light, over a sheet whose page is known: each on its own, from its matches with the page.

    Picture 0 is the page and ``page_points.npy`` (h, w, 3) has the world point under each of its pixels; the photos
    follow. Print that is bright in one light may be dark in another, so features match as they are or inverted.
    """
    photos, settings = request["photos"], request["settings"]
    points = np.load(folder / "page_points.npy")
    (found, descriptors), *_ = features(folder, [0], settings)
    column, row = found[:, :2].astype(int).T
    on_page = points[row.clip(0, points.shape[0] - 1), column.clip(0, points.shape[1] - 1)].astype(float)
    on_sheet = np.isfinite(on_page[:, 0])
    on_page, of_page = on_page[on_sheet], unit_vectors(descriptors.data[on_sheet])
    names = "poses", "lens", "photo", "world", "pixel", "inlier", "contrary"
    placed: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for index, photo in enumerate(photos):
        ((found, descriptors),) = features(folder, [index + 1], settings)
        height, width = read_picture(folder / picture_of(index + 1)).shape[:2]
        pixel = found[:, :2].astype(float) * [photo["width"] / width, photo["height"] / height]
        mine, its = matched(unit_vectors(descriptors.data), of_page)
        focal_lengths = [*photo["focal_lengths"], *(TRIED_FOCAL_LENGTHS * max(photo["width"], photo["height"]))]
        pose, lens, inlier = resected(pixel[mine], on_page[its], photo, focal_lengths, settings["seed"])
        rest = mine[~inlier], its[~inlier]
        # one camera took both, so a second pose has the focal length of the first
        focal_lengths = lens[:1].tolist() if np.isfinite(lens[0]) else []
        contrary = resected(pixel[rest[0]], on_page[rest[1]], photo, focal_lengths, settings["seed"])[2].sum()
        for name, value in {
            "poses": pose[None],
            "lens": lens[None],
            "photo": np.full(len(mine), index),
            "world": on_page[its],
            "pixel": pixel[mine],
            "inlier": inlier,
            "contrary": np.array([contrary]),
        }.items():
            placed[name].append(value)
        report((index + 1) / len(photos), f"Placed photo {index + 1} of {len(photos)} on the page")
    save(folder, {name: np.concatenate(values) for name, values in placed.items()}, {})


def inverted(descriptors: np.ndarray) -> np.ndarray:
    """The descriptors of the negative: each feature's own direction turns about, and its rows and columns with it."""
    return descriptors.reshape(-1, 4, 4, 8)[:, ::-1, ::-1].reshape(-1, 128)


def matched(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Features that are each other's nearest, as they are or one of them inverted: indices (N,) of both."""
    if not len(first) or len(second) < 2:
        return np.zeros(0, int), np.zeros(0, int)
    nearest, good = np.zeros(len(first), int), np.zeros(len(first), bool)
    best_of_second, nearest_of_second = np.full(len(second), -1.0), np.zeros(len(second), int)
    for begin in range(0, len(first), COMPARED):
        part = first[begin : begin + COMPARED]
        alike = np.maximum(part @ second.T, inverted(part) @ second.T)
        nearest[begin : begin + len(part)] = alike.argmax(1)
        next_one, best = np.arccos(np.clip(np.partition(alike, -2, axis=1)[:, -2:], -1, 1)).T
        good[begin : begin + len(part)] = (best < LARGEST_ANGLE) & (best < LARGEST_RATIO * next_one)
        better = alike.max(0) > best_of_second
        nearest_of_second[better] = begin + alike.argmax(0)[better]
        best_of_second[better] = alike.max(0)[better]
    mine = np.flatnonzero(good & (nearest_of_second[nearest] == np.arange(len(first))))
    return mine, nearest[mine]


def resected(
    pixel: np.ndarray, world: np.ndarray, photo: dict[str, Any], focal_lengths: Iterable[float], seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pose (3, 4), lens (4,) of a SIMPLE_RADIAL camera, and which matches (N,) agree; NaN if too few do.

    The focal lengths are tried in turn.
    """
    options, refinement = pycolmap.AbsolutePoseEstimationOptions(), pycolmap.AbsolutePoseRefinementOptions()
    options.ransac.max_error = OFF_THE_SHEET * max(photo["width"], photo["height"])
    options.ransac.min_inlier_ratio = LEAST_AGREEING
    options.ransac.random_seed = seed
    refinement.refine_focal_length = refinement.refine_extra_params = True
    best = np.full((3, 4), np.nan), np.full(4, np.nan), np.zeros(len(pixel), bool)
    for focal in focal_lengths:
        camera = pycolmap.Camera.create_from_model_name(0, "SIMPLE_RADIAL", focal, photo["width"], photo["height"])
        if len(pixel) < FEWEST_ON_SHEET:
            break
        found = pycolmap.estimate_and_refine_absolute_pose(pixel, world, camera, options, refinement)
        if found is not None and found["num_inliers"] > max(best[2].sum(), FEWEST_ON_SHEET - 1):
            best = found["cam_from_world"].matrix(), np.array(camera.params), np.asarray(found["inlier_mask"], bool)
        if best[2].sum() > CLEAR * len(pixel):
            break
    return best


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
            poses[c] = TURN_BACK @ poses[c]
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


def names_in_text(folder: Path) -> dict[int, str]:
    """The names of a text model's images by their numbers; COLMAP itself reads them only up to the first space."""
    if (folder / "images.bin").exists():  # COLMAP prefers it
        return {}
    names = {}
    with (folder / "images.txt").open(encoding="utf-8") as lines:
        for line in lines:
            if line.strip() and not line.startswith("#"):
                number, *_, name = line.strip().split(maxsplit=9)
                names[int(number)] = name
                next(lines, None)  # the image's points
    return names


def load(request: dict[str, Any], folder: Path) -> None:
    """Read a COLMAP model, binary or text; its cameras are passed on unchanged."""
    limit_memory(request["most_memory"])
    try:
        model = pycolmap.Reconstruction(request["model"])
        for number, name in names_in_text(Path(request["model"])).items():
            model.images[number].name = name
    except Exception:  # whatever a damaged model raises
        return save(folder, {}, {"placed": False, "names": []})
    names = sorted(image.name for image in model.images.values() if image.has_pose)
    save(folder, model_arrays(model, names), {"placed": True, "names": names})


def main(path: Path) -> None:
    end_with_parent()
    show_life()
    request = json.loads(path.read_text(encoding="utf-8"))
    what = {
        "place": place,
        "own_lenses": place_with_own_lenses,
        "look_closer": look_closer,
        "place_on_page": place_on_page,
        "load": load,
    }
    what[request["do"]](request, path.parent)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
