"""What must run, from which stage on, on what and with which settings, as a function of what is known of a document.

A run of the command line knows nothing yet; a document in Blender may have stages done, settings changed and parts
edited by hand since.
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
    """Nothing is to run; the text says why."""


@dataclass(frozen=True)
class Known:
    """What is known of a document; at first only which photos to use, with which settings.

    Attributes
    ----------
    photos : tuple of str
        The files to use.
    settings : RunSettings
        Those to use.
    wanted, done : mapping of str to str
        The settings that a stage depends on, as text to compare: those to use, and of each stage that is done those
        that it was done with.
    placed : tuple of str
        The photos that were placed.
    state, computed : State
        The document as it is now, edits by hand included, and as it was computed.
    edited : set of str
        What was edited by hand since.
    pinned : (N,) array
        Vertices that are to stay where they lie on the page.
    creases : tuple or None
        The ends of the creases that the sheet was built with, where they were given by hand.
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
    """The stages to run, on which photos and with which settings, and the state that the first one begins with.

    Where vertices are pinned, two at least, the sheet is unwrapped around where these lie on the page, which stays as
    it is laid out.
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
    """The first stage that is not done or would now give something else; None where all are up to date."""
    stale = {EFFECT[part] for part in known.edited}
    stale |= {stage for stage in STAGES if stage not in known.done or known.done[stage] != known.wanted.get(stage)}
    if known.photos != known.placed:
        stale.add(STAGES[0])
    return min(stale, key=STAGES.index, default=None)


def plan_all(known: Known) -> Plan:
    """From the first stage on that is not up to date, with the creases that were given by hand.

    A photo that is another reference has its creases elsewhere.

    Raises
    ------
    NothingToDo
    """
    first = first_stale(known)
    if first is None:
        raise NothingToDo("Everything is up to date: change a setting or mend something first")
    same_photo = STAGES.index(first) > STAGES.index("find")
    return plan(known, STAGES[STAGES.index(first) :], creases=known.creases if same_photo else None)


def plan_stage(known: Known, stage: Stage) -> Plan:
    """One stage by itself; unwrapping and making the page include laying it out.

    Finding the sheet forgets an outline that was edited, and finding its surface creases that were given.

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
    """Certain stages, and those before them that must run too, so that what was edited by hand counts.

    Parameters
    ----------
    known : Known
    stages : sequence of str
        In their order, without a gap.
    creases : sequence, optional
        The ends of all creases in the reference photo, to build the sheet with.
    keeps_outline : bool
        Whether the sheet is cut out along an outline that was edited; otherwise it is found again.

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
        # Points that were deleted count from the surface on; where that does not run they wait.
        known.state if builds or "points" not in known.edited else known.computed,
        known.pinned if "unwrap" in stages and not builds and len(known.pinned) >= _FEWEST_PINS else _NO_PINS,
    )
