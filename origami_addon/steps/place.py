"""Place the photos: where each was taken."""

from __future__ import annotations

from pathlib import Path

from ...core.sparse_model import SparseModel
from ...core.watch import SILENT, Watch
from ..sfm import client
from ..sfm.colmap_model import load_model
from ..stages import about
from .work import Work


def place_photos(work: Work, watch: Watch = SILENT) -> SparseModel:
    """Where the photos were taken, by structure from motion or from the COLMAP model that the settings name.

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos
    """
    folder, settings = work.folder / "sfm", work.settings
    with work.report.stage(about("place").reported) as figures:
        if settings.colmap_model is None:
            result = client.place_photos(work.photos, folder, settings.sfm, watch)
        else:
            result = load_model(Path(settings.colmap_model), work.photos, folder, watch)
        figures |= result.figures
        work.report.warn(*result.warnings)
        return result.model
