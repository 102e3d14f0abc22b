"""What the panel says of a stage: whether it is up to date, and its result in a line or two."""

from __future__ import annotations

from dataclasses import dataclass

from ..scene.document import Document
from ..scene.edits import edits
from ..scene.known import settings_of
from ..scene.properties import settings_to_json
from ..stages import EFFECT, STAGES


@dataclass(frozen=True)
class StageState:
    """How a stage stands.

    Attributes
    ----------
    text : str
    icon : str
        Blender's name of it.
    """

    text: str
    icon: str


def state_of(document: Document, stage: str) -> StageState:
    """How a stage of the document stands, without reading the scene's meshes."""
    group = document.collection.origami
    told = getattr(group, stage)
    if not told.done:
        return StageState("Not done yet", "RADIOBUT_OFF")
    if any(STAGES.index(EFFECT[each]) <= STAGES.index(stage) for each in edits(document)):
        return StageState("Edited by hand: run on from there", "FILE_REFRESH")
    settings = settings_to_json(group.settings)
    if told.settings != settings_of(stage, settings):
        return StageState("Other settings since: run it again", "FILE_REFRESH")
    return StageState(f"Done in {told.seconds:.1f} s", "CHECKMARK")


def crease_text(angle: float | None) -> str:
    """What a crease is, by its fold angle in degrees; None where that could not be measured."""
    if angle is None:
        return "fold unknown"
    return f"{'valley' if angle > 0 else 'mountain'}, {abs(angle):.0f}°"
