"""Adds photos from the file browser, from File > Import, or dropped on the window."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...core.errors import UsageError
from ..files.movie_photos import movies_among
from ..files.photo_files import instead, is_photo, photos_in
from ..files.picture_kinds import EXTENSIONS, MOVIE_EXTENSIONS, kind_of_file, left_out
from ..jobs import running
from ..one_line import printable
from ..presets import apply_preset
from ..scene.chosen import active_document, choose
from ..scene.document import Document, new_document
from ..scene.listed_photos import counted, give_unique_names, is_named, list_photos
from ..scene.modes import push_undo, users_mode
from .folder import AsksForFolder
from .kind import AsksForKind
from .needs import DocumentOperator
from .nested import start


class ORIGAMI_OT_add_photos(AsksForKind, bpy.types.Operator, ImportHelper):
    """Start a document with photos of one sheet, or add photos to the current document"""

    bl_idname = "origami.add_photos"
    bl_label = "Document Photos"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    directory: StringProperty(
        name="Folder", description="The folder of the photos", subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"}
    )
    files: CollectionProperty(
        type=bpy.types.OperatorFileListElement,
        name="Files",
        description="The photos; choose none to take all in the folder",
        options={"HIDDEN", "SKIP_SAVE"},
    )
    filter_glob: StringProperty(
        name="Filter",
        description="Kinds of files shown",
        default=";".join(f"*{extension}" for extension in (*EXTENSIONS, *MOVIE_EXTENSIONS)),
        options={"HIDDEN"},
    )
    # Blender's file browser reads this property by its name and its item by its number.
    display_type: EnumProperty(
        name="Display",
        description="How the file browser shows the photos",
        items=[("THUMBNAIL", "Thumbnails", "As pictures", 3)],
        options={"HIDDEN", "SKIP_SAVE"},
    )
    # Do not reuse the answers of the last time.
    new: BoolProperty(
        name="New Document",
        description="Start a new document with these photos instead of adding them to the current one",
        options={"SKIP_SAVE"},
    )
    recursive: BoolProperty(
        name="Subfolders",
        description="If a folder is chosen and no photo: also take the photos in the folders inside it",
        options={"SKIP_SAVE"},
    )
    rectify: BoolProperty(
        name="Rectify at Once", description="Make the page as soon as the photos are added", options={"SKIP_SAVE"}
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the kind of document if files were dropped, otherwise for the files."""
        if active_document(context) is None:
            self.new = True
        if self.files or self.properties.is_property_set("directory"):
            self.rectify = self.new = True
            return context.window_manager.invoke_props_dialog(
                self, title="Rectify These Photos", confirm_text="Rectify"
            )
        return super().invoke(context, event)

    def draw(self, context: bpy.types.Context) -> None:
        """The questions."""
        self.layout.use_property_split = True
        if self.files:
            self.layout.label(text=f"{counted(self.files)} from {Path(self.directory).name}", icon="IMAGE_DATA")
        self.layout.prop(self, "preset")
        if active_document(context) is not None:
            self.layout.prop(self, "new")
        if not self.files or not self.files[0].name:
            self.layout.prop(self, "recursive")
        self.layout.prop(self, "rectify")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Add the photos to the document."""
        folder = Path(self.directory or Path(self.filepath).parent)
        try:
            photos, sentences = self._photos(folder)
        except UsageError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not photos:
            self.report({"ERROR"}, " ".join([f"There are no photos in {folder}: {instead(folder)}.", *sentences]))
            return {"CANCELLED"}
        for sentence in sentences:
            self.report({"WARNING"}, sentence)
        mode = users_mode(context)
        document = active_document(context)
        if document is None or self.new:
            document = new_document(printable(folder.name) or "document", context.scene)
            apply_preset(document.collection.origami.settings, self.preset)
        list_photos(document, photos)
        choose(context, document)
        if mode is not None:  # what Blender pushes in Edit Mode only holds the edited data
            push_undo(context, self.bl_label)
        self.report({"INFO"}, f"{document.title}: {counted(document.collection.origami.photos)}")
        if self.rectify:
            start(self, bpy.ops.origami.rectify)  # the photos stay even if it cannot start
        return {"FINISHED"}

    def _photos(self, folder: Path) -> tuple[list[Path], list[str]]:
        """The chosen photos, or all of the folder, and sentences about what is not a photo."""
        # Where nothing is chosen, the file browser of a saved .blend names that file.
        named = [folder / each.name for each in self.files if each.name and not each.name.endswith(".blend")]
        if not named:
            return photos_in(folder, recursive=self.recursive) if folder.is_dir() else ([], [])
        photos, sentences = [], []
        for path in named:
            if path.is_dir():
                inside, others = photos_in(path, recursive=self.recursive)
                photos += inside
                sentences += others
            elif is_photo(path) or movies_among([path]):
                photos.append(path)
            else:
                sentences.append(left_out(path.name, kind_of_file(path)))
        return photos, sentences


class _PhotosOperator(DocumentOperator):
    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """Photos."""
        document = active_document(context)
        there = document is not None and document.collection.origami.photos
        return "" if there else "There is no photo in the document"


class ORIGAMI_OT_remove_photo(_PhotosOperator, bpy.types.Operator):
    """Remove the selected photo from the document; its file stays"""

    bl_idname = "origami.remove_photo"
    bl_label = "Remove Photo"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """A photo to remove."""
        document = active_document(context)
        group = None if document is None else document.collection.origami
        chosen = group is not None and 0 <= group.active_photo < len(group.photos)
        return super().missing(context) or ("" if chosen else "Select a photo in the list first")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Remove it from the list."""
        group = self.document.collection.origami
        if group.photos[group.active_photo].name == group.settings.reference:
            # Otherwise a photo of that name added later would become the reference unasked.
            group.settings.reference = ""
            self.report({"INFO"}, "The reference photo is removed: Origami chooses another one")
        group.photos.remove(group.active_photo)
        give_unique_names(group)
        group.active_photo = max(0, min(group.active_photo, len(group.photos) - 1))
        return {"FINISHED"}


