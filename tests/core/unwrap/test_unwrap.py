"""Unwrapping meshes with a known flat shape, and meshes without any."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import corners, label, quads, tube
from origami.benchmarks.transforms import displacement
from origami.core.errors import Cancelled, UnusableMesh
from origami.core.flat.distortion import fit_similarity
from origami.core.flat.flatten import FlattenSettings
from origami.core.unwrap.unwrap import Unwrapped, unwrap
from origami.core.watch import Watch

METHODS = ("arap", "conformal_l1", "lscm", "geodesic", "least_stretch")
NO_SEAMS = np.zeros((0, 2), int)


def _unwrap(vertices: np.ndarray, faces: np.ndarray, seams: np.ndarray = NO_SEAMS, **more) -> Unwrapped:
    return unwrap(vertices, *corners(faces), seams, **more)


def _areas(result: Unwrapped, faces: np.ndarray) -> np.ndarray:
    """Signed area of each island in UV space."""
    triangle = result.uv[corners(faces)[1]]
    a, b = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    return np.bincount(result.island, weights=(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2)


def _box(uv: np.ndarray) -> np.ndarray:
    return np.ptp(uv, axis=0)


@pytest.mark.parametrize("method", METHODS)
def test_a_label_becomes_its_rectangle_upright_and_unmirrored(method):
    vertices, faces = label()
    result = _unwrap(vertices, faces, settings=FlattenSettings(method))
    u = np.arctan2(vertices[:, 1], vertices[:, 0]) / 2
    expected = np.stack([u, vertices[:, 2] / 2], -1)[faces.ravel()]
    assert np.abs(result.uv - expected).max() < 1e-3
    assert result.warning is None
    assert result.mean_stretch < 1e-3


@pytest.mark.parametrize("method", METHODS)
def test_a_piece_of_a_cone_becomes_a_sector(method):
    half_angle, opening = np.radians(30), np.pi / 2

    def place(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        radius, turn = 1 + v, opening * u / np.sin(half_angle)
        ring = np.stack([np.cos(turn), np.sin(turn)], -1) * np.sin(half_angle)
        return radius[:, None] * np.column_stack([ring, np.full(len(u), np.cos(half_angle))])

    vertices, faces = quads(65, 17, place)
    result = _unwrap(vertices, faces, settings=FlattenSettings(method))
    u, v = np.meshgrid(np.linspace(0, 1, 65), np.linspace(0, 1, 17))
    sector = ((1 + v) * np.exp(1j * opening * u)).ravel()
    # Seen from outside, the turn about the cone's axis goes the other way round.
    flat = np.stack([sector.real, -sector.imag], -1)[faces.ravel()]
    assert displacement(result.uv, flat, fit_similarity(result.uv, flat)).max() < 1e-3
    side = result.uv[0] - result.uv[np.flatnonzero(faces.ravel() == 16 * 65)[0]]
    assert np.abs(side).min() < 1e-3 * np.abs(side).max()


@pytest.mark.parametrize("method", METHODS)
def test_a_sleeve_opens_at_its_seam(method):
    vertices, faces, seam = tube()
    result = _unwrap(vertices, faces, seam, settings=FlattenSettings(method))
    around = 2 * 64 * np.sin(np.pi / 64)  # of the polygon that the tube is
    np.testing.assert_allclose(_box(result.uv), [1, 2.0 / around], atol=1e-4)
    at_seam = result.uv[faces.ravel() == seam[3, 0]]
    assert _box(at_seam) == pytest.approx([1, 0], abs=1e-4)
    assert not result.flipped.any()


def test_islands_keep_the_ratio_of_their_areas_and_do_not_overlap():
    vertices, faces = label()
    sizes = np.array([1.0, 0.5, 2.0])
    many = np.concatenate([size * vertices + [4 * place, 0, 0] for place, size in enumerate(sizes)])
    all_faces = np.concatenate([faces + place * len(vertices) for place in range(3)])
    result = _unwrap(many, all_faces)
    area = _areas(result, all_faces)
    np.testing.assert_allclose(area / area[0], sizes**2, rtol=1e-5)
    boxes = [(part.min(0), part.max(0)) for part in np.split(result.uv, 3)]
    for (low, high), (other_low, other_high) in ((boxes[0], boxes[1]), (boxes[0], boxes[2]), (boxes[1], boxes[2])):
        assert (low > other_high).any() or (other_low > high).any()
    assert result.uv.min() == pytest.approx(0)
    assert result.uv.max() == pytest.approx(1)


def test_faces_that_look_the_wrong_way_follow_the_others():
    vertices, faces = label()
    mixed = faces.copy()
    mixed[::3] = mixed[::3, ::-1]
    result, right = _unwrap(vertices, mixed), _unwrap(vertices, faces)
    at_vertex = {int(v): uv for v, uv in zip(faces.ravel(), right.uv, strict=True)}
    expected = np.array([at_vertex[int(v)] for v in mixed.ravel()])
    np.testing.assert_allclose(result.uv, expected, atol=1e-6)
    assert not result.flipped.any()


def test_a_mesh_seen_from_inside_is_mirrored_with_it():
    vertices, faces = label()
    inside = _unwrap(vertices, faces[:, ::-1])
    assert (_areas(inside, faces[:, ::-1]) > 0).all()


@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_a_punched_label_keeps_its_hole(noise):
    vertices, faces = label()
    vertices = vertices + noise * np.random.default_rng(0).normal(size=vertices.shape)
    column, row = np.arange(len(vertices)) % 41, np.arange(len(vertices)) // 41
    hole = (column - 20) ** 2 + (row - 13) ** 2 < 25
    punched = faces[~hole[faces].any(1)]
    result = _unwrap(vertices, punched)
    assert result.mean_stretch < 0.05
    np.testing.assert_allclose(_box(result.uv), [1, 0.65], atol=1e-4 if noise == 0 else 0.03)


def _ball() -> tuple[np.ndarray, np.ndarray]:
    """A sphere of quads whose poles are rings of coincident vertices, as modelling programs make it."""

    def place(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        around, down = 2 * np.pi * u, np.pi * (1 - v)
        return np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], -1)

    return quads(24, 13, place, around=True)


def _doughnut() -> tuple[np.ndarray, np.ndarray]:
    def place(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        around, over = 2 * np.pi * u, 2 * np.pi * v
        radius = 2 + 0.5 * np.cos(over)
        return np.stack([radius * np.cos(around), radius * np.sin(around), 0.5 * np.sin(over)], -1)

    vertices, faces = quads(30, 21, place, around=True)
    return vertices, np.where(faces >= 600, faces - 600, faces)


def _twisted_ring() -> tuple[np.ndarray, np.ndarray]:
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    edges = [
        np.stack([(1 + s * np.cos(turn / 2)) * np.cos(turn), (1 + s * np.cos(turn / 2)) * np.sin(turn)], -1)
        for s in (-0.3, 0.3)
    ]
    heights = np.concatenate([-0.3 * np.sin(turn / 2), 0.3 * np.sin(turn / 2)])
    step = np.arange(39)
    faces = np.stack([step, step + 1, step + 41, step + 40], -1)
    return np.column_stack([np.concatenate(edges), heights]), np.vstack([faces, [39, 40, 0, 79]])


@pytest.mark.parametrize(
    ("mesh", "sentence"),
    [
        (_ball(), "is closed: mark seams"),
        (_doughnut(), "is closed: mark seams"),
        ((_doughnut()[0], _doughnut()[1][1:]), "has a handle"),
        (tube()[:2], "is a tube: mark a seam along it"),
        (tube(height=0.3, rows=3)[:2], "is a tube: mark a seam along it"),
        (_twisted_ring(), "only one side"),
        ((np.zeros((4, 3)), np.array([[0, 1, 2, 3]])), "no faces with an area"),
        ((np.zeros((4, 3)), np.zeros((0, 4), int)), "no faces with an area"),
        ((np.full((4, 3), np.nan), np.array([[0, 1, 2, 3]])), "not a number"),
    ],
    ids=["ball", "doughnut", "punctured doughnut", "tube", "narrow band", "twisted", "point", "nothing", "nan"],
)
def test_what_has_no_flat_map_is_reported_in_a_sentence(mesh, sentence):
    with pytest.raises(UnusableMesh, match=sentence):
        _unwrap(*mesh)


def test_the_faulty_part_of_several_is_named():
    vertices, faces = label()
    round_about, tube_faces, _ = tube()
    with pytest.raises(UnusableMesh, match="The part at vertex 1107 is a tube"):
        unwrap(np.vstack([vertices, round_about]), *corners(np.vstack([faces, tube_faces + len(vertices)])))


def test_a_surface_that_has_to_stretch_is_unwrapped_with_a_warning():
    vertices, faces = _ball()
    half = _unwrap(vertices, faces[vertices[faces][..., 2].min(1) > -1e-9])
    assert not half.flipped.any()
    assert half.mean_stretch > 0.1
    assert half.warning is not None
    assert "stretches the surface" in half.warning


def test_two_sheets_on_one_edge_come_apart():
    vertices, faces = label()
    fin = np.vstack([vertices, vertices[[20, 61]] * [2, 2, 1]])
    at = len(vertices)
    result = _unwrap(fin, np.vstack([faces, [20, 61, at + 1, at]]))
    assert sorted(np.bincount(result.island)) == [2, 2 * len(faces)]
    assert result.mean_stretch < 1e-3


def test_faces_without_area_do_no_harm():
    """Corners doubled by an extrusion of no length, and vertices on straight sides of other faces."""
    vertices, faces = label()
    doubled = np.vstack([vertices, vertices[:41]])
    step, at = np.arange(40), len(vertices)
    strip = np.stack([at + step, at + step + 1, step + 1, step], -1)
    result, plain = _unwrap(doubled, np.vstack([faces, strip])), _unwrap(vertices, faces)
    np.testing.assert_allclose(result.uv[: faces.size], plain.uv, atol=1e-9)
    assert (result.island[corners(np.vstack([faces, strip]))[1].min(1) >= faces.size] == -1).all()

    # A pentagon with three corners in line, cut with those three as a triangle; and one between two squares.
    points = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [0, 1], [0, -1], [2, -1]], float)
    space = np.column_stack([points[:, 0], np.zeros(7), points[:, 1]])
    alone = unwrap(space, np.array([0, 1, 2, 3, 4]), np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4]]))
    np.testing.assert_allclose(alone.uv * 2, points[:5], atol=1e-6)
    between = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [5, 1, 0], [5, 6, 1], [6, 2, 1]])
    result = unwrap(space, np.arange(7), between)
    np.testing.assert_allclose(result.uv * 2, points + np.array([0, 1]), atol=1e-6)


def test_unnamed_corners_are_left_alone():
    vertices, faces = label()
    corner_vertex, triangles = corners(faces)
    before = np.random.default_rng(0).random((len(corner_vertex), 2))
    part = triangles[triangles.max(1) < 400]
    result = unwrap(vertices, corner_vertex, part, uv=before)
    assert (result.uv[400:] == before[400:]).all()
    assert not np.isclose(result.uv[:400], before[:400]).all(1).any()


@pytest.fixture(scope="module")
def flat_label() -> np.ndarray:
    return _unwrap(*label()).uv


CORNERS = (0, 40, 26 * 41, 27 * 41 - 1)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [2, 4])
def test_pins_that_fit_take_the_map_along(method, count, flat_label):
    vertices, faces = label()
    goal = flat_label @ np.array([[0.0, 0.5], [-0.5, 0.0]]) + [3, 4]
    pinned = np.isin(faces.ravel(), CORNERS[:count])
    result = _unwrap(
        vertices, faces, uv=np.where(pinned[:, None], goal, 0), pinned=pinned, settings=FlattenSettings(method)
    )
    assert (result.uv[pinned] == goal[pinned]).all()
    assert np.abs(result.uv - goal).max() < 1e-4


@pytest.mark.parametrize("method", METHODS)
def test_pins_that_do_not_fit_are_kept_exactly(method, flat_label):
    vertices, faces = label()
    goal = flat_label + 0.02 * (flat_label > 0.6)
    pinned = np.isin(faces.ravel(), (*CORNERS, 13 * 41 + 20))
    result = _unwrap(vertices, faces, uv=goal, pinned=pinned, settings=FlattenSettings(method))
    assert (result.uv[pinned] == goal[pinned]).all()
    assert np.abs(result.uv - flat_label).max() < 0.05


def test_one_pin_shifts_the_island_and_keeps_its_size(flat_label):
    vertices, faces = label()
    before = 0.3 * flat_label + [5, 0]
    pinned = faces.ravel() == CORNERS[0]
    result = _unwrap(vertices, faces, uv=before, pinned=pinned)
    np.testing.assert_allclose(result.uv, before, atol=1e-6)


def test_free_islands_lie_beside_pinned_ones_in_their_scale(flat_label):
    vertices, faces = label()
    both = np.vstack([faces, faces + len(vertices)])
    before = np.vstack([0.3 * flat_label + [5, 1], 0 * flat_label])
    pinned = np.isin(both.ravel(), CORNERS)
    result = _unwrap(np.vstack([vertices, vertices + np.array([9, 0, 0])]), both, uv=before, pinned=pinned)
    held, free = np.split(result.uv, 2)
    np.testing.assert_allclose(held, before[: len(held)], atol=1e-5)
    np.testing.assert_allclose(_box(free), _box(held), atol=1e-5)
    assert free[:, 0].min() > held[:, 0].max()


def test_pins_in_one_place_are_reported_in_a_sentence():
    vertices, faces = label()
    with pytest.raises(UnusableMesh, match="pins of an island are in one place"):
        _unwrap(vertices, faces, uv=np.zeros((faces.size, 2)), pinned=np.isin(faces.ravel(), CORNERS))


def test_ridges_become_straight_on_either_side_of_a_seam():
    """A folded sheet whose crease was measured badly, and which is cut across the crease."""
    rows, columns = 25, 41

    def place(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        away = np.abs(v - 0.5)
        return np.stack([1.6 * u, 0.8 * (v - 0.5), 0.5 * away], -1)

    vertices, faces = quads(columns, rows, place)
    crease = 12 * columns + np.arange(columns)
    vertices[crease, 1] += 0.008 * np.sin(12 * vertices[crease, 0])
    cut = columns // 2 + columns * np.arange(rows)
    seams = np.stack([cut[:-1], cut[1:]], -1)

    def wave(**more) -> float:
        result = _unwrap(vertices, faces, seams, **more)
        sizes = []
        for half in (crease[: columns // 2], crease[columns // 2 + 1 :]):
            line = np.array([result.uv[np.flatnonzero(faces.ravel() == vertex)[0]] for vertex in half])
            along = np.linalg.svd(line - line.mean(0), full_matrices=False)[2][1]
            sizes.append(np.ptp((line - line.mean(0)) @ along))
        return max(sizes)

    settings = FlattenSettings("arap", ridge_rows=True)
    free = wave(settings=settings)
    assert free > 0.004
    assert wave(settings=settings, ridges=[crease]) < 0.1 * free


def test_progress_goes_forward_and_cancelling_stops():
    vertices, faces, seam = tube()
    fractions: list[float] = []
    _unwrap(vertices, faces, seam, watch=Watch(progress=lambda fraction, _: fractions.append(fraction)))
    assert fractions == sorted(fractions)
    assert fractions[-1] <= 1
    with pytest.raises(Cancelled):
        _unwrap(vertices, faces, seam, watch=Watch(cancelled=lambda: len(fractions) > 0))
