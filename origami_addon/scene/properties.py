"""A document's settings and photos as Blender shows and saves them; the settings are those of `settings.py`."""

from __future__ import annotations

from typing import Any, get_args, get_type_hints

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ...core.flatten import FlattenSettings
from ...core.surface import SurfaceSettings
from ..paper_size import PAPER_SIZES_MM
from ..settings import ImageSettings, PageSettings, RunSettings
from ..sfm.result import SfmSettings
from .document import document_of

NO_PAPER, OTHER_PAPER = "none", "other"

_SURFACES = {
    "developable": ("Developable", "Smooth along the rulings, free to bend across them"),
    "ridge_aware": ("Ridge-Aware", "The paper's method: smooth everywhere but across the creases"),
    "poisson": ("Poisson", "The first solve of the paper's method alone"),
    "poisson_l2": ("Poisson, Least Squares", "Without robustness against wrong points"),
}
_FLATTENERS = {
    "arap": ("As Rigid as Possible", "Every triangle keeps its shape and size as well as it can"),
    "conformal_l1": ("Conformal, l1", "The paper's method: angles are kept but for few triangles"),
    "lscm": ("Conformal, Least Squares", "Angles are kept as well as they can be everywhere"),
    "geodesic": ("Geodesic", "Distances along the surface are kept"),
}
_TURNS = {
    "auto": ("Automatic", "By the direction of the text; as the photos stand where it cannot be told"),
    "0": ("As in the Photo", "The page stands as in the reference photo"),
    "90": ("90° Clockwise", "The reference photo turned to the right"),
    "180": ("180°", "The reference photo upside down"),
    "270": ("90° Counter-Clockwise", "The reference photo turned to the left"),
}
_SOURCES = {
    "healed": ("Healed Reference", "From the reference photo; its glare, blur and passing shadows from other photos"),
    "reference": ("Reference Photo", "All from one photo, whose pixels stay untouched"),
    "best": ("Best Photos", "Each region from the photo that shows it largest and sharpest"),
}
_PAPERS = [
    (NO_PAPER, "Unknown", "The page has the right shape and no true size"),
    *((name, name, f"{width:g} x {height:g} mm") for name, (width, height) in PAPER_SIZES_MM.items()),
    (OTHER_PAPER, "Other", "Type the width and, where it is known, the height"),
]


def _words(settings: type, name: str, told: dict[str, tuple[str, str]]) -> list[tuple[str, str, str]]:
    """The items of a setting that is one of several words; each word must be told of."""
    return [(word, *told[word]) for word in get_args(get_type_hints(settings)[name])]


FLATTENER_ITEMS = _words(FlattenSettings, "method", _FLATTENERS)


class OrigamiSfmSettings(bpy.types.PropertyGroup):
    """How the photos are placed."""

    max_image_size: IntProperty(
        name="Matching Size",
        description="Pixels of the photos' long side at which they are matched; more needs more memory",
        default=SfmSettings.max_image_size,
        min=400,
        max=20000,
        subtype="PIXEL",
    )
    max_features: IntProperty(
        name="Features",
        description="Most features taken from each photo",
        default=SfmSettings.max_features,
        min=100,
        max=100000,
    )
    threads: IntProperty(
        name="Threads",
        description="Processor cores used; with one, two runs give the same bits",
        default=SfmSettings.threads,
        min=1,
        max=1024,
    )
    seed: IntProperty(name="Seed", description="Of all random choices", default=SfmSettings.seed, min=0, max=2**31 - 1)


class OrigamiSurfaceSettings(bpy.types.PropertyGroup):
    """How the surface is reconstructed."""

    method: EnumProperty(
        name="Surface",
        description="How the surface is fitted to the points",
        items=_words(SurfaceSettings, "method", _SURFACES),
        default=SurfaceSettings.method,
    )
    grid_rows: IntProperty(
        name="Grid Rows",
        description="Nodes of the surface along the page's long side",
        default=SurfaceSettings.grid_rows,
        min=20,
        max=400,
    )
    smoothness: FloatProperty(
        name="Smoothness",
        description="Factor on the smoothness that the points choose: above 1 fewer waves, below 1 finer bends",
        default=SurfaceSettings.smoothness,
        min=1e-4,
        max=1e4,
        soft_min=0.1,
        soft_max=10,
    )
    ridge_curvature: FloatProperty(
        name="Ridge Curvature",
        description="From which curvature on the ridge-aware surface takes a place for a crease, per page length",
        default=SurfaceSettings.ridge_curvature,
        min=1e-3,
        max=1e4,
    )
    ridge_emphasis: FloatProperty(
        name="Ridge Emphasis",
        description="How much less smooth the ridge-aware surface is across a crease than along it",
        default=SurfaceSettings.ridge_emphasis,
        min=1.001,
        max=1e6,
        soft_max=100,
    )


