"""The panel's texts about a stage: whether it is up to date, and its result in a line or two."""

from __future__ import annotations

from dataclasses import dataclass

from ..scene.document import Document
from ..scene.edits import edits
from ..scene.known import settings_of
from ..scene.settings_group import settings_to_json
from ..stages import EFFECT, STAGES

_LEAST_SECONDS = 0.05  # a shorter time, as of a kept result, would read 0.0


@dataclass(frozen=True)
class StageState:
    """Whether a stage is up to date.

    Attributes
    ----------
    text : str
    icon : str
        Blender's name for it.
    """

    text: str
    icon: str


def state_of(document: Document, stage: str) -> StageState:
    """Whether a stage of the document is up to date, without reading the scene's meshes."""
    group = document.collection.origami
    record = getattr(group, stage)
    if not record.done:
        return StageState("Not done yet", "RADIOBUT_OFF")
    if any(STAGES.index(EFFECT[each]) <= STAGES.index(stage) for each in edits(document)):
        return StageState("Edited by hand: re-run from here", "FILE_REFRESH")
    settings = settings_to_json(group.settings)
    if record.settings != settings_of(stage, settings):
        return StageState("Settings changed since: re-run from here", "FILE_REFRESH")
    how_long = f" in {record.seconds:.1f} s" if record.seconds >= _LEAST_SECONDS else ""
    return StageState(f"Done{how_long}", "CHECKMARK")


def crease_text(angle: float | None) -> str:
    """The kind of a crease from its fold angle in degrees; None if it could not be measured."""
    if angle is None:
        return "fold unknown"
    return f"{'valley' if angle > 0 else 'mountain'}, {abs(angle):.0f}°"
