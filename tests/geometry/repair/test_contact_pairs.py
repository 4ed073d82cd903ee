import numpy as np
import pytest

from caricli.geometry.repair.contact_pairs import RINGS, closes, closing_pairs, touching_pairs

SIDE, STEP = 7, 0.1
COUNT = SIDE * SIDE


def plate(height, up=True):
    """A square of SIDE x SIDE vertices in a plane z = height; its faces look up, or down."""
    y, x = np.mgrid[:SIDE, :SIDE] * STEP
    corner = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + SIDE + 1, corner + SIDE], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return np.stack([x, y, np.full(x.shape, height)], axis=-1).reshape(-1, 3), faces if up else faces[:, ::-1]


def two_plates(gap, facing=True):
    """One plate above another; they face each other or are the sides of a wall."""
    (low, faces), (high, others) = plate(0, facing), plate(gap, not facing)
    return np.concatenate([low, high]), np.concatenate([faces, others + COUNT])


def fold(opening):
    """A plate folded along its middle row, the faces inside; rows by their distance from the fold."""
    vertices, faces = plate(0)
    row = np.arange(COUNT) // SIDE - SIDE // 2
    lift, length = np.sin(opening / 2) * row, np.cos(opening / 2) * np.abs(row)
    return np.stack([vertices[:, 0], STEP * length, -STEP * lift], axis=1), faces, row


def test_plates_that_face_each_other_touch():
    vertices, faces = two_plates(0.05)
    found = touching_pairs(vertices, faces, 0.08)
    np.testing.assert_array_equal(found, np.stack([np.arange(COUNT), COUNT + np.arange(COUNT)], axis=1))
    assert len(touching_pairs(vertices, faces, 0.04)) == 0


def test_the_sides_of_a_wall_do_not():
    vertices, faces = two_plates(0.05, facing=False)
    assert len(touching_pairs(vertices, faces, 0.08)) == 0


def test_every_vertex_has_its_nearest_partner_once():
    vertices, faces = two_plates(0.05)
    vertices = vertices + np.random.default_rng(1).normal(0, 0.01, vertices.shape)
    found = touching_pairs(vertices, faces, 0.15)
    assert len(np.unique(found, axis=0)) == len(found) and (found[:, 0] < found[:, 1]).all()
    listed = set(map(tuple, found.tolist()))
    distances = np.linalg.norm(vertices[:COUNT, None] - vertices[COUNT:], axis=-1)
    nearest = {(k, COUNT + int(distances[k].argmin())) for k in range(COUNT)}
    nearest |= {(int(distances[:, k].argmin()), COUNT + k) for k in range(COUNT)}
    assert listed == nearest


def test_of_a_finer_side_every_vertex_has_its_partner_too():
    vertices, faces = two_plates(0.05)
    vertices[COUNT:, :2] = 0.3 + 0.4 * (vertices[COUNT:, :2] - 0.3) + [0.013, 0.007]
    distances = np.linalg.norm(vertices[:COUNT, None] - vertices[COUNT:], axis=-1)
    nearest = {(k, COUNT + int(distances[k].argmin())) for k in range(COUNT) if distances[k].min() < 0.08}
    nearest |= {(int(distances[:, k].argmin()), COUNT + k) for k in range(COUNT) if distances[:, k].min() < 0.08}
    assert set(map(tuple, touching_pairs(vertices, faces, 0.08).tolist())) == nearest


def test_vertices_may_have_any_order():
    generator = np.random.default_rng(2)
    apart, faces = two_plates(0.5)
    near = two_plates(0.05)[0] + generator.normal(0, 0.02, apart.shape)

    def touching(_, after, faces, reach):
        return touching_pairs(after, faces, reach)

    for find in (touching, closing_pairs):
        pairs = find(apart, near, faces, 0.15)
        for _ in range(3):
            order = generator.permutation(len(near))
            shuffled = find(apart[order], near[order], np.argsort(order)[faces], 0.15)
            back = np.sort(order[shuffled], axis=1)
            np.testing.assert_array_equal(np.unique(back, axis=0), pairs)


def test_neighbours_on_the_surface_do_not_touch():
    vertices, faces, row = fold(np.radians(20))
    found = touching_pairs(vertices, faces, 0.13)
    # Row k and row -k are 2 k edges apart.
    assert {tuple(sorted(pair)) for pair in np.abs(row[found]).tolist()} == {(2, 2), (3, 3)}
    assert RINGS == 4 and (row[found].sum(1) == 0).all()


def test_pairs_close_that_come_from_afar():
    apart, faces = two_plates(0.5)
    near, _ = two_plates(0.03)
    found = closing_pairs(apart, near, faces, 0.05)
    np.testing.assert_array_equal(found, np.stack([np.arange(COUNT), COUNT + np.arange(COUNT)], axis=1))
    assert len(closing_pairs(near, near, faces, 0.05)) == len(closing_pairs(near, apart, faces, 0.05)) == 0
    # A distance that was small already, or has hardly become smaller, is no contact.
    assert len(closing_pairs(two_plates(0.06)[0], near, faces, 0.05)) == 0
    assert len(closing_pairs(two_plates(0.1)[0], near, faces, 0.05)) == COUNT


def test_neighbours_do_not_close():
    vertices, faces = plate(0)
    squeezed = vertices * [0.1, 1, 1]
    pairs = closing_pairs(vertices, squeezed, faces, 0.045)
    steps = np.diff(np.stack(np.divmod(pairs, SIDE), axis=-1), axis=1)
    assert len(steps) and (np.abs(steps[:, 0, 1]) >= RINGS).all() and not steps[:, 0, 0].any()


def test_coming_together_is_from_outside_to_inside_and_by_much():
    before, after = np.array([1.0, 0.1, 1, 0.2, 0.2, 0.14]), np.array([0.05, 0.05, 0.2, 0.05, 0.09, 0.01])
    np.testing.assert_array_equal(closes(before, after, 0.15), [True, False, False, True, False, False])


@pytest.mark.parametrize("reach", [1e-6, 0.0])
def test_no_pairs_are_an_empty_list_of_pairs(reach):
    vertices, faces = two_plates(0.05)
    for found in (touching_pairs(vertices, faces, reach), closing_pairs(vertices, vertices, faces, reach)):
        assert found.shape == (0, 2) and found.dtype.kind == "i"
