"""A user with photos: the common part of the scenes."""

from __future__ import annotations

import hashlib
import json
import time
from pathlib import Path
from typing import Any

import bpy

from .hands import Hands, Waits
from .held import Held

ADD_ON = "bl_ext.user_default.origami"
STAGES = ("place", "find", "surface", "unwrap", "lay_out", "page")
_PATIENCE_SECONDS = 900


class User:
    """Hands, a watch, and a folder with photos."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.photos = folder / "trifold_letter"
        self.held = Held(ADD_ON)
        steps = [step.__name__.strip("_").lower() for step in self.held.module("window.step_panels").STEP_PANELS]
        self.hands = Hands(folder / "pictures", steps)
        self.shown: list[dict[str, Any]] = []

    def module(self, name: str) -> Any:
        """A module of the add-on."""
        return self.held.module(name)

    def check(self, what: str, holds: bool, value: object = "") -> None:
        """Record a check; the scene continues either way."""
        self.shown.append({"what": what, "holds": bool(holds), "value": str(value)})
        print(f"  {'ok  ' if holds else 'FAIL'} {what} {value}", flush=True)

    def two_sheets(self, last_stage: str) -> Waits:
        """A .blend with Blender's default cube and a document of two sheets, finished up to this stage."""
        path = self.folder / f"two_sheets_{last_stage}.blend"
        if path.exists():
            return path
        yield from self.hands.open(None)
        with self.hands.at():
            bpy.ops.origami.add_photos(directory=f"{self.folder / 'two_sheets'}/", preset="sheet", new=True)
            bpy.ops.ed.undo_push(message="Document Photos")
        stages = STAGES[: STAGES.index(last_stage) + 1]
        for stage in stages:
            if not getattr(self.group(), stage).done:
                with self.hands.at():
                    bpy.ops.origami.run_stage("INVOKE_DEFAULT", stage=stage)
                yield from self.wait_for_end()
        self.check(f"two sheets: {last_stage} is done", self.done() == list(stages), self.done())
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        return path

    def new_file(self) -> Waits:
        """Begin a new file, with the tab open."""
        yield from self.hands.open(None)
        self.hands.forget_places()
        yield from self.hands.show_tab("Origami")

    def open(self, path: Path) -> Waits:
        """Open a file, with the mouse over its 3D view."""
        yield from self.hands.open(path)
        yield from self.hands.over()

    def delete_document(self) -> None:
        """Delete the document that the panel shows."""
        self.module("scene.document").remove_document(self.document().name)

    def choose_another_document(self) -> None:
        """Make an empty second document, and choose it."""
        another = self.module("scene.document").new_document("second", bpy.context.scene)
        bpy.context.view_layer.objects.active = None
        bpy.context.scene.origami.document = another.collection

    def forget_all_but_the_model(self) -> None:
        """Remove everything after the placed photos, like Undo."""
        document = self.document()
        document.state = self.module("state").Placed(document.state.model)

    def document(self) -> Any:
        """The document in the panel."""
        return self.module("scene.chosen").active_document(bpy.context)

    def group(self) -> Any:
        """Its settings and stages."""
        return self.document().collection.origami

    def settings(self) -> str:
        """Its settings as JSON."""
        return json.dumps(self.module("scene.settings_group").settings_to_json(self.group().settings))

    def done(self) -> list[str]:
        """Which of its stages are done."""
        return [stage for stage in STAGES if getattr(self.group(), stage).done]

    def state_digest(self) -> str:
        """A digest that changes with the document's state and its objects."""
        document = self.document()
        digest = hashlib.sha256(bytes(document.collection.get("origami_state", b"")))
        for each in sorted(document.collection.all_objects, key=lambda each: each.name):
            digest.update(f"{each.name} {[round(v, 5) for row in each.matrix_world for v in row]}".encode())
            if each.type == "MESH":
                digest.update(f"{len(each.data.vertices)} {len(each.data.uv_layers)}".encode())
        for stage in STAGES:
            record = getattr(self.group(), stage)
            digest.update(f"{record.done} {record.figures} {record.settings}".encode())
        return digest.hexdigest()[:12]

    def running(self) -> Any:
        """The job that runs, or None."""
        return self.module("jobs.running").current()

    def modal(self) -> list[str]:
        """The add-on's modal operators; none may be there twice."""
        held = self.hands.window.modal_operators
        assert len({each.as_pointer() for each in held}) == len(held), [each.bl_idname for each in held]
        return [each.bl_idname for each in held if each.bl_idname.startswith("ORIGAMI")]

    def wait_for_text(self, *words: str) -> Waits:
        """Wait until the running job reports one of these texts."""
        until = time.monotonic() + _PATIENCE_SECONDS
        while time.monotonic() < until:
            now = self.running()
            assert now is not None, f"the job ended before it reported {words}"
            if any(word in now.text for word in words):
                return
            yield 0.02
        raise AssertionError(f"nothing reported {words}")

    def wait_for_end(self) -> Waits:
        """Wait until no job runs."""
        until = time.monotonic() + _PATIENCE_SECONDS
        while self.running() is not None:
            assert time.monotonic() < until, f"still at {self.running().text}"
            yield 0.1
        yield 1.0

    def calm_down(self) -> Waits:
        """After a failure: close what is open and end what is running."""
        for _ in range(3):
            yield from self.hands.key("ESC")
        self.module("jobs.running").end()
        yield 1.0
