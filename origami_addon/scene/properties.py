"""Blender's properties of a document and of a scene."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..stages import STAGES, about
from .chosen import choose_place, place_of
from .declared import sentence
from .document import document_of
from .document_acts import retitle
from .settings_group import SETTINGS_CLASSES, OrigamiSettings


class OrigamiPhoto(bpy.types.PropertyGroup):
    """A photo of the document."""

    path: StringProperty(name="Path", description="The photo's file", subtype="FILE_PATH")
    use: BoolProperty(name="Use", description="Use this photo; photos that are not ticked are left out", default=True)
    note: StringProperty(name="Note", description="Whether the photo was placed")
    points: IntProperty(name="Points", description="How many points of the sparse model the photo shows")
    error: FloatProperty(name="Error", description="How far these are from where they were seen, on average, in pixels")
    sharpness: FloatProperty(name="Sharpness", description="How sharp the photo is; 0 if that is not known")


class OrigamiFolder(bpy.types.PropertyGroup):
    """A folder that may become a document; its name is its path."""

    photos: IntProperty(name="Photos", description="How many photos it holds", min=0)
    known: BoolProperty(name="Known", description="Whether a document has photos of this folder")
    use: BoolProperty(name="Use", description="Make a document of the photos in this folder", default=True)


class OrigamiStage(bpy.types.PropertyGroup):
    """The last run of a stage."""

    done: BoolProperty(name="Done", description="Whether the stage has run since the stages before it")
    figures: StringProperty(name="Figures", description="Its figures, as JSON", default="{}")
    warnings: StringProperty(name="Warnings", description="Warnings about its result, as JSON", default="[]")
    settings: StringProperty(name="Settings", description="The settings with which it ran, as JSON")
    seconds: FloatProperty(name="Seconds", description="How long it took", unit="TIME_ABSOLUTE")


def _title(group: Any) -> str:
    return str(group.id_data.name)


def _retitle(group: Any, title: str) -> None:
    document = document_of(group.id_data)
    if document is not None:
        retitle(document, title.strip())


class OrigamiDocument(bpy.types.PropertyGroup):
    """The data of a document's collection, apart from its objects."""

    __annotations__ = {
        "title": StringProperty(
            name="Title",
            description="The document's title, which is the name of its collection; its objects are named after it",
            get=_title,
            set=_retitle,
        ),
        "photos": CollectionProperty(type=OrigamiPhoto, name="Photos", description="The document's photos"),
        "active_photo": IntProperty(name="Photo", description="The photo selected in the list"),
        "settings": PointerProperty(type=OrigamiSettings, name="Settings", description="All settings of the document"),
        **{
            stage: PointerProperty(type=OrigamiStage, name=about(stage).title, description=sentence(about(stage).help))
            for stage in STAGES
        },
        "photos_placed": StringProperty(
            name="Photos Placed", description="The photos that structure from motion used, as JSON", default="[]"
        ),
        "outline_by_hand": BoolProperty(
            name="Outline by Hand", description="Whether the sheet was cut out along an outline edited by hand"
        ),
        "creases": StringProperty(
            name="Creases by Hand",
            description="The given creases with which the sheet was built, as JSON; empty if they were found",
        ),
        "crease": IntProperty(
            name="Crease", description="The crease chosen in the list, counted from 0; -1: none", default=-1, min=-1
        ),
    }


def _is_document(scene: Any, collection: bpy.types.Collection) -> bool:
    """A function, not a lambda: Blender reads the annotations below in a namespace without this module's names."""
    return document_of(collection) is not None


def _place(scene: Any) -> int:
    return place_of(bpy.context)


def _choose_place(scene: Any, place: int) -> None:
    choose_place(bpy.context, place)


class OrigamiScene(bpy.types.PropertyGroup):
    """What the panels of a scene show."""

    document: PointerProperty(
        type=bpy.types.Collection,
        name="Document",
        description="The document chosen last",
        poll=_is_document,
    )
    place: IntProperty(
        name="Document",
        description="The document that the panels show, by its place among the file's collections",
        get=_place,
        set=_choose_place,
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
    *SETTINGS_CLASSES,
    OrigamiPhoto,
    OrigamiFolder,
    OrigamiStage,
    OrigamiDocument,
    OrigamiScene,
)


def register() -> None:
    """Register the properties, unless the command line has done so in this session."""
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
    """Unregister the properties."""
    del bpy.types.Scene.origami
    del bpy.types.Collection.origami
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
