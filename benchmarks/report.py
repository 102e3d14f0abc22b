"""The whole benchmark: what is measured, and how the results are written."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path

from ..origami_addon.report import versions
from . import lights, paper, photo_sets, plots, sweep, whole_runs
from .methods import ABLATION, BASELINES, DEFAULT, ON_PHOTOS, PAPER, Method
from .photo_set import PhotoSet, find_sets
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
_RULES = {"rules_rms": ("rules wave rms px", ".2f"), "rules_worst": ("worst rule px", ".2f")}
_EXACT_PAGE = {
    "page_mean": ("page error mean %", ".4f"),
    "page_p95": ("95 %", ".4f"),
    "rows_rms": ("waves along rows rms %", ".4f"),
    "rows_worst": ("worst row %", ".3f"),
    "columns_rms": ("along columns rms %", ".4f"),
    "columns_worst": ("worst column %", ".3f"),
    "aspect_percent": ("aspect %", "+.3f"),
}
_STRAIN = {
    "stretch_median": ("stretch median", ".4f"),
    "stretch_95th_percentile": ("95 %", ".4f"),
    "flipped_triangles": ("flipped", "d"),
}
_SECONDS = {
    "tracks seconds": ("tracks s", ".1f"),
    "sheet seconds": ("surface s", ".1f"),
    "flat seconds": ("flatten s", ".1f"),
}
_REAL = (
    _SET_AND_METHOD
    | _PAGE
    | _RULES
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
    | _EXACT_PAGE
    | {
        "page_known": ("of the page", ".3f"),
        "surface_rms": ("surface rms %", ".3f"),
        "surface_p95": ("95 %", ".3f"),
        "outside": ("beyond the page", ".3f"),
    }
    | _STRAIN
    | _SECONDS
    | {"G": ("page: G", ".4f"), "mean": ("page: displacement mean px", ".2f"), "p95": ("page: 95 %", ".2f")}
)
_ABLATION = (
    _SET_AND_METHOD
    | _EXACT_PAGE
    | {"mean": ("displacement mean px", ".2f"), "p95": ("95 %", ".2f"), "G": ("G", ".4f")}
    | _RULES
    | {"stiffness": ("stiffness", ".0f"), "creases": ("creases", "d"), "tracks": ("tracks", "d")}
    | _SECONDS
)
_RUNS = (
    _SET_AND_METHOD
    | {"stage": ("stage", ""), "seconds": ("s", ".1f"), "share": ("share", ".0%")}
    | {"processor_seconds": ("processor s", ".1f")}
    | {"megabytes": ("peak MiB", ".0f")}
    | _EXACT_PAGE
    | _PAGE
    | _RULES
    | {"coverage": ("print on the page", ".3f")}
)
_LIGHT = {
    "set": ("set", ""),
    "page": ("page", ""),
    "unevenness": ("unevenness L*", ".2f"),
    "own_unevenness": ("original's", ".2f"),
    "delta_e": ("delta E mean", ".2f"),
    "delta_e_p95": ("95 %", ".2f"),
    "paper_lightness": ("paper L*", ".1f"),
    "paper_chroma": ("paper C*", ".1f"),
    "original_chroma": ("original's", ".1f"),
    "mtf_eighth": ("mtf 1/8", ".2f"),
    "mtf_quarter": ("mtf 1/4", ".2f"),
    "noise": ("noise L*", ".2f"),
    "psnr": ("PSNR dB", ".1f"),
    "ssim": ("SSIM", ".3f"),
}
_LIGHT_NOTES = [
    "At 2000 px page height, the page laid onto its flat original. Unevenness (blank paper, 5th to 95th percentile), "
    "delta E (CIE76, away from edges), PSNR and SSIM (at 1000 px) are after one gain per channel; paper and noise (on "
    "blank paper) as the page has them. The original's own unevenness comes from print beside blank paper. Mtf: "
    "contrast of detail, page over original, by cycles per pixel.",
]
_EXACT_NOTES = [
    "Page error: how far each pixel of the page is from its place on the flat original, after a similarity, per cent "
    "of the page's height. Waves: how far lines of the page depart from their own best straight lines, rms and the "
    "largest on the worst line. Aspect: how much too wide the page is.",
]
_RULES_NOTE = (
    "Rules: how far the original's straight edges from 100 px on depart from straight lines on the page, px at 1000 px "
    "page height, rms and the largest on the worst edge."
)


def measure(data: Path, out: Path, *, parts: Sequence[str], names: Sequence[str] | None, quick: bool, say: Say) -> int:
    """Run the requested parts, write tables and plots into ``out``, print them; returns 1 if a cell failed."""
    out.mkdir(parents=True, exist_ok=True)
    scorer = find_scorer(data)
    sets = [photo_set for photo_set in find_sets(data) if not names or photo_set.name in names]
    if not sets and set(parts) - {"sweep", "tables"}:
        say(f"There is no photo set in {data}{f' named {names}' if names else ''}; name a folder that holds some.")
        return 2
    tables: list[Table] = []
    if "runs" in parts:
        tables.append(_whole_runs(sets, out, scorer, say))
    if "light" in parts:
        tables.append(_lights(sets, out, scorer, say))
    if {"cells", "ablation"} & set(parts):
        tables += _cells(sets, out, scorer, parts, quick, say)
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


def _whole_runs(sets: Sequence[PhotoSet], out: Path, scorer: Scorer, say: Say) -> Table:
    table = Table("runs", "The command line on every set, with the default settings and with the paper's method", _RUNS)
    for photo_set in sets:
        for method in (DEFAULT, PAPER):
            say(f"{photo_set.name}: a whole run, {method.name}")
            rows = whole_runs.run(photo_set, out / "runs", method, scorer)
            whole = rows[-1]["seconds"]
            table.rows += [row | {"method": method.name, "share": row["seconds"] / whole} for row in rows]
            table.write(out)
    table.notes = [
        "Seconds were measured on this machine with its other load; the share is of the set's whole run.",
        "Processor seconds add up over the cores. Memory is the process and its children together.",
        *_EXACT_NOTES,
        _RULES_NOTE,
    ]
    plots.stages([row for row in table.rows if row["method"] == DEFAULT.name], out / "runs.png")
    return table


def _lights(sets: Sequence[PhotoSet], out: Path, scorer: Scorer, say: Say) -> Table:
    table = Table("light", "Light, colour, sharpness and noise of the page beside its original", _LIGHT)
    table.notes = _LIGHT_NOTES
    for photo_set in sets:
        work = out / "runs" / photo_set.name / "work"
        work.mkdir(parents=True, exist_ok=True)
        table.rows += lights.run(photo_set, work, out / "light" / photo_set.name, scorer, say)
        table.write(out)
    return table


def _cells(
    sets: Sequence[PhotoSet], out: Path, scorer: Scorer, parts: Sequence[str], quick: bool, say: Say
) -> list[Table]:
    compared: tuple[Method, ...] = (DEFAULT, *BASELINES)
    if "cells" in parts and not quick:
        compared = ON_PHOTOS
    left_out = ABLATION if "ablation" in parts else ()
    real = Table("real", "Real sets: the paper's protocol", _REAL)
    rendered = Table("rendered", "Rendered sets: exact errors, per cent of the page's height", _RENDERED)
    ablation = Table("ablation", "The default with one of its parts left out", _ABLATION)
    for photo_set in sets:
        work = out / "runs" / photo_set.name / "work"
        work.mkdir(parents=True, exist_ok=True)
        rows, errors = photo_sets.run_set(
            photo_set, work, out, (*compared, *left_out), scorer, say, others="cells" in parts
        )
        table = rendered if photo_set.is_rendered else real
        without = {method.name for method in left_out}
        if "cells" in parts:
            table.rows += [row for row in rows if row["method"] not in without]
            if photo_set.name in paper.RA_L1:
                table.rows.append(_reported(photo_set.name))
        if "ablation" in parts:
            beside = {method.name for method in (DEFAULT, *BASELINES)} | {photo_sets.WHOLE_SET}
            ablation.rows += [row for row in rows if row["method"] in beside | without]
        if errors:
            folder = out / "errors"
            folder.mkdir(exist_ok=True)
            plots.page_errors(errors, f"{photo_set.name}: page error", folder / f"{photo_set.name}.png")
        # Write after each set, to avoid losing an hour's work at the last cell.
        for each in (table, ablation):
            if each.rows:
                each.write(out)
    if real.rows:
        real.notes = [
            f"The paper's own row: {paper.NOTE}.",
            "Displacement of the print after an affine, px at 1000 px page height.",
            _RULES_NOTE,
        ]
        plots.histograms(real.rows, out / "real_histograms.png")
        plots.bars(real.rows, "mean", "mean displacement, px at 1000 px page height", out / "real.png")
    if rendered.rows:
        rendered.notes = [*_EXACT_NOTES, "Surface: distance to the nearest point of the true surface."]
        plots.bars(rendered.rows, "page_mean", "mean page error, % of the height", out / "rendered.png")
    if ablation.rows:
        ablation.notes = [
            *_EXACT_NOTES,
            "Displacement of the print after an affine, px at 1000 px page height.",
            _RULES_NOTE,
            "A result that the part does not change is the default's own, with its seconds.",
        ]
    return [table for table in (real, rendered, ablation) if table.rows]


def _reported(name: str) -> Row:
    value = paper.RA_L1[name]
    return {
        "set": name,
        "method": "the paper's RA+L1, as reported",
        "G": value.global_distortion,
        "mean": value.mean,
        "bins": list(value.bins),
    }
