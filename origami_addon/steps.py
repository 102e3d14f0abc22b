"""The steps from photos to the flat page, in order: one function each, which whole runs and operators share.

Slow results are kept in the work folder, so that a second run with another resolution, for example, does not compute
the surface again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import Array
from ..core.camera import Camera
from ..core.checks.open_book import is_open_book
from ..core.checks.page_bound import page_bound, page_within
from ..core.creases.crease_ends import cut_to_outline
from ..core.creases.creases import crease_figures
from ..core.errors import StepFailed, UnusablePhotos, UsageError
from ..core.flat.distortion import flipped_triangles, measure_strain
from ..core.flat.flatten import flatten
from ..core.flat.pins import Pins
from ..core.fusion.fusion import fuse_page
from ..core.light.black_and_white import find_ink
from ..core.light.greyscale import greyscale
from ..core.light.looks import Relit, relit
from ..core.light.paper_figures import measure_paper
from ..core.numeric.image import Image
from ..core.page.page import ASPECT_TOLERANCE, PaperSize, lay_out
from ..core.page.render import render_page
from ..core.page.sampling import measure_sampling
from ..core.page.texture import PageTexture
from ..core.page.upright_page import lay_out_upright, up_after, up_of_exif
from ..core.page.warp import native_size
from ..core.paper.outline import Outline
from ..core.paper.reference_outline import find_reference_outline, given_outline
from ..core.paper.sheet_choice import choose_sheet
from ..core.paper.sheet_points import points_on_sheet
from ..core.paper.sheet_search import FoundSheet, find_sheets
from ..core.sheet import FlatMap, Sheet, sheet_arrays, sheet_from_arrays
from ..core.sparse_model import SparseModel, camera_arrays, cameras_from_arrays
from ..core.surface.creased_surface import reconstruct_with_creases
from ..core.surface.depth_grid import ViewFrame
from ..core.surface.mesh import build_sheet
from ..core.surface.surface import Surface, SurfaceSettings
from ..core.tracks.measured_points import measure_points
from ..core.watch import SILENT, Watch
from .export.outputs import OUTPUTS, PICTURE, Finished, sheet_with_page, write_outputs
from .feasibility import check_page_bytes, check_reference
from .files.icc import luminance_shares
from .files.image_files import Bits, PageImage
from .files.kept import Arrays, digest_of, kept, kept_as, key_of
from .files.photo_pixels import JudgedPixels, PhotoPixels, ReducedPhotos
from .files.photos import Photo
from .files.results_folder import real
from .one_line import printable
from .paper_size import MILLIMETRES_PER_INCH
from .report import ROOT, Report, hash_of
from .scene.camera_object import VIEWS, write_views
from .scene.document import Document
from .scene.document_group import fill_group
from .scene.show import SHEET, Pictures, build_document
from .settings import LONGEST_PAGE_SIDE, Colour, RunSettings
from .sfm.client import place_photos
from .sfm.colmap_model import load_model
from .stages import HALF_WITHIN, WITHIN, about
from .state import (
    Found,
    LaidOut,
    Page,
    Paged,
    Region,
    Surfaced,
    Unwrapped,
    edge_arrays,
    edges_from_arrays,
    sheets_arrays,
    sheets_from_arrays,
)

# The sources outside the core on which kept results depend.
_COMPUTING = (
    *("files/photos.py", "files/photo_pixels.py", "files/heif_pixels.py", "files/movie_frames.py", "steps.py"),
    *("other_light.py", "sfm/page_client.py"),
)
# The resolution in the files, dots per inch, if the true one is unknown because the paper's size is.
_ASSUMED_DPI = 300.0
# The figures of a fusion; a page of the reference photo alone has none.
_HEALING = ("burnt_share", "healed_share")
# Above this share of the page, a warning says how much of it is blank.
_BLANK_WARNING = 0.01
# Share of the page that is burnt out in all photos, above which a warning says so: a square centimetre of A4.
_BURNT_WARNING = 0.002
_NO_BLANK_PAPER = (
    "The page stays in the light of the photos, because it has too little blank paper to know its light by; choose "
    "that light (--light as-photographed, or As Photographed in Blender) and this warning is gone."
)
_OPEN_BOOK = (
    "The sheet bends like an open book, so both pages were probably taken for one sheet; for a single page, give its "
    "outline (--outline, or Edit Outline in Blender)."
)
# The kept images, as `kept` names them.
PAGE_IMAGE, OTHER_IMAGE = "page", "other_light"
# The surface on which the print is followed may be off by a hundredth of the page.
_FIRST_SURFACE = SurfaceSettings(grid_rows=50)


@dataclass(frozen=True)
class Work:
    """What the steps work with.

    Attributes
    ----------
    photos : sequence of Photo
    folder : Path
        Holds the slow results that are kept.
    settings : RunSettings
    report : Report
    images : set of str
        The kept images that the steps have used so far (see `kept_as`), which include the largest files in the folder.
    """

    photos: Sequence[Photo]
    folder: Path
    settings: RunSettings
    report: Report
    images: set[str] = field(default_factory=set)


def place(work: Work, watch: Watch = SILENT) -> SparseModel:
    """Where the photos were taken, by structure from motion or from the COLMAP model that the settings name.

    Raises
    ------
    Cancelled, StepFailed, UnusablePhotos
    """
    folder, settings = work.folder / "sfm", work.settings
    with work.report.stage(about("place").reported) as figures:
        if settings.colmap_model is None:
            result = place_photos(work.photos, folder, settings.sfm, watch)
        else:
            result = load_model(Path(settings.colmap_model), work.photos, folder, watch)
        figures |= result.figures
        work.report.warn(*result.warnings)
        return result.model


def find_sheet(
    model: SparseModel,
    work: Work,
    watch: Watch = SILENT,
    *,
    one_of_all: bool = False,
    other: int = 0,
    without: Sequence[str] = (),
) -> Region:
    """Choose the reference photo, find the paper in it, and the points that lie on the paper.

    With ``one_of_all``, the other sheets in view get a page too, so no warning mentions them. ``other`` is 0 for the
    sheet in the settings, n for the n-th likeliest region outside the sheets in view. Photos named in ``without`` are
    not chosen as the reference.

    Raises
    ------
    UsageError
        If the settings name a reference photo that is not there, or an outline or creases that do not lie in it.
    UnusablePhotos
        If the reference photo that the settings name could not be placed.
    StepFailed
        If no sheet is found, or there is no such other region.
    """
    pixels, settings, report = PhotoPixels(work.photos, model), work.settings, work.report
    asked = settings.reference, settings.sheet, settings.outline, other, list(without)
    key = _key_with_photos(pixels, model, *asked)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        named = check_reference(work.photos, settings)
        reference = None if named is None else _index_of(named, model)
        if settings.outline is None:
            small = ReducedPhotos(pixels)
            sheets = _sheets_in_view(pixels, small, model, work, watch.part(0, 0.6))
            in_view = [sheet.outline for sheet in sheets]
            assert settings.sheet != "all"
            sheet = choose_sheet(model, small, sheets, settings.sheet, other)
            barred = {index for index, camera in enumerate(model.cameras) if camera.name in without}
            found = find_reference_outline(
                model,
                pixels,
                small,
                sheet,
                reference=reference,
                without=barred,
                threads=settings.sfm.threads,
                watch=watch.part(0.6, 1),
            )
            reference, outline = found.reference, found.outline
            search = {
                "sheet_probability": sheet.probability,
                "hypotheses_agreement": sheet.agreement,
                "outlines_tried": {model.cameras[index].name: sure for index, sure in found.tried.items()},
                "sheets_in_view": len(sheets),
            }
        else:
            assert reference is not None
            in_view, search = [], {}
            outline = given_outline(np.array(settings.outline))
        watch.step(0.9, "Separating the sheet's points from the table's")
        arrays = {"polygon": outline.polygon, "on_sheet": points_on_sheet(model, reference, outline)}
        arrays |= edge_arrays(in_view)
        notes = {"reference": reference, "confidence": outline.confidence, "notes": outline.notes, "search": search}
        return arrays, notes

    with report.stage(about("find").reported) as figures:
        arrays, notes = kept(work.folder, "region", key, compute, work.report.warn)
        outline = Outline(arrays["polygon"], notes["confidence"], tuple(notes["notes"]))
        name = model.cameras[notes["reference"]].name
        figures |= {
            "reference": name,
            "outline_confidence": outline.confidence,
            "points_on_sheet": int(arrays["on_sheet"].sum()),
        }
        figures |= notes["search"]
        report.warn(*outline.notes)
        in_view = edges_from_arrays(arrays)
        if settings.sheet == 1 and len(in_view) > 1 and not one_of_all:
            report.warn(_others(len(in_view)))
        return Region(notes["reference"], outline, arrays["on_sheet"], in_view)


def sheets_in_view(model: SparseModel, work: Work, watch: Watch = SILENT) -> tuple[FoundSheet, ...]:
    """All sheets in view, in the order of their numbers.

    Raises
    ------
    StepFailed
    UnusablePhotos
        If a placed photo is gone or has another size.
    """
    pixels = PhotoPixels(work.photos, model)
    return _sheets_in_view(pixels, ReducedPhotos(pixels), model, work, watch)


def _sheets_in_view(
    pixels: PhotoPixels, small: ReducedPhotos, model: SparseModel, work: Work, watch: Watch
) -> tuple[FoundSheet, ...]:
    key = _key_with_photos(pixels, model)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        watch.step(0, "Looking for the sheet in all photos")
        found = find_sheets(model, list(small))
        return sheets_arrays(found), {}

    arrays, _ = kept(work.folder, "sheets", key, compute, work.report.warn)
    return sheets_from_arrays(arrays)


def _others(sheets: int) -> str:
    numbers = "2" if sheets == 2 else f"2 to {sheets}"
    return (
        f"{sheets} sheets are in view; the one in the middle that most photos show was taken. Choose another by its "
        f"number, {numbers} (--sheet, or Sheet in Blender)."
    )


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
        cameras, points, observed = _points_to_fit(state, work, figures, watch.part(0, 0.6))
        reference = cameras[state.region.reference]
        digest = digest_of(points, observed, *(array for camera in cameras for array in _pose(camera)), polygon)
        key = key_of(code(), digest, asdict(settings.surface), settings.sfm.seed, settings.creases)
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
                watch=watch.part(0.6, 0.9),
            )
            edge = surface.grid.frame.from_pixels(polygon)
            sheet = build_sheet(surface, polygon, list(surface.creases))
            sheet, unknown = _with_bound(sheet, surface, points, observed, cameras, state, work, watch.part(0.9, 1))
            notes = {
                "grid_nodes": surface.grid.size,
                "noise_page_lengths": surface.noise,
                "residual_median_page_lengths": float(np.median(np.abs(surface.residuals))),
                "stiffness": surface.stiffness,
                "creases": len(surface.creases),
                "crease_confidence": list(surface.confidence),
                "fold_angles_degrees": [crease.fold_angle for crease in crease_figures(sheet)],
                "creases_given": None if given is None else len(given),
                "creases_off_the_paper": [] if given is None else _off_the_paper(given, surface.grid.frame, edge),
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
        bound = page_bound(sheet, surface, points, observed, cameras, reference, settings, sfm.seed, sfm.threads, watch)
    except StepFailed as error:
        return sheet, str(error)
    return replace(sheet, bound=bound), None


def _points_to_fit(
    state: Found, work: Work, figures: dict[str, Any], watch: Watch
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
    key = _key_with_photos(pixels, model, digest_of(region.on_sheet, polygon), region.reference, seed)

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


def _off_the_paper(creases: Array, frame: ViewFrame, edge: Array) -> list[int]:
    """Which of the creases (K, 2, 2), in pixels, have no part inside the paper's edge."""
    return [number for number, ends in enumerate(creases) if not cut_to_outline(frame.from_pixels(ends), edge)]


