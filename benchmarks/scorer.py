"""The source of the scores: the scorer beside the data, otherwise the project's own metrics."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from . import metrics, truth

Figures = dict[str, Any]

# The figures of the scorer's mesh evaluation by their names here.
_SHEET_FIGURES = {
    "surface_rms": "recon_rms_pct",
    "surface_median": "recon_median_pct",
    "surface_p95": "recon_p95_pct",
    "flat_mean": "flat_mean_pct",
    "flat_median": "flat_median_pct",
    "flat_p95": "flat_p95_pct",
    "affine_mean": "flat_aff_mean_pct",
    "outside": "outside_fraction",
    "coverage": "coverage",
}


class CannotScore(Exception):
    """Why a result cannot be measured, as one sentence."""


@dataclass(frozen=True)
class Scorer:
    """``page(original, page)`` and ``sheet(scene, vertices, uv, names, centres)``, as in `metrics` and `truth`.

    Both raise CannotScore. ``origin`` says in words which scorer this is.
    """

    origin: str
    page: Callable[[metrics.Image, metrics.Image], Figures]
    sheet: Callable[[Path, truth.Array, truth.Array, Sequence[str], truth.Array], Figures]


def find_scorer(data: Path) -> Scorer:
    """The scorer in ``tools/score`` beside the data folder, or the project's own."""
    folder = data.resolve().parent / "tools" / "score"
    if (folder / "score_real.py").is_file() and (folder / "evaluate.py").is_file():
        return scorer_in(folder)
    return own_scorer()


def own_scorer() -> Scorer:
    def page(original: metrics.Image, image: metrics.Image) -> Figures:
        try:
            return metrics.score_page(original, image)
        except metrics.NoMatch as why:
            raise CannotScore(str(why)) from why

    def sheet(
        scene: Path, vertices: truth.Array, uv: truth.Array, names: Sequence[str], centres: truth.Array
    ) -> Figures:
        try:
            return dict(truth.score_sheet(scene, vertices, uv, names, centres))
        except ValueError as why:
            raise CannotScore(str(why)) from why

    return Scorer("the project's own metrics", page, sheet)


def scorer_in(folder: Path) -> Scorer:
    score_real, evaluate = (_load(folder / f"{name}.py") for name in ("score_real", "evaluate"))

    def page(original: metrics.Image, image: metrics.Image) -> Figures:
        try:
            return score_real.score(original, image)
        except score_real.NoMatch as why:
            raise CannotScore(str(why)) from why

    def sheet(
        scene: Path, vertices: truth.Array, uv: truth.Array, names: Sequence[str], centres: truth.Array
    ) -> Figures:
        figures = evaluate.eval_mesh(str(scene), vertices, uv, (list(names), np.asarray(centres)))
        if not figures["ok"]:
            raise CannotScore("; ".join(figures["why"]))
        # The scorer does not measure the mesh's aspect.
        aspect = truth.score_sheet(scene, vertices, uv, names, centres)["aspect_percent"]
        return {ours: figures[theirs] for ours, theirs in _SHEET_FIGURES.items()} | {"aspect_percent": aspect}

    return Scorer("score_real.py and evaluate.py beside the data", page, sheet)


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"origami_scorer_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
