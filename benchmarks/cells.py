"""Methods on one photo set: each recovers the page, which is scored."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal
from unittest import mock

import cv2
import numpy as np

from ..core.camera import Camera
from ..core.flat.distortion import fit_affine, flipped_triangles, measure_strain
from ..core.page.warp import native_size
from ..core.sheet import FlatMap, Sheet
from ..core.sparse_model import SparseModel
from ..origami_addon import steps
from ..origami_addon.files.image_files import to_eight_bits
from ..origami_addon.files.photo_pixels import PhotoPixels
from ..origami_addon.files.photos import Photo, gather
from ..origami_addon.report import Report
from ..origami_addon.settings import PageSettings, RunSettings
from ..origami_addon.state import Found, LaidOut, Region, Surfaced, Unwrapped, extended
from ..origami_addon.steps import surface, unwrap
from . import blender_unwrap, page_dewarp, page_error
from .clock import Clock
from .methods import DEFAULT, Method
from .metrics import Image
from .photo_set import PhotoSet, read_image
from .scorer import Scorer
from .tables import Row
from .truth import Truth, score_surface

Turn = Literal["auto", "0", "90", "180", "270"]
# Photos besides the reference that page-dewarp may try; it takes minutes to fail on one.
_MORE_PHOTOS = 2
# Of a report's figures.
_SHOWN = ("stiffness", "creases", "tracks", "stretch_median", "stretch_95th_percentile", "flipped_triangles")


@dataclass(frozen=True)
class Placed:
    """A photo set with placed photos and the sheet found, which all methods share."""

    photos: list[Photo]
    model: SparseModel
    region: Region

    @classmethod
    def of(cls, photo_set: PhotoSet, work: Path) -> Placed:
        report = Report({})
        photos, _ = gather([photo_set.photos])
        shared = steps.Work(photos, work, RunSettings(), report)
        model = steps.place_photos(shared)
        return cls(photos, model, steps.find_sheet(model, shared))


class Cells:
    """Runs and scores methods on one photo set.

    Parameters
    ----------
    photo_set : PhotoSet
    placed : Placed
    work : Path
        An empty folder in which the steps keep their results.
    pages : Path
        Folder for the page images.
    scorer : Scorer

    Attributes
    ----------
    errors : dict
        Of the pages of a rendered set, by the methods' names.
    """

    def __init__(self, photo_set: PhotoSet, placed: Placed, work: Path, pages: Path, scorer: Scorer) -> None:
        self.photo_set, self.placed, self.work, self.pages, self.scorer = photo_set, placed, work, pages, scorer
        pages.mkdir(parents=True, exist_ok=True)
        self.errors: dict[str, page_error.PageError] = {}
        self._turn: Turn = "auto"
        self._clock = Clock()

    @cached_property
    def _truth(self) -> Truth:
        return Truth(self.photo_set.folder)

    def method(self, method: Method) -> Row:
        """One cell: surface, unwrapping, page, score."""
        return self._row(method.name, lambda report: self._recover(method, report), page=method is DEFAULT)

    def blender(self, method: blender_unwrap.Method) -> Row:
        """Blender's unwrapping of the default's surface."""

        def recover(report: Report) -> Unwrapped:
            surfaced = self._surface(DEFAULT, self._with(DEFAULT.settings(), report))
            sheet = surfaced.sheet
            with report.stage("unwrap") as figures:
                uv = blender_unwrap.unwrap(sheet, method)
            self._clock.charge("flat", report.stages[-1]["seconds"])
            strain = measure_strain(sheet.vertices, sheet.triangles, uv)
            figures["stretch_median"] = float(np.median(strain.stretch))
            figures["stretch_95th_percentile"] = float(np.percentile(strain.stretch, 95))
            figures["flipped_triangles"] = int(flipped_triangles(sheet.triangles, uv).sum())
            return extended(surfaced, Unwrapped, uv=uv)

        return self._row(f"default surface + Blender {method}", recover, page=False)

    def page_dewarp(self) -> Row:
        """The baseline from one photo: the reference, or otherwise the first of two more for which it makes a page."""
        row: Row = {"set": self.photo_set.name, "method": "page-dewarp, one photo"}
        photos = PhotoPixels(self.placed.photos, self.placed.model).photos
        reference = photos[self.placed.region.reference]
        try:
            others = [photo.path for photo in photos if photo is not reference]
            page = page_dewarp.dewarp_any([reference.path, *others[:_MORE_PHOTOS]], self.pages)
            return (
                row | {"photo": page.name} | page_figures(self.scorer.page(self.photo_set.original, read_image(page)))
            )
        except Exception as why:  # a baseline that fails is a result
            return row | failure(why)

    def _row(self, name: str, recover: Callable[[Report], Unwrapped], *, page: bool) -> Row:
        row: Row = {"set": self.photo_set.name, "method": name}
        report = Report({})
        try:
            state = self._lay_out(recover(report), report)
            if self.photo_set.is_rendered:
                row |= self._exact_figures(name, state)
            if page or not self.photo_set.is_rendered:
                row |= page_figures(self.scorer.page(self.photo_set.original, self._page(name, state, report)))
        except Exception as why:  # a method that fails is a result
            row |= failure(why)
        for stage in report.stages:
            row |= {key: value for key, value in stage["figures"].items() if key in _SHOWN}
        return row | self._clock.take()

    def _with(self, settings: RunSettings, report: Report, work: Path | None = None) -> steps.Work:
        return steps.Work(self.placed.photos, work or self.work, settings, report)

    def _surface(self, method: Method, with_method: steps.Work) -> Surfaced:
        found = Found(self.placed.model, self.placed.region)
        with self._in_force(method):
            cameras, sheet = steps.build_surface(found, with_method)
        return extended(found, Surfaced, cameras=cameras, sheet=sheet)

    def _recover(self, method: Method, report: Report) -> Unwrapped:
        with_method = self._with(method.settings(), report, self._folder(method))
        surfaced = self._surface(method, with_method)
        with self._in_force(method):
            uv = steps.unwrap_sheet(surfaced.sheet, with_method)
        return extended(surfaced, Unwrapped, uv=uv)

    @contextmanager
    def _in_force(self, method: Method) -> Iterator[None]:
        with method.in_force(), ExitStack() as timed:
            for step in (surface, unwrap):
                timed.enter_context(mock.patch.object(step, "kept", self._clock.kept))
            yield

    def _folder(self, method: Method) -> Path:
        """Results do not say which swaps they were computed with, so swaps have a folder of their own."""
        if not method.swaps:
            return self.work
        folder = self.work / method.name
        for name in method.shared:
            for file in self.work.glob(f"{name}-*.npz"):
                self._clock.share(file, folder)
        return folder

    def _lay_out(self, state: Unwrapped, report: Report) -> LaidOut:
        """The direction of the text is found once, on the first method's page."""
        settings = replace(RunSettings(), page=PageSettings(turn=self._turn))
        flat = steps.lay_out_page(state, self._with(settings, report))
        if self._turn == "auto":
            self._turn = _turn_between(state.sheet_reference, state.sheet, flat)
        return extended(state, LaidOut, flat=flat)

    def _page(self, name: str, state: LaidOut, report: Report) -> Image:
        page = steps.make_page(state, self._with(RunSettings(), report))
        image = np.ascontiguousarray(to_eight_bits(page.texture.image)[..., ::-1])
        file_name = "".join(letter if letter.isalnum() else "_" for letter in name)
        cv2.imwrite(str(self.pages / f"{file_name}.jpg"), image)
        return image

    def _exact_figures(self, name: str, state: LaidOut) -> Row:
        """Of the page as it comes from the reference photo alone, one of every few pixels."""
        reference = state.sheet_reference
        per_unit = native_size(state.sheet, state.flat, reference) / page_error.STEP
        size = max(round(state.flat.width * per_unit), 1), max(round(state.flat.height * per_unit), 1)
        source = page_error.source_in_reference(state.sheet, state.flat, reference, size)
        error = self.errors[name] = page_error.measure(self._truth, source)
        names = [camera.name for camera in state.cameras]
        centres = np.stack([camera.center for camera in state.cameras])
        return error.figures() | score_surface(self._truth, state.sheet.vertices, names, centres)


