"""The paper's Fig. 9: how errors grow with fewer and noisier points, on synthetic sheets."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from ..core.flat.distortion import fit_affine
from ..core.sheet import Sheet
from ..core.surface.creased_surface import reconstruct_with_creases
from ..core.surface.mesh import build_sheet
from ..origami_addon import steps
from ..origami_addon.report import Report
from ..origami_addon.stages import about
from ..tests import sheets
from .methods import ON_SYNTHETIC_POINTS, Method
from .metrics import HEIGHT, summary
from .tables import Row, Table
from .transforms import displacement

SHEETS = (sheets.two_folds, sheets.cross, sheets.curved_folds)
COUNTS = (2_000, 20_000, 300_000)
NOISE_PERCENT = (0.05, 0.2, 0.5, 1.0)

COLUMNS = {
    "points": ("points", "d"),
    "noise_percent": ("noise % of height", ".2f"),
    "method": ("method", ""),
    "G": ("G", ".4f"),
    "mean": ("mean px", ".2f"),
    "median": ("median px", ".2f"),
    "p95": ("95 % px", ".2f"),
    "failures": ("sheets failed", "d"),
}


def run(counts: Sequence[int], say: Callable[[str], None]) -> tuple[Table, Table]:
    """The table of means over the sheets, and the one with every single result."""
    each = Table("sweep_each", "Synthetic sheets, one by one", {"sheet": ("sheet", "")} | COLUMNS)
    del each.columns["failures"]
    for count in counts:
        for noise in NOISE_PERCENT:
            say(f"sweep: {count} points, {noise} % noise")
            for make in SHEETS:
                with tempfile.TemporaryDirectory() as work:
                    each.rows += _results(make(), count, noise, Path(work))
    means = Table("sweep", "Synthetic sheets: the paper's Fig. 9", COLUMNS, list(_means(each.rows)))
    means.notes = [
        f"Mean over {', '.join(make.__name__ for make in SHEETS)}; points uniform on the whole page with the same "
        "Gaussian noise in every direction, no outliers, the outline exact.",
        "Local displacement after an affine, at 1000 px page height; G as on photos, over the vertical scale squared.",
    ]
    return means, each


def _results(sheet: sheets.SyntheticSheet, count: int, noise_percent: float, work: Path) -> Iterator[Row]:
    random = np.random.default_rng(11)
    flat = random.random((count, 2)) * [sheets.WIDTH, sheets.HEIGHT]
    points = sheet.in_space(flat) + noise_percent / 100 * random.standard_normal((count, 3))
    for method in ON_SYNTHETIC_POINTS:
        row = {"sheet": sheet.name, "points": count, "noise_percent": noise_percent, "method": method.name}
        try:
            with method.in_force():
                yield row | _score(sheet, points, method, work / method.name)
        except Exception as why:  # a method that fails is a result
            yield row | {"failure": f"{type(why).__name__}: {why}"}


def _score(sheet: sheets.SyntheticSheet, points: np.ndarray, method: Method, work: Path) -> Row:
    view = sheets.camera()
    polygon, settings = sheets.outline_pixels(sheet, view), method.settings()
    report = Report({})
    with report.stage(about("surface").reported):
        surface = reconstruct_with_creases(points, view, polygon, settings.surface, seed=settings.sfm.seed)
        recovered = build_sheet(surface, polygon, list(surface.creases))
    with_method = steps.Work([], work, settings, report)
    uv = steps.unwrap_sheet(recovered, with_method)
    seconds = {stage["name"]: stage["seconds"] for stage in report.stages}
    return errors(recovered, uv, sheet) | {"seconds": seconds}


def errors(recovered: Sheet, uv: np.ndarray, sheet: sheets.SyntheticSheet) -> Row:
    """G and local displacement of a recovered flat map, in pixels of a page 1000 px high."""
    view = sheets.camera()
    truth = HEIGHT * sheets.flat_at(sheet, view, view.project(recovered.vertices))
    affine = fit_affine(uv, truth)
    down = np.linalg.norm(np.linalg.inv(affine[:, :2])[:, 1])
    area = float(np.linalg.det(affine[:, :2]) * down**2)
    return {"G": max(area, 1 / area)} | summary(displacement(uv, truth, affine))


def _means(rows: Sequence[Row]) -> Iterator[Row]:
    keys = dict.fromkeys((row["points"], row["noise_percent"], row["method"]) for row in rows)
    for key in keys:
        group = [row for row in rows if (row["points"], row["noise_percent"], row["method"]) == key]
        good = [row for row in group if "failure" not in row]
        figures = {name: float(np.mean([row[name] for row in good])) for name in ("G", "mean", "median", "p95")}
        yield (
            dict(zip(("points", "noise_percent", "method"), key, strict=True))
            | (figures if good else {})
            | {"failures": len(group) - len(good)}
        )
