import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import NumericsError
from caricli.geometry.deformation.deformation_transfer import DeformationTransfer, triangle_maps

TURN = Rotation.from_euler("xyz", [20, 35, -50], degrees=True).as_matrix()


def bent(vertices):
    """A shape that no linear map makes of another one."""
    x, y, z = vertices.T
    return np.stack([x + 0.2 * np.sin(2 * y), 1.1 * y - 0.1 * z**2, z + 0.15 * x * y + 0.1 * np.cos(3 * x)], axis=1)


def stretched(vertices):
    return vertices * [1.4, 0.7, 1.2] + 0.1 * np.sin(2 * vertices[:, [1, 2, 0]])


def holding(count, *ids):
    held = np.zeros(count, dtype=bool)
    held[list(ids)] = True
    return held


def four_vertices(vertices, faces):
    """(F, 3, 3) edges to the second, third and fourth vertex of every triangle, as columns (equation 14)."""
    made = np.empty((len(faces), 3, 3))
    for number, (a, b, c) in enumerate(vertices[faces]):
        cross = np.cross(b - a, c - a)
        made[number] = np.stack([b - a, c - a, cross / np.sqrt(np.linalg.norm(cross))], axis=1)
    return made


def dense_transfer(vertices, faces, maps, held):
    """Positions that minimise equation 16 with a fourth vertex for each triangle, weighted by area; one vertex held."""
    count, inverses = len(vertices), np.linalg.inv(four_vertices(vertices, faces))
    matrix, right = np.zeros((3 * len(faces) + 1, count + len(faces))), np.zeros((3 * len(faces) + 1, 3))
    for number, (a, b, c) in enumerate(faces):
        weight = np.sqrt(np.linalg.norm(np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])) / 2)
        rows = slice(3 * number, 3 * number + 3)
        # Row r of (Q' - Q) transposed: edges of the unknown vertices times column r of the inverse.
        matrix[rows, b], matrix[rows, c], matrix[rows, count + number] = weight * inverses[number]
        matrix[rows, a] = -weight * inverses[number].sum(0)
        right[rows] = weight * maps[number].T
    matrix[-1, held], right[-1] = 1e3, 1e3 * vertices[held]
    return np.linalg.lstsq(matrix, right, rcond=None)[0][:count]


def test_a_map_takes_edges_to_edges_and_the_normal_to_the_normal(ball):
    vertices, faces = ball
    before, after = four_vertices(vertices, faces), four_vertices(bent(vertices), faces)
    np.testing.assert_allclose(triangle_maps(vertices, bent(vertices), faces) @ before, after, atol=1e-12)


def test_maps_of_a_similarity_are_its_own(ball):
    vertices, faces = ball
    maps = triangle_maps(vertices, 2.5 * vertices @ TURN.T + [1, 2, 3], faces)
    np.testing.assert_allclose(maps, np.broadcast_to(2.5 * TURN, maps.shape), atol=1e-10)


@pytest.mark.parametrize("held", [0, 31])
def test_the_dense_form_with_four_vertices_agrees(patch, held):
    source, faces = patch
    target, maps = stretched(source), triangle_maps(source, bent(source), faces)
    transfer = DeformationTransfer(target, faces, holding(len(source), held))
    found = target + transfer.displacements(np.arange(len(faces)), maps, np.zeros_like(target))
    np.testing.assert_allclose(found, dense_transfer(target, faces, maps, held), atol=1e-8)
    np.testing.assert_array_equal(found[held], target[held])
    assert np.abs(found - target).max() > 0.1


def test_onto_itself_gives_the_shape_back(ball):
    vertices, faces = ball
    after = bent(vertices)
    moved = DeformationTransfer(vertices, faces, np.zeros(len(vertices), dtype=bool)).displacements(
        np.arange(len(faces)), triangle_maps(vertices, after, faces), after - vertices
    )
    # Nothing is held but weakly: a hundredth of a millionth.
    np.testing.assert_allclose(vertices + moved, after, atol=1e-6)