def _turn_between(camera: Camera, sheet: Sheet, flat: FlatMap) -> Turn:
    """The setting that turns another flat map of the same photo like this one."""
    across, down = -fit_affine(flat.uv, camera.project(sheet.vertices))[:, 1]
    turns: tuple[Turn, ...] = ("0", "90", "180", "270")
    return turns[round(np.degrees(np.arctan2(-across, -down)) / 90) % 4]


def page_figures(score: Row) -> Row:
    """The figures of a page's score that the tables show, in one level."""
    rules = score["rules"]
    return {
        "G": score["G"],
        "anisotropy": score["anisotropy"],
        "matches": score["matches"],
        "turned_degrees": score["turned_degrees"],
        "coverage": score["coverage"],
        "print_share": score["print_share"],
        "mean": score["dense"]["mean"],
        "median": score["dense"]["median"],
        "p95": score["dense"]["p95"],
        "bins": score["dense"]["bins"],
        "sift_mean": score["sift"]["mean"],
        "similarity_mean": score["similarity"]["mean"],
        "rules": rules["lines"],
        "rules_rms": rules["rms"] if rules["lines"] else None,
        "rules_worst": rules["worst"] if rules["lines"] else None,
    }


def failure(why: Exception) -> Row:
    """A failed cell; the place in the code goes into the json."""
    return {"failure": f"{type(why).__name__}: {why}", "traceback": traceback.format_exc()}
