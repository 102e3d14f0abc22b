"""Fit the probability that an outline is right, in `core/paper/outline_judgement.py`, on generated scenes.

    .venv/bin/python benchmarks/tabletops/run.py -o out/tuning --seeds 1000-1059 --threads 1 --image-size 1200
    .venv/bin/python benchmarks/tabletops/fit_judgement.py out/tuning

The first command places the photos. In the two best reference photos of each scene the edge is followed from the sheet
that was found and from its rivals; a logistic regression says how probably each outline is right, from its signs. It
prints what is taken in scenes left out of the fit, and the weights.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from run import load_checkout  # noqa: E402

_PHOTOS = 2  # of each scene
_RIDGE = 0.3  # cost of the squares of the weights of standardised signs
_FOLDS = 5

# Signs (K, F) of the outlines in one photo, and whether each is right (K,); the first was followed from the sheet.
Photo = tuple[np.ndarray, np.ndarray]


def main(arguments: argparse.Namespace) -> int:
    """Follow, fit, print."""
    load_checkout()
    judgement = importlib.import_module("origami.core.paper.outline_judgement")
    folders = sorted((arguments.tuning / "scenes").glob("[0-9]*"))
    scenes = [photos for folder in folders if (photos := followed(folder, arguments.tuning / "work" / folder.name))]
    print(f"{len(scenes)} of {len(folders)} scenes could be placed", file=sys.stderr)
    taken = []
    for fold in range(_FOLDS):
        weights = fit([scene for index, scene in enumerate(scenes) if index % _FOLDS != fold])
        for signs, right in (photo for scene in scenes[fold::_FOLDS] for photo in scene):
            odds = weights[0] + signs @ weights[1:]
            best = int(odds.argmax()) if odds.max() > odds[0] + judgement._CLEARLY else 0
            taken.append((bool(right[best]), bool(right[0]), float(expit(odds[best]))))
    sure = [probability >= judgement._SURE for _, _, probability in taken]
    print(f"in scenes left out, of {len(taken)} photos:")
    print(f"  the outline from the sheet itself is right in {sum(own for _, own, _ in taken)}")
    print(f"  the one that is taken is right in {sum(right for right, _, _ in taken)}")
    wrong_and_sure = sum(is_sure and not right for (right, _, _), is_sure in zip(taken, sure, strict=True))
    right_and_not = sum(right and not is_sure for (right, _, _), is_sure in zip(taken, sure, strict=True))
    print(f"  wrong but sure: {wrong_and_sure}; right but not sure: {right_and_not}")
    names = ["constant", *judgement.Signs.__annotations__]
    print(", ".join(f"{name} {weight:.1f}" for name, weight in zip(names, fit(scenes), strict=True)))
    return 0


def followed(folder: Path, work: Path) -> list[Photo]:
    """The outlines in the two best photos of a scene; none where its photos cannot be placed or nothing is found."""
    steps = importlib.import_module("origami.origami_addon.steps")
    measure = importlib.import_module("origami.benchmarks.tabletops.measure")
    outline = importlib.import_module("origami.core.paper.outline")
    reduced_photo = importlib.import_module("origami.core.paper.followed_edge").ReducedPhoto
    reduced_photos = importlib.import_module("origami.origami_addon.files.photo_pixels").ReducedPhotos
    image = importlib.import_module("origami.core.numeric.image")
    rank = importlib.import_module("origami.core.paper.reference_view").rank_references
    scene = importlib.import_module("origami.benchmarks.tabletops.placed").placed_scene(folder, work)
    if scene is None:
        return []
    try:
        sheet = steps.sheets_in_view(scene.model, scene.work)[0]
    except importlib.import_module("origami.core.errors").OrigamiError:
        return []
    result = []
    for index in rank(scene.model, reduced_photos(scene.pixels), sheet.outline, sheet.points)[:_PHOTOS]:
        camera, true = scene.model.cameras[index], scene.outlines[index]
        edges, signs = outline.follow_all(reduced_photo(image.linear_light(scene.pixels[index])), camera, sheet)
        size = camera.width, camera.height
        right = [measure.overlap(edge.points, true, size) >= measure.RIGHT for edge in edges]
        result.append((np.array([list(each.figures().values()) for each in signs]), np.array(right)))
    return result


def fit(scenes: list[list[Photo]]) -> np.ndarray:
    """Constant and weights (1 + F,) of greatest likelihood."""
    signs, right = (
        np.concatenate(parts) for parts in zip(*(photo for scene in scenes for photo in scene), strict=True)
    )
    spread = signs.std(axis=0) + 1e-6

    def cost(weights: np.ndarray) -> float:
        odds = weights[0] + signs / spread @ weights[1:]
        return float((np.logaddexp(0, odds) - right * odds).sum() + _RIDGE * (weights[1:] ** 2).sum())

    found = minimize(cost, np.zeros(1 + signs.shape[1])).x
    return np.concatenate([found[:1], found[1:] / spread])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tuning", type=Path, metavar="DIR", help="where run.py wrote the tuning scenes")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main(parser.parse_args()))