class OrigamiFlattenSettings(bpy.types.PropertyGroup):
    """How the sheet is flattened."""

    method: EnumProperty(
        name="Method",
        description="What the flat page keeps of the sheet",
        items=FLATTENER_ITEMS,
        default=FlattenSettings.method,
    )
    ridge_rows: BoolProperty(
        name="Straighten Creases",
        description="Ask creases to become straight lines of the page",
        default=FlattenSettings.ridge_rows,
    )
    boundary_rows: BoolProperty(
        name="Straighten Sides",
        description="Ask the paper's sides to become straight while flattening",
        default=FlattenSettings.boundary_rows,
    )


class OrigamiPageSettings(bpy.types.PropertyGroup):
    """Size and orientation of the page."""

    paper: EnumProperty(name="Paper", description="The paper's true size", items=_PAPERS, default=NO_PAPER)
    width: FloatProperty(
        name="Width (mm)", description="Of the paper, in millimetres", default=80.0, min=5.0, max=5000.0, precision=1
    )
    height: FloatProperty(
        name="Height (mm)",
        description="Of the paper, in millimetres; 0 where it follows from the sheet, as for a receipt",
        default=0.0,
        min=0.0,
        max=5000.0,
        precision=1,
    )
    turn: EnumProperty(
        name="Turn",
        description="From the reference photo to the page",
        items=_words(PageSettings, "turn", _TURNS),
        default=PageSettings.turn,
    )


class OrigamiImageSettings(bpy.types.PropertyGroup):
    """The page image."""

    dpi: FloatProperty(
        name="Resolution (dpi)",
        description="Pixels per inch of the page, for paper of known size; 0 for the photo's own pixel density",
        default=0.0,
        min=0.0,
        max=4800.0,
        precision=0,
    )
    source: EnumProperty(
        name="Pixels From",
        description="Which photos the page is made of",
        items=_words(ImageSettings, "source", _SOURCES),
        default=ImageSettings.source,
    )
    bake: BoolProperty(
        name="Bake",
        description="On the command line, let Blender bake the page as well, into a second file",
        default=ImageSettings.bake,
    )


class OrigamiSettings(bpy.types.PropertyGroup):
    """Everything that decides what is computed for a document."""

    sfm: PointerProperty(type=OrigamiSfmSettings, name="Placing", description="How the photos are placed")
    surface: PointerProperty(type=OrigamiSurfaceSettings, name="Surface", description="How the surface is fitted")
    flatten: PointerProperty(type=OrigamiFlattenSettings, name="Unwrap", description="How the sheet is flattened")
    page: PointerProperty(type=OrigamiPageSettings, name="Page", description="Size and orientation of the page")
    image: PointerProperty(type=OrigamiImageSettings, name="Image", description="The page image")
    colmap_model: StringProperty(
        name="COLMAP Model",
        description="Folder of an existing COLMAP model of the photos, instead of structure from motion",
        subtype="DIR_PATH",
    )
    reference: StringProperty(
        name="Reference Photo",
        description="The photo in which the paper is found and its surface built; empty to have it chosen",
    )
    sheet: IntProperty(
        name="Sheet",
        description="Which of several sheets in view: 1 is the one in the middle that most photos show",
        default=1,
        min=1,
        max=100,
    )


class OrigamiPhoto(bpy.types.PropertyGroup):
    """A photo of the document."""

    path: StringProperty(name="Path", description="The photo's file", subtype="FILE_PATH")
    use: BoolProperty(name="Use", description="Whether the photo takes part; the others are left out", default=True)
    note: StringProperty(name="Note", description="What became of the photo")


class OrigamiStage(bpy.types.PropertyGroup):
    """What a stage did last."""

    done: BoolProperty(name="Done", description="Whether the stage has been done since those before it")
    figures: StringProperty(name="Figures", description="Its figures, as JSON", default="{}")
    warnings: StringProperty(name="Warnings", description="What to know about its result, as JSON", default="[]")
    settings: StringProperty(name="Settings", description="The settings that it was done with, as JSON")
    seconds: FloatProperty(name="Seconds", description="How long it took", unit="TIME_ABSOLUTE")


