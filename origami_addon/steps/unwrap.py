"""Unwrap the sheet: the flat places of its vertices."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.flat.distortion import flipped_triangles, measure_strain
from ...core.flat.flatten import flatten
from ...core.flat.pins import Pins
from ...core.sheet import Sheet, sheet_arrays
from ...core.watch import SILENT, Watch
from ..files.kept import digest_of, kept, key_of
from ..stages import about
from .work import Work, code


def unwrap_sheet(sheet: Sheet, work: Work, watch: Watch = SILENT, pins: Pins | None = None) -> Array:
    """Flat coordinates (V, 2) of the sheet's vertices, not yet turned, placed and scaled as a page.

    Pinned vertices stay at their pins, which are in the sheet's unit.

    Raises
    ------
    Cancelled, StepFailed
    """
    held, settings = [] if pins is None else [pins.vertices, pins.uv], work.settings.flatten
    key = key_of(code(), digest_of(*sheet_arrays(sheet).values(), *held), asdict(settings))
    with work.report.stage(about("unwrap").reported) as figures:

        def compute() -> tuple[dict[str, Any], dict[str, Any]]:
            return {"uv": flatten(sheet, settings, watch, pins=pins)}, {}

        arrays, _ = kept(work.folder, "flat", key, compute, work.report.warn)
        uv = arrays["uv"]
        strain = measure_strain(sheet.vertices, sheet.triangles, uv)
        flipped = int(flipped_triangles(sheet.triangles, uv).sum())
        figures |= {
            "stretch_median": float(np.median(strain.stretch)),
            "stretch_95th_percentile": float(np.percentile(strain.stretch, 95)),
            "angle_distortion_mean": float(strain.area @ strain.angle_distortion),
            "flipped_triangles": flipped,
        }
        if flipped:
            work.report.warn(
                f"{flipped} of {len(sheet.triangles)} triangles of the flat sheet lie upside down, so the page is "
                "wrong there; try a conformal method (--unwrap conformal_l1 or lscm, or Method in Blender)."
            )
        return uv
