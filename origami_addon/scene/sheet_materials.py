"""The sheet's two materials: the reference photo, and the page."""

from __future__ import annotations

from pathlib import Path

import bpy

from .document import Document
from .paper_material import paper_material

PAGE_MATERIAL, PHOTO_MATERIAL = "page", "photo"
PICTURE = "origami_picture"  # of an image: document and use


def page_image(document: Document) -> bpy.types.Image | None:
    """The page as a Blender image, or None if there is none yet."""
    return _picture(f"{document.name} {PAGE_MATERIAL}")


def _picture(name: str) -> bpy.types.Image | None:
    return next((each for each in bpy.data.images if each.get(PICTURE) == name), None)


def has_photo(document: Document, sheet_object: bpy.types.Object, photo: Path) -> bool:
    """Whether the sheet already has a material of this photo, which is large and slow to load and draw again."""
    shown = _picture(f"{document.name} {PHOTO_MATERIAL}")
    used = any(each is not None and each.get("use") == PHOTO_MATERIAL for each in sheet_object.data.materials)
    return used and shown is not None and Path(bpy.path.abspath(shown.filepath)) == photo


def set_material(
    document: Document, sheet_object: bpy.types.Object, use: str, picture: Path, uv_layer: str
) -> bpy.types.Material:
    """The sheet's material for a use, created if missing; its picture is reloaded."""
    name = f"{document.name} {use}"
    before = _picture(name)
    image = bpy.data.images.load(str(picture))
    image[PICTURE] = name
    document.own(image)
    if before is not None:
        before.user_remap(image)
        bpy.data.images.remove(before)
    image.name = name
    material = next((each for each in sheet_object.data.materials if each is not None and each.get("use") == use), None)
    if material is None:
        material = paper_material(name, image, uv_layer)
        material["use"] = use
        document.own(material)
        sheet_object.data.materials.append(material)
    return material


def use_material(sheet_object: bpy.types.Object, use: str, uv_layer: str) -> None:
    """Show the sheet in one of its materials, which becomes the first, with the UV layer that belongs to it."""
    mesh = sheet_object.data
    place = next(index for index, each in enumerate(mesh.materials) if each is not None and each.get("use") == use)
    mesh.materials[0], mesh.materials[place] = mesh.materials[place], mesh.materials[0]
    # Solid shading uses the active layer, whatever the material says.
    mesh.uv_layers.active = mesh.uv_layers[uv_layer]
    mesh.uv_layers[uv_layer].active_render = True
