"""Build the sheet's surface, with its creases and the bound of its page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.camera import Camera
from ...core.checks.page_bound import page_bound
from ...core.checks.page_scatter import page_scatter
from ...core.creases.crease_ends import off_the_paper
from ...core.creases.creases import crease_figures
from ...core.edge.measured_edge import fit_to_edge
from ...core.errors import StepFailed
from ...core.sheet import Sheet, sheet_arrays, sheet_from_arrays
from ...core.sparse_model import camera_arrays, cameras_from_arrays
from ...core.surface.creased_surface import reconstruct_with_creases
from ...core.surface.mesh import build_sheet
from ...core.surface.surface import Surface
from ...core.surface.surface_settings import SurfaceSettings
from ...core.tracks.measured_points import measure_points
from ...core.watch import SILENT, Watch
from ..files.kept import Arrays, digest_of, kept
from ..files.photo_pixels import PhotoPixels
from ..stages import about
from ..state import Found
from .work import Work, camera_values, key_with_photos

# The surface on which the print is followed may be off by a hundredth of the page: with 50 rows pages are .0110 % of
# their height off, with 85 .0111 %.
_FIRST_SURFACE = SurfaceSettings(grid_rows=50)


def build_surface(state: Found, work: Work, watch: Watch = SILENT) -> tuple[tuple[Camera, ...], Sheet]:
    """Build the sheet's surface, with the creases that are given or else found, and cut it out along the paper's edge.

    Returns
    -------
    cameras : tuple of Camera
        Those of the sparse model, in its order, adjusted to the sheet's print if enough of it can be followed.
    sheet : Sheet

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos
    """
    settings, polygon = work.settings, state.region.outline.polygon
    with work.report.stage(about("surface").reported) as figures:
        cameras, points, observed = points_to_fit(state, work, figures, watch.part(0, 0.6))
        reference = cameras[state.region.reference]
        digest = digest_of(points, observed, *(array for camera in cameras for array in camera_values(camera)), polygon)
        pixels = PhotoPixels(work.photos, state.model)
        key = key_with_photos(
            pixels, state.model, digest, asdict(settings.surface), settings.sfm.seed, settings.creases
        )
        given = None if settings.creases is None else np.array(settings.creases).reshape(-1, 2, 2)

        def compute() -> tuple[Arrays, dict[str, Any]]:
            surface = reconstruct_with_creases(
                points,
                reference,
                polygon,
                settings.surface,
                given=given,
                seed=settings.sfm.seed,
                threads=settings.sfm.threads,
                watch=watch.part(0.6, 0.8),
            )
            if settings.surface.method == "developable":
                surface = fit_to_edge(
                    surface,
                    points,
                    settings.surface,
                    cameras,
                    state.region.reference,
                    polygon,
                    pixels,
                    settings.sfm.threads,
                    watch.part(0.8, 0.9),
                )
            frame = surface.grid.frame
            sheet = build_sheet(surface, polygon, list(surface.creases))
            sheet, unknown = _with_bound(sheet, surface, points, observed, cameras, state, work, watch.part(0.9, 1))
            notes = {
                "grid_nodes": surface.grid.size,
                "noise_page_lengths": surface.noise,
                "residual_median_page_lengths": float(np.median(np.abs(surface.residuals))),
                "stiffness": surface.stiffness,
                "edge_points": 0 if surface.edge is None else len(surface.edge),
                "creases": len(surface.creases),
                "crease_confidence": list(surface.confidence),
                "fold_angles_degrees": [crease.fold_angle for crease in crease_figures(sheet)],
                "creases_given": None if given is None else len(given),
                "creases_off_the_paper": []
                if given is None
                else off_the_paper(map(frame.from_pixels, given), frame.from_pixels(polygon)),
                "vertices": len(sheet.vertices),
                "bound_unknown": unknown,
            }
            return sheet_arrays(sheet), notes

        arrays, notes = kept(work.folder, "sheet", key, compute, work.report.warn)
        off, unknown = notes.pop("creases_off_the_paper"), notes.pop("bound_unknown")
        figures |= notes
        work.report.warn(
            *([] if unknown is None else [f"How exact the page is could not be estimated: {unknown}"]),
            *(
                f"Crease {number + 1} of the {notes['creases_given']} given lies outside the paper's edge and was left "
                f"out; look at its ends, or at the outline."
                for number in off
            ),
        )
        return cameras, sheet_from_arrays(arrays)


def _with_bound(
    sheet: Sheet,
    surface: Surface,
    points: Array,
    observed: Array,
    cameras: Sequence[Camera],
    state: Found,
    work: Work,
    watch: Watch,
) -> tuple[Sheet, str | None]:
    """The sheet with the bound of its page, and if that could not be made, why; the published surfaces have none."""
    settings, sfm = work.settings.surface, work.settings.sfm
    if settings.method != "developable":
        return sheet, None
    reference = state.region.reference
    try:
        scatter = page_scatter(
            sheet, surface, points, observed, cameras, reference, settings, sfm.seed, sfm.threads, watch
        )
    except StepFailed as error:
        return sheet, str(error)
    return (sheet if scatter is None else replace(sheet, bound=page_bound(scatter))), None


def points_to_fit(
    state: Found, work: Work, figures: dict[str, Any], watch: Watch = SILENT
) -> tuple[tuple[Camera, ...], Array, Array]:
    """Cameras, the points (N, 3) that the surface is fitted to, and where the photos show these (N, C, 2).

    The points are measured on the print of a first surface. Its settings are always the same, so drawn creases do not
    require another measurement. The published methods use the points of structure from motion, as published.
    """
    model, region, polygon = state.model, state.region, state.region.outline.polygon
    on_sheet = model.select(region.on_sheet)
    sparse, observed = on_sheet.points, on_sheet.observations()
    if work.settings.surface.method != "developable":
        return model.cameras, sparse, observed
    pixels = PhotoPixels(work.photos, model)
    seed, threads = work.settings.sfm.seed, work.settings.sfm.threads
    key = key_with_photos(pixels, model, digest_of(region.on_sheet, polygon), region.reference, seed)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        surface = reconstruct_with_creases(
            sparse, state.reference, polygon, _FIRST_SURFACE, seed=seed, threads=threads, watch=watch.part(0, 0.4)
        )
        first = build_sheet(surface, polygon, list(surface.creases))
        measured = measure_points(
            model,
            region.on_sheet,
            first,
            region.reference,
            pixels.__getitem__,
            threads,
            watch.part(0.4, 1),
        )
        if measured is None:
            arrays = {"points": sparse, "observed": observed, **camera_arrays(model.cameras)}
            return arrays, {"tracks": 0, "track_scatter_pixels": None}
        arrays = {"points": measured.points, "observed": measured.observed, **camera_arrays(measured.cameras)}
        return arrays, {"tracks": measured.tracks, "track_scatter_pixels": measured.scatter}

    arrays, measured = kept(work.folder, "tracks", key, compute, work.report.warn)
    figures |= measured
    return cameras_from_arrays(arrays), arrays["points"], arrays["observed"]
