"""The source of a page's scores against a flat original: the scorer beside the data, otherwise the project's own."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from . import light, metrics

Figures = dict[str, Any]


@dataclass(frozen=True)
class Scorer:
    """``page(original, page)`` gives the figures of `metrics.score_page` or raises its NoMatch.

    ``light(original, page)`` gives those of `light.score_light`. ``origin`` says in words whose figures they are.
    """

    origin: str
    page: Callable[[metrics.Image, metrics.Image], Figures]
    light: Callable[[metrics.Image, metrics.Image], Figures]


def find_scorer(data: Path) -> Scorer:
    """The scorers in ``tools/score`` beside the data folder, or the project's own."""
    score_real = data.resolve().parent / "tools" / "score" / "score_real.py"
    return scorer_of(score_real) if score_real.is_file() else own_scorer()


def own_scorer() -> Scorer:
    return Scorer("the project's own metrics", metrics.score_page, light.score_light)


def scorer_of(score_real: Path) -> Scorer:
    """The scores of another file, and of score_light.py beside it; what they do not measure is the project's own."""
    score_light = score_real.with_name("score_light.py")
    page = _preferring(score_real, metrics.score_page)
    if not score_light.is_file():
        return Scorer(f"{score_real.name} beside the data", page, light.score_light)
    origin = f"{score_real.name} and {score_light.name} beside the data"
    return Scorer(origin, page, _preferring(score_light, light.score_light))


def _preferring(file: Path, own: Callable[[metrics.Image, metrics.Image], Figures]) -> Callable[..., Figures]:
    """The figures of the function ``score`` in a file; what it does not measure is the project's ``own``."""
    other = load(file)

    def score(original: metrics.Image, image: metrics.Image) -> Figures:
        figures = own(original, image)
        try:
            return figures | other.score(original, image)
        except other.NoMatch as why:
            raise metrics.NoMatch(str(why)) from why

    return score


def load(path: Path) -> ModuleType:
    """The module in a file."""
    spec = importlib.util.spec_from_file_location(f"origami_scorer_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
