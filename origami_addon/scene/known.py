"""What is known of a document in Blender, for `plan.py`."""

from __future__ import annotations

import json
from typing import Any

import bpy

from ...core.setting import declarations
from ..plan import Known
from ..settings import RunSettings
from ..settings_json import from_json
from ..stages import STAGES
from .document import Document
from .read_back import read_back
from .settings_group import settings_to_json


def known_of(document: Document, sheet: int | None = None) -> Known:
    """What is known of a document; its objects leave Edit Mode.

    Parameters
    ----------
    document : Document
    sheet : int, optional
        The number of the sheet to take, if not the one in the settings.

    Raises
    ------
    StepFailed
        If an object has become unusable; the message says what to do.
    """
    group, read = document.collection.origami, read_back(document)
    settings = settings_to_json(group.settings) | ({} if sheet is None else {"sheet": sheet})
    noted = {stage: getattr(group, stage) for stage in STAGES}
    return Known(
        photos=tuple(photos_in_use(document)),
        settings=from_json(settings),
        wanted={stage: settings_of(stage, settings) for stage in STAGES},
        done={stage: each.settings for stage, each in noted.items() if each.done},
        placed=tuple(json.loads(group.photos_placed)),
        state=read.state,
        computed=document.state,
        edited=read.edited,
        pinned=read.pinned,
        creases=tuple((a, b, c, d) for a, b, c, d in json.loads(group.creases)) if group.creases else None,
    )


def photos_in_use(document: Document) -> list[str]:
    """The paths of the photos that the user has not left out."""
    return [bpy.path.abspath(photo.path) for photo in document.collection.origami.photos if photo.use]


def settings_of(stage: str, settings: dict[str, Any]) -> str:
    """The settings on which a stage depends in addition to the stages before it, as text to compare."""
    names = [each.name for each in declarations(RunSettings) if each.stage == stage]
    return json.dumps({name: settings[name] for name in names if name in settings}, sort_keys=True)
