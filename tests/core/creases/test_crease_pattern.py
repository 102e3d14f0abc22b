"""Crease patterns: known planar graphs, those of measured creases, and properties of all of them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import sheets
from origami.core.creases.crease_graph import BORDER, JOIN, CreasePattern, arrange
from origami.core.creases.crease_pattern import assignments, crease_pattern, fold_angles, in_space
from origami.core.numeric.polygon import signed_area
from origami.core.sheet import FlatMap

WIDTH, HEIGHT = 210.0, 297.0
PAGE = np.array([[0, 0], [WIDTH, 0], [WIDTH, HEIGHT], [0, HEIGHT]])
L_SHAPE = np.array([[0, 0], [WIDTH, 0], [WIDTH, 150], [120, 150], [120, HEIGHT], [0, HEIGHT]])


def made(*creases: list, outline: np.ndarray = PAGE) -> CreasePattern:
    return arrange(outline, [np.array(crease, float) for crease in creases])


def counts(pattern: CreasePattern) -> tuple[int, int, int]:
    return len(pattern.vertices), len(pattern.edges), len(pattern.faces)


def areas_of(pattern: CreasePattern) -> list[float]:
    """Areas of the faces, positive if counter-clockwise as the page is read."""
    return sorted(-signed_area(pattern.vertices[face]) for face in pattern.faces)


def check(pattern: CreasePattern, outline: np.ndarray = PAGE) -> None:
    """Check the properties of a planar graph of paper: see the names of the FOLD format."""
    vertices, edges, faces = counts(pattern)
    assert vertices - edges + faces == 1  # Euler, without the face outside
    assert sum(areas_of(pattern)) == pytest.approx(signed_area(outline))
    assert len(np.unique(np.sort(pattern.edges, axis=1), axis=0)) == edges
    sides = Counter(
        tuple(sorted(side)) for face in pattern.faces for side in zip(face.tolist(), np.roll(face, -1).tolist())
    )
    expected = {
        tuple(sorted(edge)): 1 if line == BORDER else 2
        for edge, line in zip(pattern.edges.tolist(), pattern.line.tolist(), strict=True)
    }
    assert sides == expected


def test_page_without_creases():
    pattern = made()
    check(pattern)
    assert counts(pattern) == (4, 4, 1)
    assert set(pattern.line) == {BORDER}


def test_two_parallel_creases():
    pattern = made([[0, 99], [WIDTH, 99]], [[0, 198], [WIDTH, 198]])
    check(pattern)
    assert counts(pattern) == (8, 10, 3)
    assert areas_of(pattern) == pytest.approx([99 * WIDTH] * 3)
    assert Counter(pattern.line.tolist()) == {BORDER: 8, 0: 1, 1: 1}


def test_two_crossing_creases():
    pattern = made([[0, 100], [WIDTH, 100]], [[105, 0], [105, HEIGHT]])
    check(pattern)
    assert counts(pattern) == (9, 12, 4)
    assert areas_of(pattern) == pytest.approx([105 * 100, 105 * 100, 105 * 197, 105 * 197])
    degree = np.bincount(pattern.edges.ravel())
    crossing = int(np.argmax(degree))
    assert degree[crossing] == 4
    np.testing.assert_allclose(pattern.vertices[crossing], [105, 100])
    assert Counter(pattern.line.tolist()) == {BORDER: 8, 0: 2, 1: 2}


def test_creases_that_nearly_meet_do_meet():
    # four measured pieces of two folds: each ends short of the crossing and of the edge, or a little beyond it
    pattern = made(
        *([[3, 150], [96, 150.4]], [[111, 151], [205, 151]]),
        *([[105, 6], [105.5, 143]], [[106, 161], [107, HEIGHT + 2]]),
    )
    check(pattern)
    assert counts(pattern) == (9, 12, 4)
    degree = np.bincount(pattern.edges.ravel())
    np.testing.assert_allclose(pattern.vertices[np.argmax(degree)], [105.7, 150.7], atol=0.7)


def test_diagonals_of_the_page_end_in_its_corners():
    pattern = made([[1, 2], [208, 296]], [[209, 1], [1, 295]])
    check(pattern)
    assert counts(pattern) == (5, 8, 4)
    np.testing.assert_array_equal(pattern.vertices[np.isin(pattern.vertices, PAGE).all(axis=1)].max(0), [WIDTH, HEIGHT])


def test_crease_that_ends_on_another_splits_it():
    pattern = made([[0, 100], [WIDTH, 100]], [[80, 106], [80, HEIGHT]])
    check(pattern)
    assert counts(pattern) == (8, 10, 3)
    assert Counter(pattern.line.tolist()) == {BORDER: 7, 0: 2, 1: 1}


def test_crease_that_ends_inside_is_continued_by_a_join():
    pattern = made([[0, 150], [120, 150]])
    check(pattern)
    assert counts(pattern) == (7, 8, 2)
    assert Counter(pattern.line.tolist()) == {BORDER: 6, 0: 1, JOIN: 1}
    crease, join = (pattern.vertices[pattern.edges[pattern.line == line][0]] for line in (0, JOIN))
    np.testing.assert_allclose(np.sort(crease[:, 0]), [0, 120])
    np.testing.assert_allclose(np.sort(join[:, 0]), [120, WIDTH])
    np.testing.assert_allclose(join[:, 1], 150)


def test_two_creases_in_one_line_are_linked_by_one_join():
    pattern = made([[0, 150], [80, 150]], [[130, 151], [WIDTH, 151]])
    check(pattern)
    assert Counter(pattern.line.tolist()) == {BORDER: 6, 0: 1, 1: 1, JOIN: 1}


def test_crease_away_from_all_others():
    pattern = made([[60, 100], [140, 120]])
    check(pattern)
    assert Counter(pattern.line.tolist()) == {BORDER: 6, 0: 1, JOIN: 2}


def test_triangle_of_creases_away_from_the_edge_hangs_together_with_it():
    pattern = made([[60, 100], [140, 100]], [[140, 100], [100, 160]], [[100, 160], [60, 100]])
    check(pattern)
    assert len(pattern.faces) == 2
    assert (pattern.line == JOIN).sum() == 1


def test_crease_twice_over_is_one_crease():
    pattern = made([[0, 100], [WIDTH, 101]], [[2, 101], [WIDTH, 102]])
    check(pattern)
    assert counts(pattern) == (6, 7, 2)
    crossed = made([[0, 100], [WIDTH, 101]], [[2, 101], [WIDTH, 100]])
    check(crossed)
    assert counts(crossed) == (6, 7, 2)


def test_crease_found_in_two_pieces_is_one_crease():
    pattern = made([[0, 100], [60, 100]], [[64, 102], [WIDTH, 101]])
    check(pattern)
    assert counts(pattern) == (6, 7, 2)
    assert Counter(pattern.line.tolist()) == {BORDER: 6, 1: 1}
    bent = made([[0, 100], [100, 100]], [[100, 100], [WIDTH, 140]])
    check(bent)
    assert counts(bent) == (7, 8, 2)


def test_crease_along_the_edge_or_too_short_has_no_edge():
    pattern = made([[1, 0], [2, HEIGHT]], [[50, 50], [52, 50]], [[9, 9], [9, 9]])
    check(pattern)
    assert counts(pattern) == (4, 4, 1)


def test_paper_of_another_shape():
    pattern = made([[0, 150], [120, 150]], [[60, 0], [60, HEIGHT]], [[120, 75], [120, 75.5]], outline=L_SHAPE)
    check(pattern, L_SHAPE)
    assert len(pattern.faces) == 4
    across = made([[0, 200], [WIDTH, 100]], outline=L_SHAPE)  # outside the paper on its way
    check(across, L_SHAPE)
    middle = pattern.vertices[pattern.edges].mean(axis=1)
    assert not ((middle > [121, 151]).all(axis=1)).any()


@pytest.mark.parametrize("seed", range(40))
def test_any_creases_make_a_planar_graph(seed):
    rng = np.random.default_rng(seed)
    outline = L_SHAPE if seed % 3 == 0 else PAGE
    creases = rng.uniform((0, 0), (WIDTH, HEIGHT), (rng.integers(1, 9), 2, 2))
    if seed % 2:
        creases += rng.uniform(0, 3) * (creases - creases.mean(axis=1, keepdims=True))
    check(arrange(outline, list(creases)), outline)


def flat_of(uv: np.ndarray) -> FlatMap:
    return FlatMap(uv, sheets.WIDTH, sheets.HEIGHT, "page heights", None)


@pytest.mark.parametrize(("make", "vertices"), [(sheets.one_fold, 6), (sheets.two_folds, 8), (sheets.cross, 9)])
def test_pattern_of_a_sheet(make, vertices):
    sheet = make()
    mesh, uv = sheets.mesh(sheet)
    pattern = crease_pattern(mesh, flat_of(uv))
    outline = np.array([[0, 0], [sheets.WIDTH, 0], [sheets.WIDTH, sheets.HEIGHT], [0, sheets.HEIGHT]])
    check(pattern, outline)
    assert len(pattern.vertices) == vertices
    for number, crease in enumerate(sheet.creases):
        (edge,) = pattern.edges[pattern.line == number]
        found = pattern.vertices[edge]
        np.testing.assert_allclose(found[np.argsort(found[:, 0])], crease[np.argsort(crease[:, 0])], atol=2e-3)
    np.testing.assert_allclose(
        in_space(mesh, flat_of(uv), pattern.vertices), sheet.in_space(pattern.vertices), atol=2e-3
    )


def test_paper_with_a_corner_torn_off_keeps_its_shape():
    mesh, uv = sheets.mesh(sheets.plane())
    torn = uv.sum(axis=1) < 0.3
    triangles = mesh.triangles[~torn[mesh.triangles].any(axis=1)]
    edge = mesh.boundary[~torn[mesh.boundary]]
    pattern = crease_pattern(replace(mesh, triangles=triangles, boundary=edge), flat_of(uv))
    assert counts(pattern) == (5, 5, 1)
    assert sum(areas_of(pattern)) == pytest.approx(abs(signed_area(uv[edge])), rel=0.01)


def test_each_piece_of_a_crease_has_its_own_fold_angle():
    # bent over a line that is a mountain at its top and a valley at its bottom, with another one across, lying open
    middle = np.array([sheets.WIDTH, sheets.HEIGHT]) / 2

    def in_space(uv: np.ndarray) -> np.ndarray:
        across, down = np.moveaxis(uv - middle, -1, 0)
        return np.stack([across, down, -0.8 * np.abs(across) * down], axis=-1)

    lines = np.array([[[0.35, 0], [0.35, 1]], [[0, 0.5], [0.7, 0.5]]])
    mesh, uv = sheets.mesh(sheets.SyntheticSheet("twisted", in_space, tuple(lines)))
    pattern = crease_pattern(mesh, flat_of(uv))
    angles = fold_angles(pattern, mesh, flat_of(uv))
    letters = np.array(assignments(pattern, angles))
    assert Counter(letters.tolist()) == {"B": 8, "M": 1, "V": 1, "F": 2}
    (mountain,), (valley,) = (pattern.vertices[pattern.edges[letters == letter]] for letter in "MV")
    assert mountain[:, 1].max() == pytest.approx(0.5)
    assert valley[:, 1].min() == pytest.approx(0.5)
    assert angles[letters == "V"] == pytest.approx(-angles[letters == "M"], abs=0.3)
    assert angles[letters == "V"] == pytest.approx(np.degrees(2 * np.arctan(0.8 * 0.25)), abs=2)
    assert (angles[(letters == "B") | (letters == "F")] == 0).all()
    assert assignments(pattern, np.full(len(letters), np.nan)).count("U") == 4