def flatten_sheet(sheet: Sheet, work: Work, watch: Watch = SILENT, pins: Pins | None = None) -> Array:
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
                f"{flipped} of {len(sheet.triangles)} triangles of the flat sheet lie upside down, the page is wrong "
                "there; try a conformal method (--unwrap conformal_l1 or lscm, or Method in Blender)."
            )
        return uv


def lay_out_page(state: Unwrapped, work: Work, watch: Watch = SILENT) -> FlatMap:
    """The page: straight, upright, and in true size if the paper's size is known."""
    sheet, uv, reference, settings = state.sheet, state.uv, state.sheet_reference, work.settings.page
    size = settings.paper_size_mm
    paper = None if size is None else PaperSize(*size)
    with work.report.stage(about("lay_out").reported) as figures:
        if settings.turn != "auto":
            flat = lay_out(sheet, uv, reference, up_after(int(settings.turn)), paper)
        else:
            flat = _upright(state, work, paper, figures, watch)
        figures |= {"width": flat.width, "height": flat.height, "unit": flat.unit} | _accuracy(sheet, flat)
        if is_open_book(sheet, flat.uv):
            work.report.warn(_OPEN_BOOK)
        _compare_aspect(flat, paper, work.report)
        return flat


def _accuracy(sheet: Sheet, flat: FlatMap) -> dict[str, float | None]:
    """How far half of the page, and nine tenths of it, are at most from their place, in the page's unit."""
    half, most = page_within(sheet, flat, (0.5, 0.9)) or (None, None)
    return {HALF_WITHIN: half, WITHIN: most}


