"""The catalogue of all files that Origami writes, in a whole run or by an export from the window.

The guard of a run's folder and the manual's tables read it too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import bpy

from ...core.errors import StepFailed
from ...core.sheet import FlatMap, Sheet
from ...core.watch import Watch
from ..files.image_files import write_jpeg, write_png, write_tiff
from ..files.pdf import write_pdf
from ..report import Report
from ..scene.bake import bake_page
from ..scene.document_frame import document_frame
from ..scene.paper_material import paper_material
from ..scene.save import save_document
from ..scene.shape_keys import put_unfolding
from ..scene.sheet_mesh import PAGE_UV, sheet_to_object
from ..scene.unfolding import unfolding
from .fold_file import write_fold
from .models import without_usd, write_glb, write_map, write_obj, write_sheet, write_usd
from .outline_files import write_creases, write_outline, write_outline_picture
from .output import ARRAYS, BAKE, DOCUMENT, OUTLINE, PAGE, PARTS, RELIEF, Figures, Finished, Output
from .relief_files import write_displacement_map, write_normal_map
from .svg_files import write_crease_svg, write_uv_layout


def _of_sheet(write: Callable[[Path, Sheet, FlatMap], None]) -> Callable[[Path, Finished], None]:
    return lambda path, done: write(path, done.state.sheet, done.state.flat)


def _of_object(write: Callable[[Path, bpy.types.Object], None]) -> Callable[[Path, Finished], None]:
    return lambda path, done: write(path, done.in_blender())


def _document(path: Path, done: Finished) -> None:
    done.in_blender()
    save_document(path, done.home)


def _baked(path: Path, done: Finished) -> Figures:
    page = done.state.page
    height, width = page.image.shape[:2]
    write_tiff(path, bake_page(done.in_blender(), done.photo(), (width, height)), page.dpi, done.profile)
    return {"width_px": width, "height_px": height}


def _name(done: Finished) -> str:
    return done.state.reference.name


PICTURE = "page.jpg"
OUTPUTS = (
    Output(
        "page.tif",
        "the page to keep: lossless, with its resolution and the photo's colour profile",
        PAGE,
        lambda path, done: write_tiff(path, done.state.page.image, done.state.page.dpi, done.profile, bits=done.bits),
        label="TIFF",
        kind="tiff",
    ),
    Output(
        "page.png",
        "the page, lossless and smaller, with its resolution and the photo's colour profile",
        PAGE,
        lambda path, done: write_png(path, done.state.page.image, done.state.page.dpi, done.profile, bits=done.bits),
        label="PNG",
        kind="png",
        in_run=False,
    ),
    Output(
        PICTURE,
        "the page to send, 8 bits per colour",
        PAGE,
        lambda path, done: write_jpeg(path, done.state.page.image, done.state.page.dpi, done.profile),
        label="JPEG",
        kind="jpeg",
    ),
    Output(
        "page.pdf",
        "the page to print or to send, in its true size: a JPEG in a PDF, or lossless if it is black and white",
        PAGE,
        lambda path, done: write_pdf(
            path, done.state.page.image, done.state.page.dpi, done.size_mm, done.title, done.profile
        ),
        label="PDF",
        kind="pdf",
    ),
    Output(
        "page_baked.tif",
        "with `--bake`: the page as Blender bakes it from the mesh and its UV maps",
        BAKE,
        _baked,
        asked_for=lambda settings: settings.image.bake,
    ),
    Output(
        "document.blend",
        "a collection with the cameras and their photos, the sparse points and the sheet (vertex groups `ridge` and "
        "`boundary`, UV maps `page` and `photo`, attributes for stretch)",
        DOCUMENT,
        _document,
        beside=(PICTURE,),
    ),
    Output(
        "sheet.glb",
        "the sheet with its page on it, folded, and an animation in which it opens, in one file",
        DOCUMENT,
        _of_object(write_glb),
        label="glTF",
        kind="gltf",
    ),
    Output(
        "sheet.obj",
        "the sheet with its UV map and material; page.jpg beside it is its page",
        DOCUMENT,
        _of_object(write_obj),
        label="OBJ",
        kind="obj",
        also=("sheet.mtl",),
        beside=(PICTURE,),
    ),
    Output(
        "sheet.usdz",
        "the sheet with its page on it, in one file",
        DOCUMENT,
        _of_object(write_usd),
        label="USD",
        kind="usd",
        why_not=without_usd,
    ),
    Output(
        "normal_map.png",
        "for a plane with the page on it: where the paper faces, in tangent space with y up (OpenGL), 16 bits; not a "
        "colour",
        RELIEF,
        lambda path, done: write_normal_map(path, done.relief),
        label="Normal Map",
        kind="normal_map",
    ),
    Output(
        "displacement_map.exr",
        "for the same plane: the height of its relief in page heights (Midlevel 0; Scale is the height of the plane), "
        "32 bits",
        RELIEF,
        lambda path, done: write_displacement_map(path, done.relief),
        label="Displacement Map",
        kind="displacement_map",
    ),
    Output(
        "uv_layout.svg",
        "the flat mesh with creases and edge, in millimetres if the paper's size is known",
        ARRAYS,
        _of_sheet(write_uv_layout),
        label="UV Layout",
        kind="uv_svg",
    ),
    Output(
        "crease_pattern.svg",
        "the creases as straight lines on the page, in true size: mountains red, valleys blue, as seen from the "
        "printed side",
        ARRAYS,
        _of_sheet(write_crease_svg),
        label="Crease Pattern",
        kind="crease_svg",
    ),
    Output(
        "crease_pattern.fold",
        "the crease pattern for origami programs: with fold angles and faces, and folded as photographed",
        ARRAYS,
        _of_sheet(write_fold),
        label="FOLD",
        kind="fold",
    ),
    Output(
        "sheet.npz",
        "mesh, UV map and cameras as NumPy arrays: xyz and cam_centers in the frame of the structure from motion, uv "
        "and uv_bound, how exact it is, in mm (in page heights if the paper's size is unknown), cam_names, and what "
        "projects xyz into each photo: "
        "cam_rotations, cam_translations (world to camera: x right, y down, z forward), cam_focal_lengths, "
        "cam_principal_points, cam_distortions (k1, k2) and cam_sizes in pixels",
        ARRAYS,
        lambda path, done: write_sheet(path, done.state.sheet, done.state.flat, done.state.cameras),
        label="Arrays",
        kind="sheet",
    ),
    Output(
        "map.npz",
        "which place in which photo each pixel of the page comes from, and back: transfers marks from one to the "
        "other; its entry readme explains it",
        ARRAYS,
        lambda path, done: write_map(
            path, done.state.page.texture, done.state.sheet, done.state.flat, done.state.cameras
        ),
        label="Map",
        kind="map",
    ),
    Output(
        "outline.json",
        "the paper's edge in the reference photo; edit it and pass it to `--outline`",
        OUTLINE,
        lambda path, done: write_outline(path, _name(done), done.state.region.outline.polygon),
        editable=True,
    ),
    Output(
        "creases.json",
        "the creases in the reference photo; edit them and pass them to `--creases`",
        OUTLINE,
        lambda path, done: write_creases(path, _name(done), done.creases),
        editable=True,
    ),
    Output(
        "outline.jpg",
        "the reference photo with the paper's edge in orange and the creases in blue",
        OUTLINE,
        lambda path, done: write_outline_picture(
            path, done.photo(), done.state.region.outline.polygon, done.creases, done.profile
        ),
    ),
)
# The folder of the pages of other photos, and the endings of their files; each is written as that of the page itself.
OTHER_LIGHT = "other_light"
OTHER_PAGE_FILES = {".tif": "page.tif", ".jpg": PICTURE, ".npz": "map.npz"}
# The files that a run writes of the page itself.
PAGE_FILES = [each for each in OUTPUTS if each.in_run and each.part == PAGE]
# The files that the window exports, by their names for scripts.
KINDS = {each.kind: each for each in OUTPUTS if each.kind}


def chosen(kinds: Iterable[str]) -> list[Output]:
    """The files of these kinds, and the files that they refer to."""
    beside = {name for kind in kinds for name in KINDS[kind].beside}
    return [each for each in OUTPUTS if each.kind in kinds or each.name in beside]


def names_of(outputs: Iterable[Output]) -> list[str]:
    """The names of files, including the further files of their writers."""
    return [name for each in outputs for name in (each.name, *each.also)]


def write_outputs(outputs: Iterable[Output], out: Path, done: Finished, report: Report, watch: Watch) -> None:
    """Write files into a folder; skip with a warning what this Blender cannot write.

    Raises
    ------
    StepFailed
        If a file cannot be written, or this Blender can write none of them.
    """
    possible = [each for each in outputs if not each.why_not()]
    reasons = [each.why_not() for each in outputs if each.why_not()]
    if not possible:
        raise StepFailed(" ".join(reasons))
    report.warn(*reasons)
    parts = [part for part in PARTS if any(each.part == part for each in possible)]
    for number, part in enumerate(parts):
        watch.step(number / len(parts), PARTS[part])
        with report.stage(part) as figures:
            for each in possible:
                if each.part == part:
                    figures |= each.write(out / each.name, done) or {}


def write_other_page(folder: Path, name: str, done: Finished) -> None:
    """Write a page of other photos into a folder, which is made if it is missing.

    Raises
    ------
    StepFailed
    """
    folder.mkdir(exist_ok=True)
    as_page = {each.name: each for each in OUTPUTS}
    for ending, output in OTHER_PAGE_FILES.items():
        as_page[output].write(folder / f"{name}{ending}", done)


def sheet_with_page(done: Finished, folder: Path) -> bpy.types.Object:
    """The sheet as an object without a document; the folder gets the picture of its page."""
    picture = folder / PICTURE
    write_jpeg(picture, done.state.page.image, done.state.page.dpi, done.profile)
    state = done.state
    frame = document_frame(state.sheet, state.flat)
    sheet_object = sheet_to_object("sheet", state.sheet, state.flat, state.sheet_reference, frame)
    put_unfolding(sheet_object, unfolding(state.sheet, state.flat))
    sheet_object.data.materials.append(paper_material("page", bpy.data.images.load(str(picture)), PAGE_UV))
    return sheet_object
