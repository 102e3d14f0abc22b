"""The whole benchmark: what is measured, and how the results are written."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path

from ..origami_addon.report import versions
from . import paper, photo_sets, plots, sweep, whole_runs
from .methods import DEFAULT, ON_PHOTOS, PAPER, PAPER_WITHOUT_ROWS
from .scorer import Scorer, find_scorer
from .tables import Row, Table
from .tabletops import measure as tabletops

Say = Callable[[str], None]

_SET_AND_METHOD = {"set": ("set", ""), "method": ("method", "")}
_PAGE = {
    "G": ("G", ".4f"),
    "mean": ("displacement mean px", ".2f"),
    "median": ("median", ".2f"),
    "p95": ("95 %", ".2f"),
}
_STRAIN = {
    "stretch_median": ("stretch median", ".4f"),
    "stretch_95th_percentile": ("95 %", ".4f"),
    "flipped_triangles": ("flipped", "d"),
}
_SECONDS = {"build surface seconds": ("surface s", ".1f"), "unwrap seconds": ("flatten s", ".1f")}
_REAL = (
    _SET_AND_METHOD
    | _PAGE
    | {
        "bins": ("share per px bin", ".2f"),
        "anisotropy": ("anisotropy", ".4f"),
        "sift_mean": ("SIFT mean px", ".2f"),
        "coverage": ("print on the page", ".3f"),
    }
    | _STRAIN
    | _SECONDS
)
_RENDERED = (
    _SET_AND_METHOD
    | {
        "surface_rms": ("surface rms %", ".3f"),
        "surface_p95": ("95 %", ".3f"),
        "flat_mean": ("flat position mean %", ".3f"),
        "flat_p95": ("95 %", ".3f"),
        "affine_mean": ("after affine %", ".3f"),
        "aspect_percent": ("aspect %", "+.2f"),
        "outside": ("beyond the page", ".3f"),
    }
    | _STRAIN
    | _SECONDS
    | {"G": ("page: G", ".4f"), "mean": ("page: displacement mean px", ".2f"), "p95": ("page: 95 %", ".2f")}
)
_RUNS = (
    {"set": ("set", ""), "stage": ("stage", ""), "seconds": ("s", ".1f"), "share": ("share", ".0%")}
    | {"processor_seconds": ("processor s", ".1f")}
    | {"megabytes": ("peak MiB", ".0f")}
    | _PAGE
    | {"coverage": ("print on the page", ".3f")}
)


def measure(data: Path, out: Path, *, parts: Sequence[str], names: Sequence[str] | None, quick: bool, say: Say) -> int:
    """Run the requested parts, write tables and plots into ``out``, print them; returns 1 if a cell failed."""
    out.mkdir(parents=True, exist_ok=True)
    scorer = find_scorer(data)
    sets = [photo_set for photo_set in photo_sets.find_sets(data) if not names or photo_set.name in names]
    if not sets and set(parts) - {"sweep", "tables"}:
        say(f"There is no photo set in {data}{f' named {names}' if names else ''}; name a folder that holds some.")
        return 2
    tables: list[Table] = []
    if "runs" in parts:
        tables.append(_whole_runs(sets, out, scorer, say))
    if "cells" in parts:
        tables += _cells(sets, out, scorer, quick, say)
    if "sweep" in parts:
        means, each = sweep.run(sweep.COUNTS[:1] if quick else sweep.COUNTS, say)
        plots.sweep(means.rows, out / "sweep.png")
        tables += [means, each]
    if "tables" in parts:
        seeds = tabletops.BENCHMARK_SEEDS[::4] if quick else tabletops.BENCHMARK_SEEDS
        folder = out / "tables"
        tables += tabletops.run(folder / "scenes", folder, seeds, tabletops.settings_for(None, None), say)
    for table in tables:
        table.write(out)
    text = "\n".join([_heading(scorer), *(table.markdown() for table in tables if not table.name.endswith("_each"))])
    (out / "benchmark.md").write_text(text, encoding="utf-8")
    print(text)
    # A baseline that fails is a result, and so is a scene that Origami refuses with a message.
    failed = [
        row
        for table in tables
        for row in table.rows
        if row.get("failure") and "page-dewarp" not in row.get("method", "") and row.get("verdict") != "failed"
    ]
    return min(len(failed), 1)


def _heading(scorer: Scorer) -> str:
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    return f"# Benchmark\n\n{packages}; {os.cpu_count()} cores ({platform.machine()}). Scores: {scorer.origin}.\n"


def _whole_runs(sets: Sequence[photo_sets.PhotoSet], out: Path, scorer: Scorer, say: Say) -> Table:
    table = Table("runs", "The command line on every set, default settings", _RUNS)
    for photo_set in sets:
        say(f"{photo_set.name}: a whole run")
        rows = whole_runs.run(photo_set, out / "runs" / photo_set.name, scorer)
        whole = rows[-1]["seconds"]
        table.rows += [{"method": "command line"} | row | {"share": row["seconds"] / whole} for row in rows]
        table.write(out)
    table.notes = [
        "Seconds were measured on this machine with its other load; the share is of the set's whole run.",
        "Processor seconds add up over the cores. Memory is the process and its children together.",
    ]
    plots.stages(table.rows, out / "runs.png")
    return table


def _cells(sets: Sequence[photo_sets.PhotoSet], out: Path, scorer: Scorer, quick: bool, say: Say) -> list[Table]:
    methods = (PAPER, PAPER_WITHOUT_ROWS, DEFAULT) if quick else ON_PHOTOS
    real = Table("real", "Real sets: the paper's protocol", _REAL)
    rendered = Table("rendered", "Rendered sets: exact errors, per cent of the page's height", _RENDERED)
    for photo_set in sets:
        table = rendered if photo_set.is_rendered else real
        work = out / "runs" / photo_set.name / "work"
        work.mkdir(parents=True, exist_ok=True)
        table.rows += photo_sets.run_set(photo_set, work, out, methods, scorer, say)
        if photo_set.name in paper.RA_L1:
            table.rows.append(_reported(photo_set.name))
        # Write after each set, to avoid losing an hour's work at the last cell.
        table.write(out)
    if real.rows:
        real.notes = [
            f"The paper's own row: {paper.NOTE}.",
            "Displacement of the print after an affine, px at 1000 px page height.",
        ]
        plots.histograms(real.rows, out / "real_histograms.png")
        plots.bars(real.rows, "mean", "mean displacement, px at 1000 px page height", out / "real.png")
    if rendered.rows:
        plots.bars(rendered.rows, "flat_mean", "mean flat position error, % of the height", out / "rendered.png")
    return [table for table in (real, rendered) if table.rows]


def _reported(name: str) -> Row:
    value = paper.RA_L1[name]
    return {
        "set": name,
        "method": "the paper's RA+L1, as reported",
        "G": value.global_distortion,
        "mean": value.mean,
        "bins": list(value.bins),
    }