def _upright(state: Unwrapped, work: Work, paper: PaperSize | None, figures: dict[str, Any], watch: Watch) -> FlatMap:
    """The page, turned so that its text stands upright."""
    sheet, uv = state.sheet, state.uv
    pixels, index = PhotoPixels(work.photos, state.model), state.region.reference
    size = None if paper is None else astuple(paper)
    key = _key_with_photos(pixels, state.model, _digest_of_flat(state, uv), index, size)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        up = up_of_exif(pixels.photos[index].orientation)
        page = lay_out_upright(sheet, uv, state.cameras, pixels.__getitem__, index, up, paper, watch)
        flat = asdict(page.flat)
        text = {"quarter_turns_by_text": page.quarter_turns, "text_confidence": page.confidence}
        return {"uv": flat.pop("uv")}, {"flat": flat, "text": text}

    arrays, notes = kept(work.folder, "upright", key, compute, work.report.warn)
    figures |= notes["text"]
    return FlatMap(arrays["uv"], **notes["flat"])


def render(state: LaidOut, work: Work, watch: Watch = SILENT) -> Page:
    """The page image.

    Raises
    ------
    UsageError
        If the page would have too many pixels.
    """
    cameras, region, sheet, flat = state.cameras, state.region, state.sheet, state.flat
    settings, report = work.settings.image, work.report
    with report.stage(about("page").reported) as figures:
        dpi, per_unit = settings.dpi, native_size(sheet, flat, cameras[region.reference])
        known = flat.unit == "mm"
        if known:
            # By default a whole number, which all kinds of files can state: JPEG has no others.
            dpi = dpi or max(round(per_unit * MILLIMETRES_PER_INCH), 1)
            per_unit = dpi / MILLIMETRES_PER_INCH
        size = (max(round(flat.width * per_unit), 1), max(round(flat.height * per_unit), 1))
        if max(size) > LONGEST_PAGE_SIDE:
            raise UsageError(
                f"At {settings.dpi:g} dpi the page would be {size[0]} x {size[1]} pixels; choose fewer, at most "
                f"{settings.dpi * LONGEST_PAGE_SIDE / max(size):.0f}."
                if settings.dpi
                else f"The page would be {size[0]} x {size[1]} pixels; choose another reference photo, or a resolution "
                "(--dpi, or Resolution in Blender)."
            )
        pixels = PhotoPixels(work.photos, state.model)
        check_page_bytes(*size, [pixels.photos[region.reference]])
        texture, healing = as_photographed(state, work, pixels, size, watch.part(0, 0.9))
        watch.step(0.9, "Taking the light off the page")
        page = relit(texture.image, texture.photo >= 0, sheet, flat, settings.light)
        profile = pixels.photos[region.reference].icc_profile
        texture = replace(texture, image=page.image)
        image = _in_colors(page.image, settings.colour, profile)
        if settings.light != "as-photographed" and page.paper is None:
            report.warn(_NO_BLANK_PAPER)
        burnt_share = healing["burnt_share"]
        if burnt_share is not None and burnt_share > _BURNT_WARNING:
            report.warn(
                f"{100 * burnt_share:.1f} % of the page is burnt out in every photo that shows it: any print there is "
                "lost; photograph it again, with the lamp farther to the side or with less exposure."
            )
        names = [camera.name for camera in cameras]
        dpi = dpi or _ASSUMED_DPI
        used = np.unique(texture.photo[texture.photo >= 0])
        figures |= {
            "width_px": size[0],
            "height_px": size[1],
            "dpi": dpi,
            "dpi_source": "paper size" if known else "assumed",
            "photos_used": [names[index] for index in used],
            "photo_shares": {names[index]: float((texture.photo == index).mean()) for index in used},
            "blank_share": texture.blank_share,
            **healing,
            "paper_linear_rgb": None if page.paper is None else page.paper.tolist(),
            **_image_figures(texture, page, sheet, flat),
        }
        if texture.blank_share > _BLANK_WARNING:
            report.warn(
                f"{100 * texture.blank_share:.1f} % of the page stays white: it lies outside the outline that was "
                "found, or no photo used shows it; look at the outline (--outline, or Edit Outline in Blender), or try "
                "another reference photo."
            )
        return Page(texture, dpi, image)


