"""A user who does anything in any order: presses what the tab offers, undoes, deletes, changes modes, opens files.

Every action is printed before it is done, so Blender's log ends with the one that crashed it.
"""

from __future__ import annotations

import random
import shutil
import time
from collections import Counter
from pathlib import Path

import bpy

from .hands import Waits
from .monkey_acts import ACTS
from .monkey_deeds import ELSEWHERE
from .random_user import Monkey
from .user import STAGES, User

_SEEDS = (1, 2, 3, 4)
_ACTIONS = 500  # with each seed
_SETTLE_SECONDS = 3.0


def scene(user: User) -> Waits:
    """Random actions over three documents, each round from the same file; then all that is left can be finished."""
    home = yield from _three_documents(user)
    for seed in _SEEDS:
        yield from user.open(home)
        yield from user.hands.show_tab("Origami")
        yield from _round(user, home, seed)


def _three_documents(user: User) -> Waits:
    """A .blend with a finished document, one up to its outline, and one of photos alone."""
    home = user.folder / "three_documents.blend"
    if home.exists():
        return home
    shutil.copytree(user.folder / "two_sheets", user.folder / "shelf" / "sheet")
    yield from user.two_sheets("page")
    photos = f"{user.folder / 'two_sheets'}/"
    for name in ("second", "third"):
        with user.hands.at():
            bpy.context.view_layer.objects.active = None
            bpy.ops.origami.add_photos(directory=photos, preset="sheet", new=True)
            bpy.ops.ed.undo_push(message="Document Photos")
        if name == "second":
            user.group().settings.sheet = 2
            for stage in STAGES[:2]:
                with user.hands.at():
                    bpy.ops.origami.run_stage("INVOKE_DEFAULT", stage=stage)
                yield from user.wait_for_end()
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    bpy.ops.wm.save_as_mainfile(filepath=str(user.folder / ELSEWHERE), copy=True)
    user.check("three documents", len(user.module("scene.document").documents()) == 3)
    return home


def _round(user: User, home: Path, seed: int) -> Waits:
    monkey = Monkey(user, random.Random(seed), home)
    names, weights = list(ACTS), [each.weight for each in ACTS.values()]
    done: Counter[str] = Counter()
    begun, jobs = time.monotonic(), user.module("jobs.running").ended()
    for number in range(_ACTIONS):
        (name,) = monkey.random.choices(names, weights)
        monkey.now = f"{seed}.{number} {name}"
        before = monkey.documents()
        yield from monkey.ready(ACTS[name])
        yield from ACTS[name].act(monkey)
        done[name] += 1
        yield monkey.random.choice((0.05, 0.05, 0.1, 0.3))
        monkey.look(before, may_lose=ACTS[name].may_lose)
    pressed = ", ".join(f"{name} {count}" for name, count in done.most_common())
    user.check(f"round {seed}: {_ACTIONS} actions", True, f"{time.monotonic() - begun:.0f} s: {pressed}")
    user.check(
        "  with jobs among them", user.module("jobs.running").ended() > jobs, user.module("jobs.running").ended() - jobs
    )
    yield from monkey.end_all()
    user.check("  no fault", not monkey.faults, "\n".join(dict.fromkeys(monkey.faults)))
    user.check("  nothing runs or waits any more", user.running() is None and user.modal() == [], user.modal())
    user.check("  failures are sentences", not monkey.internal(), monkey.internal())
    yield from _finish(user, monkey)


def _finish(user: User, monkey: Monkey) -> Waits:
    """Each document that is left can be made to its end, or the user is told why not."""
    for name in sorted(monkey.documents()):
        document = user.module("scene.document").find_document(name)
        with user.hands.at():
            bpy.context.view_layer.objects.active = None
            bpy.context.scene.origami.document = document.collection
        if user.document() is None or user.document().name != name:
            user.check(f"  {name} can be chosen", False)
            continue
        said = monkey.press("rectify", {})
        yield 0.3
        yield from user.wait_for_end()
        failure = user.module("jobs.running").failure()
        sentence = failure.sentence if failure else said
        if monkey.exists(name):
            user.check(f"  {name} is finished or says why not", user.done() == list(STAGES) or sentence, sentence)
    path = user.folder / "monkey_end.blend"
    before = monkey.documents()
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    yield from user.open(path)
    user.check("  all is there after saving and opening", monkey.documents() == before, before)
    user.check("  no fault in the end", not monkey.faults and not monkey.internal(), monkey.internal())
