"""Every method on the photo sets: scores of the page on real sets, exact errors on rendered ones."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from . import blender_unwrap, page_error
from .cells import Cells, Placed, failure
from .methods import Method
from .photo_set import PhotoSet
from .scorer import Scorer
from .tables import Row

# Stands in the place of a method where a set fails before any.
WHOLE_SET = "all"


def run_set(
    photo_set: PhotoSet,
    run_folder: Path,
    out: Path,
    methods: Sequence[Method],
    scorer: Scorer,
    say: Callable[[str], None],
    *,
    others: bool,
) -> tuple[list[Row], dict[str, page_error.PageError]]:
    """All rows of one set, and the errors of its pages by method if it is rendered.

    ``run_folder`` is the work folder of the set's ordinary run, whose SfM model is reused. The default must come before
    the methods that share results with it. With ``others``, Blender's unwrapping and page-dewarp follow.
    """
    say(f"{photo_set.name}: placing the photos, finding the sheet")
    try:
        placed = Placed.of(photo_set, run_folder)
    except Exception as why:  # the set fails as a whole
        return [{"set": photo_set.name, "method": WHOLE_SET} | failure(why)], {}
    rows = []
    with tempfile.TemporaryDirectory() as work:
        cells = Cells(photo_set, placed, Path(work), out / "pages" / photo_set.name, scorer)
        for method in methods:
            say(f"{photo_set.name}: {method.name}")
            rows.append(cells.method(method))
        if others:
            for name in blender_unwrap.METHODS:
                say(f"{photo_set.name}: Blender's {name}")
                rows.append(cells.blender(name))
            say(f"{photo_set.name}: page-dewarp")
            rows.append(cells.page_dewarp())
    return rows, cells.errors
