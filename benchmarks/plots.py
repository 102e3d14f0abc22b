"""The tables as pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from . import paper
from .methods import BROWN, DEFAULT, PAPER, PAPER_WITHOUT_ROWS, STIFFNESS_BY_RULE, ZHANG
from .page_error import PageError
from .tables import Row

_SHOWN_IN_HISTOGRAMS = (PAPER.name, PAPER_WITHOUT_ROWS.name, DEFAULT.name)
_STYLES = {
    PAPER.name: ("tab:blue", "-"),
    PAPER_WITHOUT_ROWS.name: ("tab:cyan", "-"),
    BROWN.name: ("tab:orange", "--"),
    ZHANG.name: ("tab:red", "--"),
    DEFAULT.name: ("tab:green", "-"),
    STIFFNESS_BY_RULE.name: ("tab:olive", "-"),
}
_SHOWN_AS_MAPS = (PAPER.name, STIFFNESS_BY_RULE.name, DEFAULT.name)
# The largest error with a colour of its own is at least this, % of the page's height.
_LEAST_SCALE = 0.05


def bars(rows: Sequence[Row], figure: str, label: str, path: Path) -> None:
    """One group of bars per set, one bar per method."""
    good = [row for row in rows if row.get(figure) is not None]
    sets, methods = (list(dict.fromkeys(row[key] for row in good)) for key in ("set", "method"))
    if not sets:
        return
    picture, axes = plt.subplots(figsize=(4 + 2 * len(sets), 5.5), layout="constrained")
    width = 0.85 / len(methods)
    for i, method in enumerate(methods):
        values = {row["set"]: row[figure] for row in good if row["method"] == method}
        places = [sets.index(name) - 0.425 + width * (i + 0.5) for name in values]
        axes.bar(places, list(values.values()), width, label=method, color=plt.get_cmap("tab20")(i % 20))
    axes.set_xticks(range(len(sets)), sets)
    axes.set_ylabel(label)
    # A method with huge errors must not flatten the others' bars.
    typical = np.median([row[figure] for row in good])
    axes.set_ylim(0, min(max(row[figure] for row in good) * 1.05, 4 * typical))
    picture.legend(loc="outside lower center", fontsize="x-small", ncols=3)
    _save(picture, path)


def histograms(rows: Sequence[Row], path: Path) -> None:
    """Share of the print per pixel of displacement, beside the paper's."""
    sets = [name for name in paper.RA_L1 if any(row["set"] == name and "bins" in row for row in rows)]
    if not sets:
        return
    picture, panels = plt.subplots(1, len(sets), figsize=(4.5 * len(sets), 3.5), squeeze=False, layout="constrained")
    for name, axes in zip(sets, panels[0], strict=True):
        shown = {row["method"]: row["bins"] for row in rows if row["set"] == name and "bins" in row}
        curves = {"the paper's RA+L1, read off its figure": list(paper.RA_L1[name].bins)}
        curves |= {method: shown[method] for method in _SHOWN_IN_HISTOGRAMS if method in shown}
        width = 0.85 / len(curves)
        for i, (label, shares) in enumerate(curves.items()):
            axes.bar(np.arange(len(shares)) + 0.075 + width * (i + 0.5), shares, width, label=label)
        axes.set_title(name)
        axes.set_xlabel("displacement, px at 1000 px page height")
    panels[0, 0].set_ylabel("share of the print")
    panels[0, 0].legend(fontsize="x-small")
    _save(picture, path)


def sweep(rows: Sequence[Row], path: Path) -> None:
    """Errors over noise, one column for each number of points: mean displacement above, G below."""
    good = [row for row in rows if "mean" in row]
    counts = list(dict.fromkeys(row["points"] for row in good))
    if not counts:
        return
    picture, panels = plt.subplots(
        2, len(counts), figsize=(4 * len(counts), 6), squeeze=False, sharex=True, sharey="row", layout="constrained"
    )
    for column, count in enumerate(counts):
        for method in dict.fromkeys(row["method"] for row in good):
            mine = [row for row in good if row["points"] == count and row["method"] == method]
            noise = [row["noise_percent"] for row in mine]
            color, line = _STYLES[method]
            for axes, figure in zip(panels[:, column], ("mean", "G"), strict=True):
                axes.plot(noise, [row[figure] for row in mine], line, color=color, marker="o", label=method)
        panels[0, column].set_title(f"{count} points")
        panels[1, column].set_xlabel("noise, % of the page's height")
    panels[0, 0].set_ylabel("mean displacement, px at 1000 px")
    panels[1, 0].set_ylabel("G")
    panels[0, 0].legend(fontsize="x-small")
    _save(picture, path)


def page_errors(errors: Mapping[str, PageError], title: str, path: Path) -> None:
    """Maps of the page error of one set: a row of pictures for each method; length, and parts across and down."""
    shown = {name: errors[name] for name in _SHOWN_AS_MAPS if name in errors}
    if not shown:
        return
    sizes = [np.nanpercentile(error.length, 99) for error in shown.values()]
    # The best method's errors must stay visible.
    scale = max(min(sizes), _LEAST_SCALE)
    rows, columns = next(iter(shown.values())).length.shape
    size = (11, 0.6 + len(shown) * (0.5 + 2.8 * rows / columns))
    picture, panels = plt.subplots(len(shown), 3, figsize=size, squeeze=False, layout="constrained")
    for axes, (name, error) in zip(panels, shown.items(), strict=True):
        parts = {"length": error.length, "to the right": error.vectors[..., 0], "down": error.vectors[..., 1]}
        for panel, (part, values) in zip(axes, parts.items(), strict=True):
            signed = part != "length"
            colors = plt.get_cmap("RdBu_r" if signed else "viridis").with_extremes(bad="0.6")
            image = panel.imshow(values, cmap=colors, vmin=-scale if signed else 0, vmax=scale, interpolation="nearest")
            panel.set_title(part, fontsize="small")
            panel.set_xticks([])
            panel.set_yticks([])
            if part != "to the right":
                extend = "both" if signed else "max"
                picture.colorbar(image, ax=panel, extend=extend, shrink=0.8).set_label("% of the page's height")
        axes[0].set_ylabel(f"{name}\nmean {np.nanmean(error.length):.3f} %")
    picture.suptitle(title)
    _save(picture, path)


def stages(rows: Sequence[Row], path: Path) -> None:
    """Seconds and peak memory of each stage of the command line."""
    steps = [row for row in rows if row["stage"] != "all"]
    sets, names = (list(dict.fromkeys(row[key] for row in steps)) for key in ("set", "stage"))
    if not sets:
        return
    picture, (left, right) = plt.subplots(1, 2, figsize=(13, 2.2 + 0.5 * len(sets)), sharey=True, layout="constrained")
    before = np.zeros(len(sets))
    for name in names:
        found = {row["set"]: row for row in steps if row["stage"] == name}
        seconds = np.array([found[key]["seconds"] if key in found else 0.0 for key in sets])
        left.barh(sets, seconds, left=before, label=name)
        right.plot([found[key]["megabytes"] if key in found else np.nan for key in sets], sets, "o", label=name)
        before += seconds
    left.set_xlabel("seconds")
    right.set_xlabel("peak memory, MiB")
    right.set_xlim(left=0)
    picture.legend(*left.get_legend_handles_labels(), loc="outside lower center", fontsize="x-small", ncols=6)
    _save(picture, path)


def _save(picture: plt.Figure, path: Path) -> None:
    picture.savefig(path, dpi=110)
    plt.close(picture)