class ORIGAMI_OT_find_photos(AsksForFolder, _PhotosOperator, bpy.types.Operator):
    """Look in a folder for the document's photos that were moved, by their names"""

    bl_idname = "origami.find_photos"
    bl_label = "Find Photos"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(name="Folder", description="Where the photos are now", subtype="DIR_PATH")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Update the paths of the photos; the results stay up to date."""
        group = self.document.collection.origami
        folder = Path(self.directory).absolute()
        moved: dict[str, str] = {}
        lost = []
        for photo in group.photos:
            path = bpy.path.abspath(photo.path)
            if Path(path).is_file():
                continue
            places = (folder / Path(photo.name).name, folder / photo.name)
            there = [str(place) for place in places if place.is_file() and is_named(place, photo.name)]
            if there:
                photo.path = moved[path] = there[0]
            else:
                lost.append(photo.name)
        group.photos_placed = json.dumps([moved.get(path, path) for path in json.loads(group.photos_placed)])
        for image in bpy.data.images:
            if (path := bpy.path.abspath(image.filepath)) in moved:
                image.filepath = moved[path]
        if lost:
            kind = "WARNING" if moved else "ERROR"
            self.report({kind}, f"Not in {folder}: {', '.join(lost)}; choose the folder where these photos are")
            return {"FINISHED"} if moved else {"CANCELLED"}
        self.report({"INFO"}, f"{len(moved)} photos found")
        return {"FINISHED"}


def lost_photos(document: Document) -> int:
    """How many of the document's photos were missing at the last check; cheap enough for panels."""
    return _lost(tuple(bpy.path.abspath(photo.path) for photo in document.collection.origami.photos), running.ended())


@lru_cache(maxsize=8)
def _lost(paths: tuple[str, ...], jobs_ended: int) -> int:
    """Checked once for each list, and again after each job, which may have failed because of it."""
    return sum(not Path(path).is_file() for path in paths)


class ORIGAMI_FH_photos(bpy.types.FileHandler):
    """Photos, or a movie, dropped on the 3D view or the image editor"""

    bl_idname = "ORIGAMI_FH_photos"
    bl_label = "Document Photos"
    bl_import_operator = "origami.add_photos"
    bl_file_extensions = ";".join((*EXTENSIONS, *MOVIE_EXTENSIONS))

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Editors in which photos may be dropped."""
        return context.area is not None and context.area.type in ("VIEW_3D", "IMAGE_EDITOR")


CLASSES = (ORIGAMI_OT_add_photos, ORIGAMI_OT_remove_photo, ORIGAMI_OT_find_photos, ORIGAMI_FH_photos)
