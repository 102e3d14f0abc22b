"""Measure whether Origami finds the true sheet in a scene, and whether it warns if it does not."""

from __future__ import annotations

import json
import statistics
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ...core.errors import OrigamiError
from ...origami_addon import steps
from ...origami_addon.files.image_files import to_eight_bits
from ...origami_addon.files.photos import gather, read_pixels
from ...origami_addon.report import Report
from ...origami_addon.settings import RunSettings
from ...origami_addon.state import Region
from ..tables import Row, Table
from . import files
from .scene import SHEETS, TABLES
from .shapes import Array

Say = Callable[[str], None]

# Seeds of the benchmark. Tune on others: see `generate.py`.
BENCHMARK_SEEDS = range(60)

# Overlap with the true sheet above which a found one counts as right, and as near.
RIGHT, NEAR = 0.98, 0.95
# The goals: share of right sheets, of wrong ones without a warning, of right ones with a warning.
_TARGETS = {"right": "at least 95 %", "silent": "0", "false": "below 5 %"}
# Warnings that only say what was done and express no doubt.
_STATEMENTS = ("sheets are in view",)
# Sub-pixels along a pixel's side in which the overlap is counted.
_FINE = 2
_PICTURE_SIDE = 1000

_COLUMNS = {
    "scene": ("scene", ""),
    "table": ("table", ""),
    "sheet": ("sheet", ""),
    "paper": ("paper", ""),
    "iou": ("IoU", ".4f"),
    "verdict": ("verdict", ""),
    "warned": ("warned", ""),
    "confidence": ("confidence", ".2f"),
    "reference": ("reference", ""),
    "place_seconds": ("place s", ".1f"),
    "find_seconds": ("find s", ".2f"),
    "processor_seconds": ("processor s", ".2f"),
    "warnings": ("warnings", ""),
}
_GROUP_COLUMNS = {
    "group": ("", ""),
    "scenes": ("scenes", "d"),
    "right": ("right", ".0%"),
    "near": ("near", ".0%"),
    "wrong": ("wrong", ".0%"),
    "failed": ("failed", ".0%"),
    "silent": ("wrong, no warning", ".0%"),
    "false": ("right, false warning", ".0%"),
    "median": ("median IoU", ".4f"),
    "worst": ("worst", ".3f"),
    "seconds": ("find, processor s", ".2f"),
}


def run(scenes: Path, out: Path, seeds: Sequence[int], settings: RunSettings, say: Say) -> list[Table]:
    """Measure on the scenes of ``seeds``, and write tables and a picture for each scene into ``out``.

    Parameters
    ----------
    scenes : Path
        Folder of the scenes; missing ones are generated.
    out : Path
        Placed photos are kept in its subfolder ``work``, from which a second run takes them.
    seeds : sequence of int
    settings : RunSettings
    say : callable
        Receives a sentence about each scene.
    """
    (out / "pictures").mkdir(parents=True, exist_ok=True)
    each = Table("tables_each", "Sheets on tables, one by one", _COLUMNS)
    for seed in seeds:
        folder = scenes / f"{seed:04d}"
        if not (folder / "truth.json").is_file():
            say(f"scene {seed}: generating")
            files.write(seed, folder)
        row = measure_scene(folder, out / "work" / folder.name, out / "pictures" / f"{folder.name}.jpg", settings)
        outcome = row.get("failure") or f"IoU {row['iou']:.3f}, {row['find_seconds']:.1f} s"
        say(f"scene {seed}, {row['sheet']} on {row['table']}: {row['verdict']}, {outcome}")
        each.rows.append(row)
        each.write(out)
    summary = summarize(each.rows)
    summary.write(out)
    return [summary, each]


def measure_scene(folder: Path, work: Path, picture: Path, settings: RunSettings) -> Row:
    """The row of one scene: how well the found outline agrees with the true one in the reference photo."""
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    row: Row = {"scene": folder.name} | {key: truth[key] for key in ("table", "sheet", "paper", "layout")}
    report = Report({})
    try:
        photos, _ = gather([folder / "photos"])
        work.mkdir(parents=True, exist_ok=True)
        model = steps.place_photos(steps.Work(photos, work, settings, report))
        row["place_seconds"] = report.stages[-1]["seconds"]
        # In a folder of its own, so that an outline is found each time and its seconds are true.
        with tempfile.TemporaryDirectory() as fresh:
            begun, used = time.perf_counter(), time.process_time()
            region = steps.find_sheet(model, steps.Work(photos, Path(fresh), settings, report))
            row["find_seconds"] = time.perf_counter() - begun
            row["processor_seconds"] = time.process_time() - used
    except OrigamiError as why:
        return row | {"verdict": "failed", "failure": str(why)}
    except Exception as why:  # a crash is a result too
        return row | {
            "verdict": "crashed",
            "failure": f"{type(why).__name__}: {why}",
            "traceback": traceback.format_exc(),
        }
    name = model.cameras[region.reference].name
    shown = next(photo for photo in truth["photos"] if photo["file"] == name)
    warnings = report.stages[-1]["warnings"]
    row |= judge(region, shown, warnings) | {"reference": name}
    image = to_eight_bits(read_pixels(next(photo for photo in photos if photo.name == name)))
    _draw(image, np.array(shown["outline"]), region.outline.polygon, row, picture)
    return row


