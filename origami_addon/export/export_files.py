"""The files that a document can be taken elsewhere as, by kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...core.camera import Camera
from ...core.sheet import FlatMap, Sheet
from ...core.texture import PageTexture
from ...core.watch import Watch
from ..files.image_files import Bits, write_jpeg, write_png, write_tiff
from ..scene.document import document_frame
from ..scene.paper_material import paper_material
from ..scene.sheet_mesh import PAGE_UV, sheet_to_object
from .fold_file import write_fold
from .models import write_glb, write_map, write_obj, write_sheet, write_usd
from .svg_files import write_crease_svg, write_uv_layout


@dataclass(frozen=True)
class Finished:
    """All that the files are made of.

    Attributes
    ----------
    cameras : sequence of Camera
    reference : Camera
    sheet : Sheet
    flat : FlatMap
    texture : PageTexture
    dpi : float
    profile : bytes or None
        Colour profile of the page.
    bits : {8, 16} or None
        Of each colour in TIFF and PNG; None for as many as the photo has.
    """

    cameras: Sequence[Camera]
    reference: Camera
    sheet: Sheet
    flat: FlatMap
    texture: PageTexture
    dpi: float
    profile: bytes | None
    bits: Bits | None


def _tiff(path: Path, done: Finished) -> None:
    write_tiff(path, done.texture.image, done.dpi, done.profile, bits=done.bits)


def _png(path: Path, done: Finished) -> None:
    write_png(path, done.texture.image, done.dpi, done.profile, bits=done.bits)


def _jpeg(path: Path, done: Finished) -> None:
    write_jpeg(path, done.texture.image, done.dpi, done.profile)


def _sheet_npz(path: Path, done: Finished) -> None:
    write_sheet(path, done.sheet, done.flat, done.cameras)


def _map_npz(path: Path, done: Finished) -> None:
    write_map(path, done.texture, done.sheet, done.flat, done.cameras)


def _of_sheet(write: Callable[[Path, Sheet, FlatMap], None]) -> Callable[[Path, Finished], None]:
    return lambda path, done: write(path, done.sheet, done.flat)


@dataclass(frozen=True)
class Kind:
    """A kind of file: its name in the folder, what it is for the user, and its writer."""

    name: str
    label: str
    description: str
    write: Callable[[Path, Finished], None]


PAGE_KINDS = {
    "tiff": Kind("page.tif", "TIFF", "The page for keeping: uncompressed, resolution and colour profile set", _tiff),
    "png": Kind("page.png", "PNG", "The page without loss, resolution and colour profile set", _png),
    "jpeg": Kind("page.jpg", "JPEG", "The page for sending, 8 bits", _jpeg),
}
ARRAY_KINDS = {
    "uv_svg": Kind(
        "uv_layout.svg", "UV Layout", "The flat mesh as SVG, in millimetres where known", _of_sheet(write_uv_layout)
    ),
    "crease_svg": Kind(
        "crease_pattern.svg", "Crease Pattern", "Mountains and valleys as SVG lines", _of_sheet(write_crease_svg)
    ),
    "fold": Kind(
        "crease_pattern.fold", "FOLD", "The crease pattern as origami programs read it", _of_sheet(write_fold)
    ),
    "sheet": Kind("sheet.npz", "Arrays", "Mesh, UV map and cameras as arrays", _sheet_npz),
    "map": Kind("map.npz", "Map", "Which pixel of which photo each pixel of the page is from, and back", _map_npz),
}


@dataclass(frozen=True)
class ModelKind:
    """A kind of 3D model, written from the sheet's object."""

    name: str
    label: str
    description: str
    write: Callable[[Path, bpy.types.Object], None]


MODEL_KINDS = {
    "gltf": ModelKind("sheet.glb", "glTF", "The sheet with its page on it, in one file", write_glb),
    "obj": ModelKind("sheet.obj", "OBJ", "The sheet with its UV map; its page lies beside it as page.jpg", write_obj),
    "usd": ModelKind("sheet.usdz", "USD", "The sheet with its page on it, in one file", write_usd),
}


def names_of(kinds: Iterable[str]) -> list[str]:
    """All files that these kinds are written as."""
    every = PAGE_KINDS | ARRAY_KINDS | MODEL_KINDS
    names = [every[kind].name for kind in kinds]
    return [*names, "sheet.mtl", PAGE_KINDS["jpeg"].name] if "obj" in kinds else names


def write_files(kinds: Sequence[str], out: Path, folder: Path, done: Finished, watch: Watch) -> None:
    """Write the document as files.

    Parameters
    ----------
    kinds : sequence of str
        Of `PAGE_KINDS`, `ARRAY_KINDS` and `MODEL_KINDS`.
    out : Path
        Gets the files.
    folder : Path
        For a picture that is needed meanwhile.
    done : Finished
    watch : Watch

    Raises
    ------
    StepFailed
    """
    plain_kinds = PAGE_KINDS | ARRAY_KINDS
    for number, kind in enumerate(each for each in kinds if each in plain_kinds):
        watch.step(0.6 * number / len(kinds), f"Writing {plain_kinds[kind].name}")
        plain_kinds[kind].write(out / plain_kinds[kind].name, done)
    models = [kind for kind in kinds if kind in MODEL_KINDS]
    if not models:
        return
    watch.step(0.6, "Writing the models")
    picture = (out if "obj" in kinds else folder) / PAGE_KINDS["jpeg"].name
    if picture.parent != out or "jpeg" not in kinds:
        _jpeg(picture, done)
    frame = document_frame(done.sheet, done.flat)
    sheet_object = sheet_to_object("sheet", done.sheet, done.flat, done.reference, frame)
    sheet_object.data.materials.append(paper_material("page", bpy.data.images.load(str(picture)), PAGE_UV))
    for kind in models:
        MODEL_KINDS[kind].write(out / MODEL_KINDS[kind].name, sheet_object)
