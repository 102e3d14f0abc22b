"""Place photos: features, matches, incremental mapping."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pycolmap

from .database import copy_matches, matches, remove_database, set_typical_focal_length, write_cameras
from .features import extract
from .messages import EXTRACTED, MATCHED, report
from .model_arrays import placed_arrays
from .photos import name_of
from .results import save

# A phone's main camera has 0.7 to 0.9 of the long side, a scanner-like tele lens about 3, the widest phone lens 0.4.
SANE_FOCAL_LENGTHS = (0.4, 3.0)
_GUESSED = "fixed focal length"


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
    best, way = best_model(folder, settings, count, may_guess=True)
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
    best, way = best_model(folder, settings, count, may_guess=False)
    arrays = {} if best is None else placed_arrays(best, photos, folder.parent)
    save(folder, arrays, {"placed": best is not None, "way": way})


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


def best_model(folder: Path, settings: dict[str, Any], count: int, *, may_guess: bool) -> tuple[Any, str]:
    """The model with most photos and the way it was made; None if there is none.

    With ``may_guess``, a typical focal length is the last resort.
    """
    best, way = None, ""
    for name, options in attempts(settings, count):
        if name == _GUESSED:
            if best is not None or not may_guess:
                break
            with pycolmap.Database.open(folder / "database.db") as database:
                set_typical_focal_length(database)
        model = largest(folder, options, count)
        if model is not None and sane(model) and (best is None or model.num_reg_images() > best.num_reg_images()):
            best, way = model, name
        if best is not None and best.num_reg_images() == count:
            break
    return best, way


def attempts(settings: dict[str, Any], count: int) -> Iterator[tuple[str, pycolmap.IncrementalPipelineOptions]]:
    """Ways to try in turn: the usual one, one that accepts smaller baselines, one with a typical focal length."""
    for name in ("usual", "relaxed", _GUESSED):
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
        if name == _GUESSED:
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
