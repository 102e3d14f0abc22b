"""A movie in a document's list: its photos take its place."""

from __future__ import annotations

import bpy
import pytest


@pytest.fixture
def document(add_on, tmp_path):
    """A document with a photo, a movie and a photo; the files are what they are by their first bytes."""
    for name in ("1.jpg", "9.jpg"):
        (tmp_path / name).write_bytes(b"\xff\xd8")
    (tmp_path / "5.mov").write_bytes(b"\0\0\0\x08wide\0\0\0\x10mdat" + bytes(8))
    files = [{"name": name} for name in ("1.jpg", "5.mov", "9.jpg")]
    assert bpy.ops.origami.add_photos(directory=str(tmp_path), files=files, new=True) == {"FINISHED"}
    from origami.origami_addon.scene.chosen import active_document

    return active_document(bpy.context)


def test_photos_take_the_place_of_their_movie(document, tmp_path):
    from origami.origami_addon.scene.listed_photos import list_movie_photos

    group = document.collection.origami
    assert [photo.name for photo in group.photos] == ["1.jpg", "5.mov", "9.jpg"]
    group.photos[0].use = False
    movie, taken = str(tmp_path / "5.mov"), [str(tmp_path / "5 ab" / name) for name in ("5-1.png", "5-8.png")]
    used = list_movie_photos(document, [movie, str(tmp_path / "9.jpg")], {movie: taken})
    assert used == (*taken, str(tmp_path / "9.jpg"))
    assert [photo.name for photo in group.photos] == ["1.jpg", "5-1.png", "5-8.png", "9.jpg"]
    assert [photo.use for photo in group.photos] == [False, True, True, True]


def test_a_list_without_movies_stays(document, tmp_path):
    from origami.origami_addon.scene.listed_photos import list_movie_photos

    used = [str(tmp_path / "1.jpg")]
    assert list_movie_photos(document, used, {}) == tuple(used)
    assert len(document.collection.origami.photos) == 3
