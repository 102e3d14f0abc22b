"""Views of a finished document: through a camera, in colours, its outline edited, in the UV editor, during export."""

from __future__ import annotations

import bmesh
import bpy

from .hands import Waits
from .user import User

_MOUSE_MAY_WAIT = 2.0  # seconds until a redraw under software OpenGL is done
_FOLDERS_SHARE = 0.68  # of the file browser's width
_PATCH = 0.1, 0.62, 0.74, 0.96  # of the page: from and to, across and up


def scene(user: User) -> Waits:
    """Each view of each step, by its button."""
    yield from _through_camera(user)
    yield from _colors(user)
    yield from _outline(user)
    yield from _export(user)
    yield from _uv_editor(user)


def _press_in(user: User, step: str, *buttons: str) -> Waits:
    """Open a step, press buttons in it, close it."""
    yield from user.hands.toggle(step)
    for button in buttons:
        yield from user.hands.press(button)
    yield from user.hands.toggle(step)


def _view_picture(user: User, name: str) -> Waits:
    yield _MOUSE_MAY_WAIT
    hands = user.hands
    area = hands.area()
    box = area.x, hands.window.height - area.y - area.height, area.width, area.height
    hands.picture(name, box, percent=75)


def _through_camera(user: User) -> Waits:
    yield from _press_in(user, "photos", "bpy.ops.origami.look_through")
    view = user.hands.area().spaces.active.region_3d
    user.check("the view looks through the chosen photo's camera", view.view_perspective == "CAMERA")
    yield from user.hands.over()
    yield from _view_picture(user, "through_camera")
    yield from user.hands.key("NUMPAD_0")
    yield 1.0
    user.check("and leaves it again", view.view_perspective != "CAMERA")


def _colors(user: User) -> Waits:
    with user.hands.at():
        bpy.ops.origami.show_as(way="PAGE")
    yield from _press_in(user, "unwrap", "show_sheet(by='VERTEX')")
    yield from user.hands.over()
    yield from _view_picture(user, "stretch")
    shading = user.hands.area().spaces.active.shading
    user.check("the sheet is coloured by its stretch", shading.color_type == "VERTEX")
    perspective = user.hands.area().spaces.active.region_3d.view_perspective
    user.check("and looked at, where the view showed the page", perspective == "PERSP", perspective)
    user.check("looking at it is no edit", not user.module("scene.edits").edits(user.document()))
    yield from _press_in(user, "quality", "show_sheet(by='BOUND')")
    yield from user.hands.over()
    yield from _view_picture(user, "accuracy")
    yield from _press_in(user, "unwrap", "bpy.ops.origami.show_sheet(by='TEXTURE')")
    yield from user.hands.over()
    yield from _view_picture(user, "creases")
    yield from _press_in(user, "placing", "origami.show_errors")
    user.check("the points are shown by their error", bpy.context.scene.origami.show_errors)
    yield from user.hands.over()
    yield from _view_picture(user, "points_by_error")
    yield from _press_in(user, "placing", "origami.show_errors")


def _outline(user: User) -> Waits:
    yield from _press_in(user, "sheet", "bpy.ops.origami.edit_outline")
    user.check("the outline is edited over its photo", bpy.context.mode == "EDIT_CURVE", bpy.context.mode)
    yield from user.hands.over()
    yield from _view_picture(user, "outline_edit")
    yield from user.hands.key("TAB")
    yield from user.hands.key("NUMPAD_0")
    yield 1.0
    user.check("looking at the outline changes nothing", not user.module("scene.edits").edits(user.document()))


def _export(user: User) -> Waits:
    hands = user.hands
    yield from hands.toggle("export")
    yield from hands.press("bpy.ops.origami.export(")
    yield 3.0
    windows = bpy.context.window_manager.windows
    browser = windows[-1]
    user.check("the export asks for a folder", len(windows) == 2)
    area = next(area for area in browser.screen.areas if area.type == "FILE_BROWSER")
    out = user.folder / "exported"
    out.mkdir()
    area.spaces.active.params.directory = f"{out}/".encode()
    yield 2.0
    left, top, width, height = hands.box(browser)
    hidden = int(_FOLDERS_SHARE * width)  # folders of the machine on which the scenes are played
    hands.picture("step_export", (left + hidden, top, width - hidden, height))
    with bpy.context.temp_override(window=browser, area=area):
        bpy.ops.file.execute("INVOKE_DEFAULT")
    yield 0.5
    user.check("the export runs in the background", user.running() is not None)
    yield from user.wait_for_end()
    names = sorted(path.name for path in out.iterdir())
    user.check("the files are there", {"page.tif", "page.jpg", "sheet.glb"} <= set(names), ", ".join(names))
    yield from hands.toggle("export")


def _select_patch() -> None:
    """Select the faces of a part of the page, the only ones that the UV editor then shows."""
    bpy.context.scene.tool_settings.use_uv_select_sync = False
    mesh = bmesh.from_edit_mesh(bpy.context.object.data)
    layer = mesh.loops.layers.uv["page"]
    for face in mesh.faces:
        u, v = face.loops[0][layer].uv
        face.select_set(_PATCH[0] < u < _PATCH[1] and _PATCH[2] < v < _PATCH[3])
    bmesh.update_edit_mesh(bpy.context.object.data)


def _uv_editor(user: User) -> Waits:
    hands = user.hands
    hands.window.workspace = bpy.data.workspaces["UV Editing"]
    yield 2.0
    if bpy.context.mode == "OBJECT":
        yield from hands.over()
        yield from hands.key("TAB")
    yield from hands.show_tab("Origami", "IMAGE_EDITOR")
    yield from hands.press("show_as(way='PAGE')", "IMAGE_EDITOR")
    image = hands.area("IMAGE_EDITOR").spaces.active.image
    user.check("the UV editor shows the page", image is not None and "page" in image.name)
    if bpy.context.mode == "OBJECT":
        yield from hands.over()
        yield from hands.key("TAB")
    yield from hands.over()
    yield from hands.key("THREE")
    _select_patch()
    yield from hands.over(area="IMAGE_EDITOR")
    yield from hands.key("N")
    yield 1.0
    yield from hands.over(area="IMAGE_EDITOR")
    yield from hands.key("HOME")
    yield 1.0
    for _ in range(2):
        yield from hands.key("WHEELUPMOUSE")
    yield _MOUSE_MAY_WAIT
    hands.picture("uv_editor", hands.box(hands.area("IMAGE_EDITOR")), percent=75)
    yield from hands.over()
    yield from hands.key("U")
    yield 0.4
    x, y = hands.mouse
    hands.picture("unwrap_menu", (x - 280, hands.window.height - y - 110, 440, 480))
    yield from hands.key("ESC")
    yield from hands.over()
    yield from hands.key("TAB")
    hands.window.workspace = bpy.data.workspaces["Layout"]
    yield 2.0
    user.check("back in Object Mode", bpy.context.mode == "OBJECT", bpy.context.mode)