def judge(region: Region, shown: dict[str, Any], warnings: Sequence[str]) -> Row:
    """Overlap, verdict and warnings of a found region in a photo whose truth is ``shown``.

    A warning is false if the sheet is right, whole in the photo and uncovered.
    """
    iou = overlap(region.outline.polygon, np.array(shown["outline"]), (shown["width"], shown["height"]))
    verdict = "right" if iou >= RIGHT else "near" if iou >= NEAR else "wrong"
    doubts = [warning for warning in warnings if not any(statement in warning for statement in _STATEMENTS)]
    has_cause = shown["cut_off"] or shown["hand_on_sheet"]
    return {
        "iou": iou,
        "verdict": verdict,
        "warned": "yes" if doubts else "no",
        "false_warning": bool(doubts) and verdict == "right" and not has_cause,
        "confidence": region.outline.confidence,
        "warnings": " ".join(warnings),
    }


def overlap(first: Array, second: Array, size: tuple[int, int]) -> float:
    """Intersection over union of two polygons (K, 2) within a photo of ``size`` (width, height)."""
    masks = []
    for polygon in (first, second):
        mask = np.zeros((size[1] * _FINE, size[0] * _FINE), np.uint8)
        # OpenCV has a pixel's centre at whole numbers, with sixteenths as the last four bits.
        pixels = np.clip(polygon * _FINE - 0.5, -(2**15), 2**15) * 16
        cv2.fillPoly(mask, [np.round(pixels).astype(np.int32)], 1, cv2.LINE_8, 4)
        masks.append(mask.astype(bool))
    union = (masks[0] | masks[1]).sum()
    return float((masks[0] & masks[1]).sum() / union) if union else 0.0


def _draw(image: np.ndarray, truth: Array, found: Array, row: Row, path: Path) -> None:
    """The reference photo with the true outline in green and the found one in red."""
    factor = _PICTURE_SIDE / max(image.shape[:2])
    small = cv2.resize(np.ascontiguousarray(image[..., ::-1]), None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    for polygon, colour, width in ((truth, (0, 200, 0), 4), (found, (0, 0, 255), 2)):
        pixels = np.round(np.clip(polygon, -5000, 20000) * factor * 16).astype(np.int32)
        cv2.polylines(small, [pixels], True, colour, width, cv2.LINE_AA, 4)
    text = f"{row['scene']} {row['sheet']} on {row['table']}: IoU {row['iou']:.3f}, warned: {row['warned']}"
    for colour, width in (((0, 0, 0), 4), ((255, 255, 255), 1)):
        cv2.putText(small, text, (8, 22), cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, width, cv2.LINE_AA)
    cv2.imwrite(str(path), small, [cv2.IMWRITE_JPEG_QUALITY, 85])


def summarize(rows: Sequence[Row]) -> Table:
    """Shares of verdicts and warnings: of all scenes, of each kind of table, of each kind of sheet, of each paper."""
    table = Table("tables", "Sheets on tables: is the sheet found?", _GROUP_COLUMNS)
    table.rows = [_group("all", rows)]
    for key, kinds in (("table", TABLES), ("sheet", SHEETS), ("paper", sorted({row["paper"] for row in rows}))):
        for kind in kinds:
            some = [row for row in rows if row[key] == kind]
            if some:
                table.rows.append(_group(f"{key}: {kind}", some))
    whole = table.rows[0]
    table.notes = [
        f"Right: overlap (IoU) of at least {RIGHT} with the true sheet in the reference photo; near: at least {NEAR}.",
        f"Right {whole['right']:.0%} (aim: {_TARGETS['right']}); wrong without a warning {whole['silent']:.0%} (aim: "
        f"{_TARGETS['silent']}); right with a false warning {whole['false'] or 0:.0%} (aim: {_TARGETS['false']}).",
        "A warning is false if the sheet is right, whole in the photo and uncovered; its share is of right sheets.",
        "Failed: the run ended with a sentence, or crashed; it counts as warned.",
        "Processor seconds, median, are the time that finding takes on an idle core, whatever else the machine does.",
    ]
    return table


def _group(name: str, rows: Sequence[Row]) -> Row:
    count = len(rows)
    overlaps = [row["iou"] for row in rows if "iou" in row]
    seconds = [row["processor_seconds"] for row in rows if "processor_seconds" in row]
    right = [row for row in rows if row["verdict"] == "right"]

    def share(*verdicts: str) -> float:
        return sum(row["verdict"] in verdicts for row in rows) / count

    return {
        "group": name,
        "scenes": count,
        "right": share("right"),
        "near": share("near"),
        "wrong": share("wrong"),
        "failed": share("failed", "crashed"),
        "silent": sum(row["verdict"] == "wrong" and row["warned"] == "no" for row in rows) / count,
        "false": sum(row["false_warning"] for row in right) / len(right) if right else None,
        "median": statistics.median(overlaps) if overlaps else None,
        "worst": min(overlaps, default=None),
        "seconds": statistics.median(seconds) if seconds else None,
    }


def settings_for(threads: int | None, image_size: int | None) -> RunSettings:
    """The defaults, with other threads or another image size for structure from motion, if given."""
    settings = RunSettings()
    sfm = settings.sfm
    if threads is not None:
        sfm = replace(sfm, threads=threads)
    if image_size is not None:
        sfm = replace(sfm, max_image_size=image_size)
    return replace(settings, sfm=sfm)
