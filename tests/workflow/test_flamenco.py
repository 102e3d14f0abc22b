"""The job type for Flamenco, compiled as its manager does: with `author`, a job and its settings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

quickjs = pytest.importorskip("quickjs", reason="quickjs-ng, of .ci/requirements-test.txt, is not installed")

# What the manager offers to a job compiler script.
_MANAGER = """
const author = {
    Task(name, type) {
        return {
            name, type, commands: [], dependencies: [],
            addCommand(command) { this.commands.push(command); },
            addDependency(task) { this.dependencies.push(task.name); },
        };
    },
    Command(name, parameters) { return { name, parameters }; },
};
function compiled(settings) {
    const job = { name: "a job", settings, tasks: [], addTask(task) { this.tasks.push(task); } };
    compileJob(job);
    return JSON.stringify(job.tasks);
}
"""
SETTINGS = {
    "photos": "/mnt/photos/",
    "results": "/mnt/results",
    "paper": "A4",
    "dpi": 300,
    "kind": "sheet",
    "light": "white",
    "colour": "grey",
    "documents": "a letter/-b/Ü",
}


@pytest.fixture(scope="module")
def context(root: Path) -> Any:
    """The script in an engine."""
    context = quickjs.Context()
    context.eval(_MANAGER + (root / "flamenco" / "origami_rectify.js").read_text(encoding="utf-8"))
    return context


def compiled(context: Any, **changed: object) -> list[dict[str, Any]]:
    settings = json.dumps(SETTINGS | changed)
    return list(json.loads(context.eval(f"compiled({settings})")))


def test_a_task_for_each_document_and_one_for_the_summary(context: Any) -> None:
    *documents, summary = compiled(context)
    assert [task["name"] for task in documents] == ["a letter", "-b", "Ü"]
    assert summary["dependencies"] == ["a letter", "-b", "Ü"]
    assert {task["type"] for task in (*documents, summary)} == {"blender"}
    assert all(len(task["commands"]) == 1 and task["commands"][0]["name"] == "exec" for task in (*documents, summary))
    assert summary["commands"][0]["parameters"]["args"][-3:] == [
        "{origami}/workflow/scripts/summary.py",
        "--",
        "/mnt/results",
    ]


def test_the_command_of_a_document_is_one_that_origami_takes(context: Any, root: Path) -> None:
    from origami.headless.options import build_parser, settings_from

    command = compiled(context)[1]["commands"][0]["parameters"]
    assert command["exe"] == "{blender}"
    outer, inner = command["args"], command["args"][command["args"].index("{blender}") :]
    recorded = outer[outer.index("--") + 1 :]
    assert recorded[:4] == ["/mnt/results/-b", "document", "--succeed-if-explained", "--"]
    given = build_parser().parse_args(inner[inner.index("--") + 1 :])
    assert (given.photos, given.output, given.resume) == (["/mnt/photos/-b"], "/mnt/results/-b", True)
    settings = settings_from(given)
    assert settings.page.paper_size_mm == (210, 297)
    assert (settings.image.dpi, settings.image.light, settings.image.colour) == (300, "white", "grey")
    for script in (word for word in (*outer, *inner) if word.startswith("{origami}/")):
        assert (root / script.removeprefix("{origami}/")).is_file()


def test_every_choice_is_one_of_origami(context: Any) -> None:
    from origami.core.setting import declaration
    from origami.origami_addon.presets import PRESETS
    from origami.origami_addon.settings import ImageSettings

    declared = {each["key"]: each for each in json.loads(context.eval("JSON.stringify(JOB_TYPE.settings)"))}
    for name in ("light", "colour"):
        words = declaration(ImageSettings, name)
        assert tuple(declared[name]["choices"]) == words.words
        assert declared[name]["default"] == words.default
    assert declared["kind"]["choices"] == list(PRESETS)
    assert (declared["dpi"]["propargs"]["max"]) == declaration(ImageSettings, "dpi").most


def test_the_documents_are_the_folders_that_blender_sees(context: Any, tmp_path: Path) -> None:
    for name in ("b", "a letter", ".hidden", "results"):
        (tmp_path / name).mkdir()
    (tmp_path / "note.txt").touch()
    declared = {each["key"]: each for each in json.loads(context.eval("JSON.stringify(JOB_TYPE.settings)"))}

    class settings:
        photos, results = str(tmp_path), str(tmp_path / "results")

    # As the Blender add-on evaluates: no globals, these locals.
    found = eval(declared["documents"]["eval"], {}, {"settings": settings, "abspath": Path, "Path": Path})
    assert found == "a letter/b"


@pytest.mark.parametrize(("changed", "reason"), [({"documents": ""}, "no folder"), ({"paper": ""}, "needs the size")])
def test_what_cannot_run_is_refused_with_a_sentence(context: Any, changed: dict[str, object], reason: str) -> None:
    with pytest.raises(quickjs.JSException, match=reason):
        compiled(context, **changed)
