"""Rectifies several documents in the background, one after the other, while the user does something else.

Each is a job of its own: what fails in one does not stop the next, and the user may undo, save and go on working in
between. ESC, Stop and Cancel end the run of one document; the others then wait until the user resumes.
"""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import BoolProperty, CollectionProperty, IntProperty, StringProperty

from ...core.errors import UsageError
from ..files.marker import MARKER
from ..files.photo_files import instead, photos_in
from ..jobs import running
from ..jobs.queue import queue
from ..one_line import printable
from ..plan import Known, Plan, plan_all
from ..presets import apply_preset
from ..scene.chosen import choose
from ..scene.document import Document, documents, find_document, new_document
from ..scene.listed_photos import list_photos
from ..scene.modes import whole_step
from ..scene.properties import OrigamiFolder
from .folder import AsksForFolder
from .job_operator import is_free
from .kind import AsksForKind
from .needs import Operator
from .nested import start
from .run_stages import StageOperator

_MOST_ROWS = 12  # of the list of folders: a longer one scrolls, because a dialog cannot be higher than the window
_WIDTH = 400  # pixels of an unscaled interface: names of folders are often long
_LOOK_SECONDS = 0.2  # between two looks whether the next one can start


class ORIGAMI_OT_add_folders(AsksForFolder, Operator, bpy.types.Operator):
    """Start a document with the photos of each folder inside a folder, and rectify one after the other"""

    bl_idname = "origami.add_folders"
    bl_label = "Add Folders"

    directory: StringProperty(name="Folder", description="The folder that holds the folders", subtype="DIR_PATH")
    # Blender's file browser puts the selected folders here, or the whole path of the folder that it shows.
    dirs: CollectionProperty(
        type=bpy.types.OperatorFileListElement,
        name="Folders",
        description="The folders to tick; none: all that have photos",
        options={"HIDDEN", "SKIP_SAVE"},
    )
    filter_image: BoolProperty(name="Photos", description="Show photos too", default=True, options={"HIDDEN"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Let the user choose among the folders, if there is a window."""
        directory = Path(bpy.path.abspath(self.directory)).absolute()
        try:
            inside = [each for each in directory.iterdir() if each.is_dir() and not each.name.startswith(".")]
        except OSError as error:
            self.report({"ERROR"}, f"The folder {directory} cannot be read ({error.strerror}): choose another one.")
            return {"CANCELLED"}
        folders = [each for each in inside if not (each / MARKER).exists()]
        folders.sort(key=lambda each: each.name.casefold())
        found = [(folder, len(_photos_of(folder)[0])) for folder in folders]
        if not any(count for _, count in found):
            found = [(directory, len(_photos_of(directory)[0]))]
        if not any(count for _, count in found):
            self.report({"ERROR"}, f"No folder in {directory} has photos: choose the folder that holds their folders.")
            return {"CANCELLED"}
        selected = {each.name.rstrip("/\\") for each in self.dirs} & {folder.name for folder, _ in found}
        known = _folders_of_documents()
        lines = [
            {
                "name": str(folder),
                "photos": count,
                "known": folder.resolve() in known,
                "use": count > 0 and (folder.name in selected if selected else folder.resolve() not in known),
            }
            for folder, count in found
        ]
        return {"FINISHED"} if start(self, bpy.ops.origami.start_folders, folders=lines) else {"CANCELLED"}


class ORIGAMI_OT_start_folders(AsksForKind, bpy.types.Operator):
    """Start a document with the photos of each chosen folder, and rectify one after the other"""

    bl_idname = "origami.start_folders"
    bl_label = "Add Folders"
    bl_options = {"INTERNAL"}

    folders: CollectionProperty(
        type=OrigamiFolder, name="Folders", description="The folders", options={"HIDDEN", "SKIP_SAVE"}
    )
    chosen: IntProperty(
        name="Folder", description="The line of the list that is selected", default=-1, options={"SKIP_SAVE"}
    )
    rectify: BoolProperty(
        name="Rectify at Once",
        description="Make the pages as soon as the photos are added",
        default=True,
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask which folders."""
        return context.window_manager.invoke_props_dialog(
            self, width=_WIDTH, title="A Document for Each", confirm_text="Add"
        )

    def draw(self, context: bpy.types.Context) -> None:
        """A tick for each folder, then the questions."""
        rows = min(len(self.folders), _MOST_ROWS)
        self.layout.template_list("ORIGAMI_UL_folders", "", self, "folders", self, "chosen", rows=rows)
        self.layout.use_property_split = True
        self.layout.prop(self, "preset")
        self.layout.prop(self, "rectify")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the documents; one that has lost its photos says so, and the others are rectified."""
        chosen = [Path(each.name) for each in self.folders if each.use]
        if not chosen:
            self.report({"ERROR"}, "No folder is chosen: tick at least one")
            return {"CANCELLED"}
        with whole_step(context, self.bl_label):
            made = [self._document(context, folder) for folder in chosen]
            with_photos = [each for each in made if each.collection.origami.photos]
            choose(context, (with_photos or made)[0])
        self.report({"INFO"}, f"{len(made)} documents")
        if self.rectify:
            queue.add(each.name for each in with_photos)
            go_on(self)
        return {"FINISHED"}

    def _document(self, context: bpy.types.Context, folder: Path) -> Document:
        photos, sentences = _photos_of(folder)
        document = new_document(printable(folder.name) or "document", context.scene)
        apply_preset(document.collection.origami.settings, self.preset)
        list_photos(document, photos)
        for sentence in sentences:
            self.report({"WARNING"}, f"{document.title}: {sentence}")
        if not photos:
            running.fail(running.Failure(document.name, sentences[0], tuple(sentences[1:])))
        return document


def _folders_of_documents() -> set[Path]:
    """The folders from which the documents' photos are, without links."""
    photos = (photo for each in documents() for photo in each.collection.origami.photos)
    return {Path(bpy.path.abspath(photo.path)).parent.resolve() for photo in photos}


def _photos_of(folder: Path) -> tuple[list[Path], list[str]]:
    """The photos in a folder, and sentences about what is left out, or first of all why there are none."""
    try:
        photos, sentences = photos_in(folder, recursive=False)
    except UsageError as error:
        return [], [str(error)]
    return photos, sentences if photos else [f"There are no photos in {folder}: {instead(folder)}.", *sentences]


class _SeveralOperator(Operator):
    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """Documents."""
        return "" if documents() else "Add the photos of a sheet first"


class ORIGAMI_OT_rectify_all(_SeveralOperator, bpy.types.Operator):
    """Make the pages of all documents, one after the other; those that are up to date stay"""

    bl_idname = "origami.rectify_all"
    bl_label = "Rectify All"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Let all wait, and start."""
        now = running.current()
        queue.add(each.name for each in documents() if now is None or each.name != now.document)
        go_on(self)
        return {"FINISHED"}


class ORIGAMI_OT_resume_queue(Operator, bpy.types.Operator):
    """Go on with the documents that wait"""

    bl_idname = "origami.resume_queue"
    bl_label = "Resume"

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """Documents that wait for the user."""
        return "" if queue.paused and queue.waiting else "No document waits: press Rectify All"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Start the next one."""
        queue.resume()
        go_on(self)
        return {"FINISHED"}


class ORIGAMI_OT_leave_queue(bpy.types.Operator):
    """Do not rectify this document now"""

    bl_idname = "origami.leave_queue"
    bl_label = "Do Not Wait"

    document: StringProperty(name="Document", description="The document's name", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Take it out."""
        queue.leave(self.document)
        return {"FINISHED"}


class ORIGAMI_OT_rectify_next(StageOperator, bpy.types.Operator):
    """Make the flat page of a document from the queue"""

    bl_idname = "origami.rectify_next"
    bl_label = "Rectify Photos"  # the name of its undo step
    bl_options = {"INTERNAL"}
    label = "Rectify Photos"

    name: StringProperty(name="Document", description="The document's name", options={"SKIP_SAVE"})

    @classmethod
    def missing(cls, context: bpy.types.Context) -> str:
        """Nothing: the document need not be the one in the panels."""
        return ""

    def target(self, context: bpy.types.Context) -> Document:
        """The document by its name."""
        return find_document(self.name)

    def plan(self, known: Known) -> Plan:
        """All stages that are not up to date."""
        return plan_all(known)

    def report_failure(self, sentence: str) -> None:
        """Say which document has failed, without a message over whatever the user is doing: the list shows it."""
        kind = "WARNING" if self.options.is_invoke else "ERROR"
        self.report({kind}, f"{self.name}: {sentence}")

    def _give_up(self, context: bpy.types.Context, now: running.Running) -> set[str]:
        queue.pause(self._begun_on)
        return super()._give_up(context, now)

    def _finish(self, context: bpy.types.Context) -> set[str]:
        queue.finished(self._now.seconds)
        return super()._finish(context)


def go_on(operator: bpy.types.Operator) -> None:
    """Work through the queue: in a window as time passes, otherwise until it is empty."""
    if not operator.options.is_invoke or bpy.app.background:
        while (name := queue.take()) is not None:
            if _is_there(name):
                start(operator, bpy.ops.origami.rectify_next, name=name)
    elif not bpy.app.timers.is_registered(_start_next):
        bpy.app.timers.register(_start_next)


def _start_next() -> float | None:
    """Start the next document once it may; end when none is left, or all wait for the user."""
    if not is_free(bpy.context):
        return _LOOK_SECONDS
    name = queue.take()
    if name is None:
        return None
    if _is_there(name):
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            try:
                bpy.ops.origami.rectify_next("INVOKE_DEFAULT", name=name)
            except RuntimeError as error:  # it has noted its failure, and the next one starts
                if "Traceback" in str(error):
                    raise
    return _LOOK_SECONDS


def _is_there(name: str) -> bool:
    """Whether the document still exists: the user may have deleted it, or undone its making."""
    return any(each.name == name for each in documents())


def unregister() -> None:
    """Stop looking for the next one."""
    queue.clear()
    if bpy.app.timers.is_registered(_start_next):
        bpy.app.timers.unregister(_start_next)


CLASSES = (
    ORIGAMI_OT_add_folders,
    ORIGAMI_OT_start_folders,
    ORIGAMI_OT_rectify_all,
    ORIGAMI_OT_resume_queue,
    ORIGAMI_OT_leave_queue,
    ORIGAMI_OT_rectify_next,
)