def _in_colors(image: Image, colour: Colour, profile: bytes | None) -> PageImage:
    """The page (H, W, 3) as the setting asks: the same, grey (H, W), or black and white (H, W) with True for white."""
    if colour == "colour":
        return image
    grey = greyscale(image, luminance_shares(profile))
    return grey if colour == "grey" else ~find_ink(grey)


def as_photographed(
    state: LaidOut, work: Work, pixels: PhotoPixels, size: tuple[int, int], watch: Watch
) -> tuple[PageTexture, dict[str, float | None]]:
    """The page image in the photos' light, and the shares of it that are burnt out in every photo and healed by others.

    It is kept, so that another light does not blend the photos again.
    """
    sheet, flat, reference, source = state.sheet, state.flat, state.region.reference, work.settings.image.source
    key = _key_with_photos(pixels, state.model, _digest_of_flat(state, flat.uv), reference, size, source)

    def compute() -> tuple[Arrays, dict[str, Any]]:
        if source == "reference":
            texture = render_page(sheet, flat, state.cameras, pixels.__getitem__, reference, size)
            healing = dict.fromkeys(_HEALING)
        else:
            threads = work.settings.sfm.threads
            page = fuse_page(sheet, flat, state.cameras, pixels.__getitem__, reference, size, threads, watch)
            texture, healing = page.texture, {name: getattr(page, name) for name in _HEALING}
        arrays = {"image": texture.image, "photo": texture.photo, "position": texture.position}
        return arrays, {"blank_share": texture.blank_share, **healing}

    arrays, notes = kept_image(work, PAGE_IMAGE, key, compute)
    texture = PageTexture(arrays["image"], arrays["photo"], arrays["position"], notes["blank_share"])
    return texture, {name: notes[name] for name in _HEALING}


