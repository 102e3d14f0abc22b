"""What a document made by the command line says in the panel: its photos, its settings and what each stage did."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import bpy

from ..files.photos import Photo
from ..report import Report, plain
from ..settings import RunSettings
from ..stages import STAGES, about
from .document import Document
from .known import settings_of
from .properties import settings_from, settings_to_json

# What the report says of the photos themselves belongs to the first stage.
_READ = "read photos"


def fill_group(document: Document, photos: Sequence[Photo], settings: RunSettings, report: Report) -> None:
    """Note in the document's collection what a run was given and what it did.

    Parameters
    ----------
    document : Document
    photos : sequence of Photo
    settings : RunSettings
    report : Report
        Of the run up to the page image.
    """
    group = document.collection.origami
    settings_from(group.settings, settings)
    placed = _figures(report, about(STAGES[0]).reported)
    for photo in photos:
        added = group.photos.add()
        added.name, added.path = photo.name, str(photo.path.resolve())
        added.note = "could not be placed" if photo.name in placed.get("photos_left_out", ()) else "placed"
    group.photos_placed = json.dumps([photo.path for photo in group.photos])
    group.outline_by_hand = settings.outline is not None
    group.creases = "" if settings.creases is None else json.dumps(settings.creases)
    as_told = settings_to_json(group.settings)
    for stage in STAGES:
        told = getattr(group, stage)
        told.done = True
        told.figures = json.dumps(plain(_figures(report, about(stage).reported)))
        told.seconds = sum(each["seconds"] for each in report.stages if each["name"] == about(stage).reported)
        told.settings = settings_of(stage, as_told)
        names = (_READ, about(stage).reported) if stage == STAGES[0] else (about(stage).reported,)
        told.warnings = json.dumps(
            [each for step in report.stages if step["name"] in names for each in step["warnings"]]
        )
    bpy.context.scene.origami.document = document.collection


def _figures(report: Report, name: str) -> Mapping[str, Any]:
    return next((stage["figures"] for stage in report.stages if stage["name"] == name), {})
