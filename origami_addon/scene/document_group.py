"""Fills in what the panel shows of a document from the command line: its photos, its settings and its stages."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import bpy

from ..files.photos import Photo
from ..report import Report, plain
from ..settings import RunSettings
from ..stages import STAGES, about
from ..state import Placed
from .document import Document
from .known import settings_of
from .listed_photos import note_photos
from .settings_group import settings_from, settings_to_json

# The report's warnings about the photos themselves belong to the first stage.
_READ = "read photos"


def fill_group(
    document: Document,
    photos: Sequence[Photo],
    settings: RunSettings,
    report: Report,
    sharpness: Mapping[str, float],
) -> None:
    """Note the inputs and the results of a run in the document's collection.

    Parameters
    ----------
    document : Document
    photos : sequence of Photo
    settings : RunSettings
    report : Report
        The report of the run up to the page image.
    sharpness : mapping of str to float
        Of the placed photos by their names, as `image.sharpness` gives it.
    """
    group = document.collection.origami
    settings_from(group.settings, settings)
    for photo in photos:
        added = group.photos.add()
        added.name, added.path = photo.name, str(photo.path.resolve())
    note_photos(document, document.reached(Placed).model, sharpness)
    group.photos_placed = json.dumps([photo.path for photo in group.photos])
    group.outline_by_hand = settings.outline is not None
    group.creases = "" if settings.creases is None else json.dumps(settings.creases)
    settings_json = settings_to_json(group.settings)
    for stage in STAGES:
        record = getattr(group, stage)
        record.done = True
        record.figures = json.dumps(plain(_figures(report, about(stage).reported)))
        record.seconds = sum(each["seconds"] for each in report.stages if each["name"] == about(stage).reported)
        record.settings = settings_of(stage, settings_json)
        names = (_READ, about(stage).reported) if stage == STAGES[0] else (about(stage).reported,)
        record.warnings = json.dumps(
            [each for step in report.stages if step["name"] in names for each in step["warnings"]]
        )
    bpy.context.scene.origami.document = document.collection


def _figures(report: Report, name: str) -> Mapping[str, Any]:
    return next((stage["figures"] for stage in report.stages if stage["name"] == name), {})
