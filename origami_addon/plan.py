"""Decides which stages must run, on what and with which settings, from what is known of a document.

A run of the command line knows nothing at first; a document in Blender may have finished stages, changed settings and
parts edited by hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..core.arrays import Indices
from .settings import RunSettings
from .stages import EFFECT, STAGES, Part, Stage
from .state import AFTER, Found, State, reached

Crease = tuple[float, float, float, float]
_NO_PINS = np.zeros(0, np.int64)
_FEWEST_PINS = 2  # one fixes neither size nor direction


class NothingToDo(Exception):
    """Nothing needs to run; the text says why."""


@dataclass(frozen=True)
class Known:
    """What is known of a document; at first only the photos and the settings.

    Attributes
    ----------
    photos : tuple of str
        The files to use.
    settings : RunSettings
        Those to use.
    wanted, done : mapping of str to str
        The settings on which each stage depends, as text to compare: those to use, and those with which each finished
        stage ran.
    placed : tuple of str
        The photos that were placed.
    state, computed : State
        The document as it is now, with edits by hand, and as it was computed.
    edited : set of str
        The parts edited by hand since then.
    pinned : (N,) array
        Vertices that must keep their places on the page.
    creases : tuple or None
        The ends of the creases with which the sheet was built, if they were given by hand.
    """

    photos: tuple[str, ...]
    settings: RunSettings
    wanted: Mapping[str, str] = field(default_factory=dict)
    done: Mapping[str, str] = field(default_factory=dict)
    placed: tuple[str, ...] = ()
    state: State = State()
    computed: State = State()
    edited: frozenset[Part] = frozenset()
    pinned: Indices = field(default_factory=lambda: _NO_PINS)
    creases: tuple[Crease, ...] | None = None


@dataclass(frozen=True)
class Plan:
    """The stages to run, with which photos and settings, and the state from which the first one starts.

    If two or more vertices are pinned, the sheet is unwrapped around them and the page keeps its layout.
    """

    stages: tuple[Stage, ...]
    photos: tuple[str, ...]
    settings: RunSettings
    start: State
    pinned: Indices

    @property
    def places_photos(self) -> bool:
        """Whether the photos are placed: all begins there."""
        return self.stages[0] == STAGES[0]


def first_stale(known: Known) -> Stage | None:
    """The first stage that is not done or would now give a different result; None if all are up to date."""
    stale = {EFFECT[part] for part in known.edited}
    stale |= {stage for stage in STAGES if stage not in known.done or known.done[stage] != known.wanted.get(stage)}
    if known.photos != known.placed:
        stale.add(STAGES[0])
    return min(stale, key=STAGES.index, default=None)


def plan_all(known: Known) -> Plan:
    """All stages from the first one that is not up to date, with the creases given by hand.

    Given creases do not apply to a different reference photo.

    Raises
    ------
    NothingToDo
    """
    first = first_stale(known)
    if first is None:
        raise NothingToDo("Everything is up to date: change a setting or edit something first")
    same_photo = STAGES.index(first) > STAGES.index("find")
    return plan(known, STAGES[STAGES.index(first) :], creases=known.creases if same_photo else None)


def plan_stage(known: Known, stage: Stage) -> Plan:
    """A single stage; unwrapping and making the page include the layout.

    Finding the sheet discards an edited outline, and finding its surface discards given creases.

    Raises
    ------
    UsageError
        If a stage before it is not done.
    """
    stages: tuple[Stage, ...] = (stage,)
    if stage == "unwrap":
        stages = ("unwrap", "lay_out")
    elif stage == "page" and first_stale(known) == "lay_out":
        stages = ("lay_out", "page")
    return plan(known, stages, keeps_outline=stage != "find")


def plan(
    known: Known, stages: Sequence[Stage], *, creases: Sequence[Crease] | None = None, keeps_outline: bool = True
) -> Plan:
    """Some stages, and the stages before them that must run too for edits by hand to count.

    Parameters
    ----------
    known : Known
    stages : sequence of str
        In order, without a gap.
    creases : sequence, optional
        The ends of all creases in the reference photo, with which to build the sheet.
    keeps_outline : bool
        Whether the sheet is cut out along an edited outline; otherwise it is found again.

    Raises
    ------
    UsageError
        If a stage before them is not done.
    """
    begin = STAGES.index(stages[0])
    first = min([begin, *(STAGES.index(EFFECT[part]) for part in known.edited)])
    if first > 0:
        reached(known.state, AFTER[STAGES[first - 1]])
    if STAGES[first] == "surface" and "outline" in known.edited:
        first = STAGES.index("find")
    stages = (*STAGES[first:begin], *stages)
    settings = known.settings
    builds, given = "surface" in stages, "outline" in known.edited and keeps_outline
    if stages[0] == "find" and given and known.done.get("find") == known.wanted["find"]:
        found = reached(known.state, Found)
        corners = tuple((x, y) for x, y in found.region.outline.polygon.tolist())
        settings = replace(settings, reference=found.reference.name, outline=corners)
    if builds and creases is not None:
        settings = replace(settings, reference=reached(known.state, Found).reference.name, creases=tuple(creases))
    return Plan(
        stages,
        known.photos if stages[0] == STAGES[0] else known.placed,
        settings,
        # Deleted points affect the surface and later stages; if the surface does not run, they wait.
        known.state if builds or "points" not in known.edited else known.computed,
        known.pinned if "unwrap" in stages and not builds and len(known.pinned) >= _FEWEST_PINS else _NO_PINS,
    )