def test_triangles_that_are_not_named_keep_their_shape(patch):
    vertices, faces = patch
    after = vertices.copy()
    after[40] += [0.05, -0.02, 0.1]
    some = np.flatnonzero((faces == 40).any(1))
    transfer = DeformationTransfer(vertices, faces, holding(len(vertices), 0))
    moved = transfer.displacements(some, triangle_maps(vertices, after, faces[some]), np.zeros_like(vertices))
    np.testing.assert_allclose(vertices + moved, after, atol=1e-9)


def test_a_moved_and_scaled_target_does_the_moved_and_scaled_thing(patch):
    source, faces = patch
    maps, every = triangle_maps(source, bent(source), faces), np.arange(len(faces))
    held = holding(len(source), 3, 60)
    target = stretched(source)
    plain = DeformationTransfer(target, faces, held).displacements(every, maps, np.zeros_like(target))
    turned = DeformationTransfer(2.5 * target @ TURN.T + [1, 2, 3], faces, held)
    found = turned.displacements(every, TURN @ maps @ TURN.T, np.zeros_like(target))
    np.testing.assert_allclose(found, 2.5 * plain @ TURN.T, atol=1e-10)


def test_what_hangs_on_another_component_goes_where_it_went_on_the_templates(patch):
    vertices, faces = patch
    count = len(vertices)
    part = stretched(vertices[:27]) * 0.3 + [0.5, 0.5, 0.4]
    own = faces[(faces < 27).all(1)]
    both, triangles = np.concatenate([vertices, part]), np.concatenate([faces, own + count])
    after = np.concatenate([vertices + 0.5 * (vertices - vertices[7]), part @ TURN.T + [0.1, 0.2, 0.3]])
    transfer = DeformationTransfer(both, triangles, holding(len(both), 7))
    maps = triangle_maps(both, after, triangles)
    moved = transfer.displacements(np.arange(len(triangles)), maps, after - both)
    np.testing.assert_allclose(both + moved, after, atol=1e-9)
    # With what it hangs on it goes further where that goes further, and nothing but the bonds says so.
    more = np.concatenate([1.5 * np.eye(3) @ maps[: len(faces)], maps[len(faces) :]])
    farther = transfer.displacements(np.arange(len(triangles)), more, after - both)
    np.testing.assert_array_equal(farther[7], np.zeros(3))
    assert np.linalg.norm((farther - moved)[count:].mean(0)) > 0.2 * np.linalg.norm((farther - moved)[:count].mean(0))


def test_triangles_without_area_are_refused(patch):
    vertices, faces = patch
    for corners in ([0, 1, 1], [0, 1, 0]):
        with pytest.raises(NumericsError, match="with an area, found 1 without"):
            DeformationTransfer(vertices, np.vstack([faces, corners]), holding(len(vertices), 0))
    line = vertices.copy()
    line[faces[5, 2]] = line[faces[5, :2]].mean(0)
    with pytest.raises(NumericsError, match="found 1 without"):
        DeformationTransfer(line, faces, holding(len(vertices), 0))


def test_maps_that_are_not_finite_give_no_shape(patch):
    vertices, faces = patch
    transfer = DeformationTransfer(vertices, faces, holding(len(vertices), 0))
    with pytest.raises(NumericsError, match="no finite solution"):
        transfer.displacements(np.array([4]), np.full((1, 3, 3), np.nan), np.zeros_like(vertices))


def test_triangles_that_lose_their_area_have_finite_maps(ball):
    vertices, faces = ball
    maps = triangle_maps(vertices, np.where(vertices[:, 2:] > 0.5, 0.1, vertices), faces)
    assert np.isfinite(maps).all()
    np.testing.assert_allclose(maps[(vertices[faces][:, :, 2] > 0.5).all(1)], 0, atol=1e-12)
