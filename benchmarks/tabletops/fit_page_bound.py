"""Fit the bound on the page's error, in `core/checks/page_bound.py`, on generated scenes whose truth is exact.

    OMP_NUM_THREADS=1 .venv/bin/python benchmarks/tabletops/fit_page_bound.py --seeds 6000-6029 -o out/bound

Every second scene has a phone's lens. The reference photo and the paper's edge are given, to a third of a pixel; all
else is a run with the default settings, one to two minutes per scene. What a scene gives is kept in DIR. It prints,
for each sheet, the share of its page that keeps the bound fitted to the other sheets, and the weights fitted to all.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from run import load_checkout, seeds_of  # noqa: E402

_SIZE, _IMAGE_SIZE = (1280, 960), 1000  # of the photos, and of those in structure from motion
_EDGE_NOISE = 0.3  # pixels
_SHARE = 0.9
# Places of each page that count in the fit.
_PLACES = 400
# Share in the fit of how well a bound follows the error within a page, beside its level on each page.
_WITHIN_PAGE = 0.3
_STARTS = ((1.0, 0.0, 1.5), (1.0, -0.5, -1.0))


def main(arguments: argparse.Namespace) -> None:
    """Measure, fit, print."""
    load_checkout()
    arguments.output.mkdir(parents=True, exist_ok=True)
    pages = {}
    for seed in arguments.seeds:
        kept = arguments.output / f"{seed}.npz"
        if not kept.exists():
            found = measured(seed, arguments.output / str(seed))
            if isinstance(found, str):
                print(f"{seed}: {found}")
                continue
            with kept.with_suffix(".unfinished").open("wb") as file:
                np.savez_compressed(file, **found)
            kept.with_suffix(".unfinished").replace(kept)
        pages[seed] = dict(np.load(kept))
        print(f"{seed}: error {np.median(pages[seed]['error']):.4f} % of the page's height (median)", flush=True)
    if len(pages) < 2:
        sys.exit("At least two scenes are needed, because each is left out once.")
    results = []
    for seed, page in pages.items():
        weights = fit([other for key, other in pages.items() if key != seed])
        bound = bound_of(weights, page)
        keeps, ratio = float((page["error"] <= bound).mean()), float(np.median(bound) / np.median(page["error"]))
        results.append((keeps, ratio))
        print(
            f"{seed} {page['kind']!s:8} error {np.median(page['error']):.4f}, bound {np.median(bound):.4f} (medians, "
            f"{ratio:.1f} times); {100 * keeps:.0f} % keep it",
            flush=True,
        )
    keeps, ratio = np.array(results).T
    inside = ((keeps >= 0.8) & (keeps <= 0.97)).sum()
    print(f"of all pages together {100 * keeps.mean():.1f} % keep it; 80 to 97 % on {inside} of {len(keeps)} sheets")
    print(f"the bound is {np.median(ratio):.1f} times the median error (median over the sheets)")
    scatters, strain, within = np.exp(fit(list(pages.values())))
    print(f"SCATTERS, STRAIN_WEIGHT, DOUBLED_WITHIN = {scatters:.2f}, {strain:.2f}, {within:.3f}")


def measured(seed: int, work: Path) -> dict[str, np.ndarray] | str:
    """Of places evenly over the page of a scene: what the bound is made from, and the error, % of the page's height.

    A sentence instead, if there is no page.
    """
    steps, state, report = (
        importlib.import_module(f"origami.origami_addon.{name}") for name in ("steps", "state", "report")
    )
    points_to_fit = importlib.import_module("origami.origami_addon.steps.surface").points_to_fit
    files, measure, page_truth = (
        importlib.import_module(f"origami.benchmarks.tabletops.{name}") for name in ("files", "measure", "page_truth")
    )
    core = {
        name.rpartition(".")[2]: importlib.import_module(f"origami.core.{name}")
        for name in (
            "checks.page_scatter",
            "flat.flatten",
            "numeric.triangles",
            "paper.reference_outline",
            "paper.sheet_points",
            "surface.creased_surface",
            "surface.mesh",
        )
    }
    errors = importlib.import_module("origami.core.errors")
    if not (work / "scene" / "truth.json").exists():
        files.write(seed, work / "scene", _SIZE, lens="" if seed % 2 else "phone")
    truth = json.loads((work / "scene" / "truth.json").read_text(encoding="utf-8"))
    shown = {photo["file"]: photo for photo in truth["photos"]}
    photos, _ = importlib.import_module("origami.origami_addon.files.photos").gather([work / "scene" / "photos"])
    settings = measure.settings_for(1, _IMAGE_SIZE)
    own = steps.Work(photos, work, settings, report.Report({}))
    try:
        model = steps.place_photos(own)
        names = [camera.name for camera in model.cameras]
        reference = min(range(len(names)), key=lambda index: page_truth.unfit(shown[names[index]]))
        edge = np.array(shown[names[reference]]["outline"])
        edge = edge + np.random.default_rng(seed).normal(0, _EDGE_NOISE, edge.shape)
        outline = core["reference_outline"].given_outline(edge)
        on_sheet = core["sheet_points"].points_on_sheet(model, reference, outline)
        found = state.Found(model, state.Region(reference, outline, on_sheet))
        cameras, points, observed = points_to_fit(found, own, {})
        seen_by, polygon = cameras[reference], outline.polygon
        surface = core["creased_surface"].reconstruct_with_creases(points, seen_by, polygon, settings.surface)
        sheet = core["mesh"].build_sheet(surface, polygon, list(surface.creases))
        scatter = core["page_scatter"].page_scatter(
            sheet, surface, points, observed, cameras, reference, settings.surface
        )
        uv = core["flatten"].flatten(sheet)
    except errors.OrigamiError as error:
        return str(error)
    true = page_truth.true_flat(truth, shown[names[reference]], seen_by.project(sheet.vertices))
    area = core["triangles"].areas(sheet.vertices, sheet.triangles)
    weight = np.bincount(sheet.triangles.ravel(), area.repeat(3), len(uv)) * np.isfinite(true[:, 0])
    places = np.random.default_rng(seed).choice(len(uv), _PLACES, p=weight / weight.sum())
    height = truth["page_mm"][1]
    error, scale = page_truth.page_error(uv[places], true[places], height)
    per_unit = 100 * scale / height
    return {
        "kind": np.array(truth["sheet"]),
        "error": 100 * error / height,
        "by_errors": scatter.by_errors[places] * per_unit,
        "strain": np.array(scatter.strain * per_unit),
        "gap": scatter.gap[places],
    }


def bound_of(weights: np.ndarray, page: dict[str, np.ndarray]) -> np.ndarray:
    """The bound as in `page_bound.page_bound`, from the logarithms of its weights."""
    scatters, strain, within = np.exp(weights)
    return scatters * np.hypot(page["by_errors"], strain * page["strain"]) * (1 + page["gap"] / within)


def fit(pages: list[dict[str, np.ndarray]]) -> np.ndarray:
    """Logarithms of the weights with which, page by page, the share that keeps the bound is as near as can be."""

    def cost(weights: np.ndarray) -> float:
        total = 0.0
        for page in pages:
            over = np.log(np.maximum(page["error"], 1e-6) / bound_of(weights, page))
            total += np.quantile(over, _SHARE) ** 2
            total += _WITHIN_PAGE * np.where(over > 0, _SHARE * over, (_SHARE - 1) * over).mean()
        return total / len(pages)

    found = min(
        (
            minimize(cost, start, method="Nelder-Mead", options={"initial_simplex": start + 0.6 * _SIMPLEX})
            for start in map(np.array, _STARTS)
        ),
        key=lambda result: result.fun,
    ).x
    # so that, of all pages together, this share keeps it
    over = np.concatenate([page["error"] / bound_of(found, page) for page in pages])
    return found + np.array([np.log(np.quantile(over, _SHARE)), 0, 0])


_SIMPLEX = np.vstack([np.zeros(3), np.eye(3)])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, required=True, help="for example 6000-6029")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main(parser.parse_args())
