"""Which stages of a document no longer hold: settings, photos or what was mended by hand have changed since."""

from __future__ import annotations

import json
from typing import Any

import bpy

from ...core.setting import declarations
from ..settings import RunSettings
from ..stages import EFFECT, STAGES
from .document import Document
from .properties import settings_to_json
from .read_back import ReadBack


def first_stale(document: Document, read: ReadBack) -> str | None:
    """The first stage that is not done or would now give something else; None where all are up to date."""
    group = document.collection.origami
    settings = settings_to_json(group.settings)
    stale = {EFFECT[each] for each in read.edited}
    if photos_in_use(document) != json.loads(group.photos_placed):
        stale.add(STAGES[0])
    for stage in STAGES:
        told = getattr(group, stage)
        if not told.done or told.settings != settings_of(stage, settings):
            stale.add(stage)
    return min(stale, key=STAGES.index, default=None)


def photos_in_use(document: Document) -> list[str]:
    """The paths of the photos that the user has not left out."""
    return [bpy.path.abspath(photo.path) for photo in document.collection.origami.photos if photo.use]


def settings_of(stage: str, settings: dict[str, Any]) -> str:
    """The settings that a stage depends on beside those before it, as text to compare."""
    names = [each.name for each in declarations(RunSettings) if each.stage == stage]
    return json.dumps({name: settings[name] for name in names if name in settings}, sort_keys=True)
