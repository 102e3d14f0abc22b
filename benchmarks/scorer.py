"""The source of a page's scores against a flat original: the scorer beside the data, otherwise the project's own."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from . import metrics

Figures = dict[str, Any]


@dataclass(frozen=True)
class Scorer:
    """``page(original, page)`` gives the figures of `metrics.score_page` or raises its NoMatch.

    ``origin`` says in words whose figures they are.
    """

    origin: str
    page: Callable[[metrics.Image, metrics.Image], Figures]


def find_scorer(data: Path) -> Scorer:
    """The scorer in ``tools/score`` beside the data folder, or the project's own."""
    score_real = data.resolve().parent / "tools" / "score" / "score_real.py"
    return scorer_of(score_real) if score_real.is_file() else own_scorer()


def own_scorer() -> Scorer:
    return Scorer("the project's own metrics", metrics.score_page)


def scorer_of(score_real: Path) -> Scorer:
    """Another file's scores; what it does not measure is the project's own."""
    other = load(score_real)

    def page(original: metrics.Image, image: metrics.Image) -> Figures:
        own = metrics.score_page(original, image)
        try:
            return own | other.score(original, image)
        except other.NoMatch as why:
            raise metrics.NoMatch(str(why)) from why

    return Scorer(f"{score_real.name} beside the data", page)


def load(path: Path) -> ModuleType:
    """The module in a file."""
    spec = importlib.util.spec_from_file_location(f"origami_scorer_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