def kept_image(
    work: Work, name: str, key: str, compute: Callable[[], tuple[Arrays, dict[str, Any]]]
) -> tuple[Arrays, dict[str, Any]]:
    """The same as `kept`, and note the file as used."""
    work.images.add(kept_as(name, key))
    return kept(work.folder, name, key, compute, work.report.warn)


def _image_figures(texture: PageTexture, page: Relit, sheet: Sheet, flat: FlatMap) -> dict[str, Any]:
    """What an archive asks of a page image, as far as it can be measured without a target; null is unknown."""
    covered = texture.photo >= 0
    paper = None if page.blank is None else measure_paper(page.image, covered, page.blank)
    sampling = measure_sampling(texture, sheet, flat)
    return {
        "blank_paper_share": None if page.blank is None else float(page.blank.mean()),
        "paper_lab": None if paper is None else paper.color.tolist(),
        "paper_unevenness_lightness": None if paper is None else paper.unevenness,
        "paper_noise_lightness": None if paper is None else paper.noise,
        "photo_pixels_per_page_pixel": None if sampling is None else asdict(sampling),
    }


def finished(photos: Sequence[Photo], state: Paged, folder: Path, bits: Bits | None = None) -> Finished:
    """Everything that files are made from; models are made without a document, with their picture in ``folder``."""
    reference, pixels = state.region.reference, PhotoPixels(photos, state.model)
    return Finished(
        state,
        photo=lambda: pixels[reference],
        profile=pixels.photos[reference].icc_profile,
        bits=bits,
        make_object=lambda done: sheet_with_page(done, folder),
        home=folder,
        title=document_name(photos),
    )


