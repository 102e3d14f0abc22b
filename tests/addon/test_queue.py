"""Several documents, one after the other: what waits, what fails, what the user ends."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from origami.origami_addon.jobs import running
from origami.origami_addon.jobs.queue import Queue, queue, seconds_left
from origami.origami_addon.scene.document import documents, remove_document
from origami.origami_addon.window.document_list import waiting


@pytest.fixture
def folders(tmp_path):
    """Two folders of files that are photos by their names, one of texts, an empty one and a hidden one."""
    for name, file in (("a", "1.jpg"), ("b", "1.jpg"), ("texts", "1.txt"), (".hidden", "1.jpg")):
        (tmp_path / name).mkdir()
        (tmp_path / name / file).write_bytes(name.encode())
    (tmp_path / "empty").mkdir()
    return tmp_path


@pytest.fixture
def begun(add_on, monkeypatch):
    """The names of the documents whose runs are begun, instead of running them."""
    from origami.origami_addon.operators import queue as operators

    names: list[str] = []
    genuine = operators.start

    def started(operator, other, **given):
        if "name" not in given:
            return genuine(operator, other, **given)
        names.append(given["name"])
        return True

    monkeypatch.setattr(operators, "start", started)
    yield names
    queue.clear()


def add(folder, *names, **options):
    """As the dialog does it, with these folders ticked."""
    return bpy.ops.origami.start_folders(folders=[ticked(folder / name) for name in names], **options)


def ticked(folder, use=True):
    """A line of the dialog."""
    return {"name": str(folder), "photos": 1, "known": False, "use": use}


def test_each_folder_becomes_a_document_and_a_broken_one_says_why(begun, folders):
    assert add(folders, "a", "texts", "b", "empty", "gone") == {"FINISHED"}
    assert [each.title for each in documents()] == ["a", "b", "empty", "gone", "texts"]
    assert begun == ["a", "b"]
    counts = {each.title: len(each.collection.origami.photos) for each in documents()}
    assert counts == {"a": 1, "b": 1, "empty": 0, "gone": 0, "texts": 0}
    for name in ("texts", "empty", "gone"):
        sentence = running.failure_of(name).sentence
        assert str(folders / name) in sentence, sentence
    assert "There are no photos" in running.failure_of("empty").sentence
    assert "cannot be read" in running.failure_of("gone").sentence
    assert running.failure_of("a") is None
    assert bpy.context.scene.origami.document.name == "a"


def test_the_folders_inside_a_folder_are_found(begun, folders, monkeypatch):
    """Those with photos are ticked; hidden ones and Origami's results are not among them."""
    from origami.origami_addon.files.marker import MARKER
    from origami.origami_addon.operators import queue as operators

    (folders / "results").mkdir()
    (folders / "results" / MARKER).write_text("{}")
    (folders / "results" / "page.jpg").write_bytes(b"")
    asked = []
    monkeypatch.setattr(operators, "start", lambda operator, other, folders: asked.append(folders) or True)
    assert bpy.ops.origami.add_folders(directory=f"{folders}/") == {"FINISHED"}
    assert [(each["name"], each["photos"], each["use"]) for each in asked[0]] == [
        (str(folders / "a"), 1, True),
        (str(folders / "b"), 1, True),
        (str(folders / "empty"), 0, False),
        (str(folders / "texts"), 0, False),
    ]
    # One that holds photos itself is taken; folders selected in the file browser are those ticked.
    bpy.ops.origami.add_folders(directory=f"{folders / 'a'}/", dirs=[{"name": f"{folders / 'a'}/"}])
    assert [(each["name"], each["use"]) for each in asked[1]] == [(str(folders / "a"), True)]
    bpy.ops.origami.add_folders(directory=f"{folders}/", dirs=[{"name": "b"}, {"name": "empty"}])
    assert [Path(each["name"]).name for each in asked[2] if each["use"]] == ["b"]
    for folder, what in ((folders / "empty", "No folder in"), (folders / "gone", "cannot be read")):
        with pytest.raises(RuntimeError, match=what):
            bpy.ops.origami.add_folders(directory=f"{folder}/")
    assert not documents()


def test_a_folder_that_has_a_document_is_not_ticked_again(begun, folders):
    add(folders, "a", rectify=False)
    bpy.ops.origami.add_folders(directory=f"{folders}/")
    assert sorted(each.title for each in documents()) == ["a", "b"]
    link = folders.parent / "link"
    link.symlink_to(folders, target_is_directory=True)
    for path in (folders, link):
        with pytest.raises(RuntimeError, match="No folder is chosen"):
            bpy.ops.origami.add_folders(directory=f"{path}/")
    bpy.ops.origami.add_folders(directory=f"{folders}/", dirs=[{"name": "a"}])
    assert sorted(each.title for each in documents()) == ["a", "a.001", "b"]


def test_a_script_takes_them_without_a_question(begun, folders):
    assert bpy.ops.origami.add_folders(directory=f"{folders}/") == {"FINISHED"}
    assert (sorted(each.title for each in documents()), begun) == (["a", "b"], ["a", "b"])
    with pytest.raises(RuntimeError, match="No folder is chosen"):
        bpy.ops.origami.start_folders(folders=[ticked(folders / "a", use=False)])


def test_rectify_all_takes_every_document_once(begun, folders):
    with pytest.raises(RuntimeError, match="Add the photos of a sheet first"):
        bpy.ops.origami.rectify_all()
    add(folders, "a", "b", rectify=False)
    assert begun == []
    bpy.ops.origami.rectify_all()
    assert begun == ["a", "b"]


def test_documents_that_are_gone_are_passed_over(begun, folders):
    add(folders, "a", "b", rectify=False)
    queue.add(["gone"])
    queue.add(["b"])
    queue.paused = True
    assert waiting() == 1
    remove_document("a")
    bpy.ops.origami.resume_queue()
    assert begun == ["b"]
    assert not bpy.ops.origami.resume_queue.poll()


def test_a_failed_run_does_not_stop_the_next(add_on, folders):
    """These files are no photos, whatever their names say; each run is refused, and says why."""
    with pytest.raises(RuntimeError):
        add(folders, "a", "b")
    assert running.current() is None and not queue.waiting
    for name in ("a", "b"):
        assert "photo" in running.failure_of(name).sentence
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert running.failure_of("a") is None


def test_the_user_ends_a_run_and_resumes():
    several = Queue()
    several.add(["a", "b", "a"])
    several.add(["b", "c"])
    assert several.take() == "a"
    several.pause("a")
    assert (several.waiting, several.take()) == (["a", "b", "c"], None)
    several.leave("b")
    several.resume()
    assert [several.take() for _ in range(3)] == ["a", "c", None]


def test_the_time_left_comes_from_finished_runs_or_from_this_one():
    now, two = running.Running(None, "Rectify", "a"), Queue(["b", "c"])
    now.begun -= 30
    assert seconds_left(now) is None and two.seconds_left(now, 2) is None
    now.fraction = 0.25
    assert seconds_left(now) == pytest.approx(90, abs=1)
    assert two.seconds_left(now, 2) == pytest.approx(240, abs=2)
    two.finished(40)
    two.finished(60)
    assert two.seconds_left(now, 2) == pytest.approx(100)
