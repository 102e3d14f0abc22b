"""The list of a document's photos, with thumbnails; Blender makes and keeps these in the background."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import bpy.utils.previews

from ..scene.document import Document, document_of
from ..scene.listed_photos import LOST, PLACED, is_named
from ..scene.roles import OUTLINE

_LARGE = 7.0  # of the selected photo's thumbnail: in heights of a row
_BAR, _ERROR = 1.4, 2.6  # the widths of a photo's bar and of its error, in the same unit: its name has the rest
_previews: bpy.utils.previews.ImagePreviewCollection | None = None


class ORIGAMI_UL_photos(bpy.types.UIList):
    """The document's photos, whether each was placed, and which is the reference photo"""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: Any,
        data: Any,
        item: Any,
        icon: int,
        active_data: Any,
        active_property: str,
    ) -> None:
        """One photo."""
        layout.use_property_split = False
        layout.prop(item, "use", text="")
        row = layout.row(align=True)
        row.active = item.use
        lost = item.note == LOST
        thumbnail = 0 if lost else thumbnail_of(item.path)
        if thumbnail:
            row.label(text=item.name, icon_value=thumbnail)
        else:
            row.label(text=item.name, icon="ERROR" if lost else "IMAGE_DATA")
        document = document_of(data.id_data)
        if document is not None and is_reference(document, item):
            row.label(text="", icon="SOLO_ON")
        if item.points:
            if share := sharpness_share(item, data.photos):
                bar = row.row()
                bar.ui_units_x = _BAR
                bar.progress(factor=share, text="")
            error = row.row()
            error.ui_units_x = _ERROR
            error.label(text=f"{item.error:.1f} px")
        elif item.note:
            row.label(text=item.note)


def draw_selected(layout: Any, group: Any) -> None:
    """The thumbnail of the selected photo, large, how sharp it is and how well it was placed."""
    if not 0 <= group.active_photo < len(group.photos):
        return
    photo = group.photos[group.active_photo]
    thumbnail = thumbnail_of(photo.path)
    if thumbnail:
        layout.template_icon(icon_value=thumbnail, scale=_LARGE)
    column = layout.column(align=True)
    for line in judged(photo, group.photos):
        column.label(text=line)


def judged(photo: Any, photos: Any) -> list[str]:
    """How well a photo of the list was placed and how sharp it is, each in a line, as far as that is known."""
    lines = []
    if photo.points:
        lines.append(f"{PLACED.capitalize()}: {photo.points} points, {photo.error:.2f} px off")
    elif photo.note:
        lines.append(photo.note.capitalize())
    if share := sharpness_share(photo, photos):
        lines.append("The sharpest photo" if share == 1 else f"{100 * share:.0f} % as sharp as the sharpest")
    return lines


def sharpness_share(photo: Any, photos: Any) -> float:
    """How sharp a photo is, of the sharpest one in the list; 0 if that is not known."""
    best = max((each.sharpness for each in photos), default=0.0)
    return photo.sharpness / best if best > 0 else 0.0


def is_reference(document: Document, photo: Any) -> bool:
    """Whether a photo of the list is the one in which the sheet was found or will be looked for."""
    outline = document.object(OUTLINE)
    camera = None if outline is None else outline.parent
    if camera is not None and "photo" in camera:
        return is_named(Path(bpy.path.abspath(photo.path)), camera["photo"])
    return bool(photo.name == document.collection.origami.settings.reference)


def thumbnail_of(path: str) -> int:
    """Blender's number of a photo's thumbnail; 0 if the file is gone, or of a kind of which Blender makes none."""
    file = Path(bpy.path.abspath(path))
    if _previews is None or file.suffix.lower() not in bpy.path.extensions_image or not file.is_file():
        return 0
    key = str(file)
    preview = _previews[key] if key in _previews else _previews.load(key, key, "IMAGE")
    return int(preview.icon_id)


def register() -> None:
    """Start to keep thumbnails."""
    global _previews
    _previews = bpy.utils.previews.new()


def unregister() -> None:
    """Free the thumbnails."""
    global _previews
    if _previews is not None:
        bpy.utils.previews.remove(_previews)
    _previews = None