def write_results(state: Paged, work: Work, out: Path, home: Path, watch: Watch = SILENT) -> None:
    """Write all files of a whole run, except its report, into ``out``, from where they will move to ``home``.

    Raises
    ------
    StepFailed
    """
    done = replace(
        finished(work.photos, state, home), make_object=lambda _: _document(state, work, out.resolve()).object(SHEET)
    )
    outputs = [each for each in OUTPUTS if each.in_run and each.asked_for(work.settings)]
    write_outputs(outputs, out, done, work.report, watch)


def _document(state: Paged, work: Work, folder: Path) -> Document:
    """Put the document into Blender, and its pictures into the folder that already has the page's."""
    pixels = JudgedPixels(work.photos, state.model)
    views = list(write_views(folder / VIEWS, state.model.cameras, pixels.__getitem__))
    pictures = Pictures(views, [photo.path.resolve() for photo in pixels.photos], pack=False)
    document = build_document(document_name(work.photos), state, pictures, folder / PICTURE)
    fill_group(document, work.photos, work.settings, work.report, pixels.sharpness)
    return document


def document_name(photos: Sequence[Photo]) -> str:
    """The name of the document of photos: that of the innermost folder with all of them."""
    folders = [real(photo.path).parent for photo in photos]
    outward = (folders[0], *folders[0].parents)
    shared = (each for each in outward if all(folder.is_relative_to(each) for folder in folders))
    return printable(next(shared, folders[0]).name) or "document"


def _index_of(photo: Photo, model: SparseModel) -> int:
    """Index of the photo's camera."""
    for index, camera in enumerate(model.cameras):
        if camera.name == photo.name:
            return index
    raise UnusablePhotos(f"The reference photo {photo.name} could not be placed; choose another one, or none.")


def _compare_aspect(flat: FlatMap, paper: PaperSize | None, report: Report) -> None:
    if paper is None or paper.height is None:
        return
    measured = max(flat.width, flat.height) / min(flat.width, flat.height)
    named = max(paper.width, paper.height) / min(paper.width, paper.height)
    if abs(measured / named - 1) > ASPECT_TOLERANCE:
        report.warn(
            f"The page came out as 1 : {measured:.3f} and the paper size that was named is 1 : {named:.3f}; "
            "check the size, or whether the whole sheet was found."
        )


def code_digest(root: Path) -> str:
    """A hash of the code that computes kept results; ``root`` is the folder of the extension."""
    addon = root / "origami_addon"
    return hash_of([*sorted((root / "core").rglob("*.py")), *(addon / name for name in _COMPUTING)])


@cache
def code() -> str:
    """The hash of this package's code."""
    return code_digest(ROOT)


def _pose(camera: Camera) -> list[Array]:
    return [np.asarray(value) for value in astuple(camera)[1:]]


def _digest_of_flat(state: Surfaced, uv: Array) -> str:
    """A text that changes with the sheet, its flat coordinates or the cameras."""
    poses = [array for camera in state.cameras for array in _pose(camera)]
    return digest_of(*sheet_arrays(state.sheet).values(), uv, *poses)


def _key_with_photos(pixels: PhotoPixels, model: SparseModel, *rest: Any) -> str:
    """The key of a result that depends on the photos' pixels, the sparse model and the ``rest``."""
    contents = [(photo.name, photo.sha256) for photo in pixels.photos]
    poses = [array for camera in model.cameras for array in _pose(camera)]
    observed = [model.observed_point, model.observed_camera, model.observed_pixel]
    return key_of(code(), contents, digest_of(model.points, *observed, *poses), *rest)