class OrigamiDocument(bpy.types.PropertyGroup):
    """What a document's collection holds beside its objects."""

    photos: CollectionProperty(type=OrigamiPhoto, name="Photos", description="The document's photos")
    active_photo: IntProperty(name="Photo", description="The photo chosen in the list")
    settings: PointerProperty(
        type=OrigamiSettings, name="Settings", description="Everything that decides what is computed"
    )
    place: PointerProperty(type=OrigamiStage, name="Structure from Motion", description="Where the photos were taken")
    find: PointerProperty(type=OrigamiStage, name="Sheet", description="Where the paper is in the reference photo")
    surface: PointerProperty(type=OrigamiStage, name="Ridges", description="The sheet's surface and its creases")
    unwrap: PointerProperty(type=OrigamiStage, name="Unwrap", description="The sheet laid flat")
    lay_out: PointerProperty(type=OrigamiStage, name="Layout", description="The flat sheet as a page")
    page: PointerProperty(type=OrigamiStage, name="Page", description="The page image")
    photos_placed: StringProperty(
        name="Photos Placed", description="The photos that structure from motion was given, as JSON", default="[]"
    )
    outline_by_hand: BoolProperty(
        name="Outline by Hand", description="Whether the sheet was cut out along an outline mended by hand"
    )
    creases: StringProperty(
        name="Creases by Hand",
        description="The creases that the sheet was built with, as JSON, where they were not found but given",
    )


def _is_document(scene: Any, collection: bpy.types.Collection) -> bool:
    """A function, not a lambda: Blender reads the annotations below in a namespace without this module's names."""
    return document_of(collection) is not None


class OrigamiScene(bpy.types.PropertyGroup):
    """What the panels of a scene show."""

    document: PointerProperty(
        type=bpy.types.Collection,
        name="Document",
        description="The document that the panels show",
        poll=_is_document,
    )
    show_errors: BoolProperty(
        name="Points by Error",
        description="Draw the sparse points over the 3D view, from blue (exact) to red (two pixels off)",
        default=False,
    )
    show_creases: BoolProperty(
        name="Creases",
        description="Draw the creases over the 3D view: mountains red, valleys blue, as seen from the printed side",
        default=True,
    )


CLASSES = (
    OrigamiSfmSettings,
    OrigamiSurfaceSettings,
    OrigamiFlattenSettings,
    OrigamiPageSettings,
    OrigamiImageSettings,
    OrigamiSettings,
    OrigamiPhoto,
    OrigamiStage,
    OrigamiDocument,
    OrigamiScene,
)


def register() -> None:
    """Make Blender know the properties, unless the command line has done so in this session."""
    if hasattr(bpy.types.Collection, "origami"):
        return
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Collection.origami = PointerProperty(
        type=OrigamiDocument, name="Origami", description="What Origami keeps of a document"
    )
    bpy.types.Scene.origami = PointerProperty(
        type=OrigamiScene, name="Origami", description="What Origami's panels show"
    )


def unregister() -> None:
    """Make Blender forget the properties."""
    del bpy.types.Scene.origami
    del bpy.types.Collection.origami
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)


_NESTED = ("sfm", "surface", "flatten", "image")


def settings_to_json(group: Any) -> dict[str, Any]:
    """The settings in a property group as `settings_json.from_json` reads them."""
    content: dict[str, Any] = {}
    for part in _NESTED:
        names = type(getattr(RunSettings(), part)).__dataclass_fields__
        content[part] = {name: _exact(getattr(getattr(group, part), name)) for name in names}
    content["image"]["dpi"] = content["image"]["dpi"] or None
    page = group.page
    size: tuple[float, float | None] | None = None
    if page.paper == OTHER_PAPER:
        size = (_exact(page.width), _exact(page.height) or None)
    elif page.paper != NO_PAPER:
        size = PAPER_SIZES_MM[page.paper]
    content["page"] = {"paper_size_mm": None if size is None else list(size), "turn": page.turn}
    content["colmap_model"] = bpy.path.abspath(group.colmap_model) or None
    content["reference"] = group.reference or None
    content["sheet"] = group.sheet
    return content


def _exact(value: Any) -> Any:
    """The number that was typed: Blender keeps single precision."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def settings_from(group: Any, settings: RunSettings) -> None:
    """Set a property group to ``settings``; an outline, which is an object, is not part of it."""
    for part in _NESTED:
        values = getattr(settings, part)
        for name in type(values).__dataclass_fields__:
            setattr(getattr(group, part), name, getattr(values, name) or 0 if name == "dpi" else getattr(values, name))
    size = settings.page.paper_size_mm
    named = next((name for name, known in PAPER_SIZES_MM.items() if size in (known, known[::-1])), OTHER_PAPER)
    group.page.paper = NO_PAPER if size is None else named
    if size is not None:
        group.page.width, group.page.height = size[0], size[1] or 0
    group.page.turn = settings.page.turn
    group.colmap_model = settings.colmap_model or ""
    group.reference = settings.reference or ""
    assert settings.sheet != "all"  # each of them has a document of its own
    group.sheet = settings.sheet
