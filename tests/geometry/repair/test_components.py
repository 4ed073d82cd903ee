import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.geometry.deformation.deformation_gradients import DeformationGradients
from caricli.geometry.deformation.elastic_anchors import ElasticAnchors
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation
from caricli.geometry.repair.components import POINTS, component_labels, mesh_components
from caricli.geometry.repair.tuck_cavities import Cavities
from caricli.methods.edit.deform_arap import deform_arap

TURN = Rotation.from_rotvec([0.3, -0.7, 0.4]).as_matrix()


@pytest.fixture(scope="module")
def balls(ball):
    """A ball with two smaller ones in it, their vertices and faces mixed; and the numbers of the three."""
    sphere, faces = ball
    small = sphere[:, [1, 2, 0]]
    vertices = np.concatenate([0.15 * small + [0.3, 0.2, 0.7], sphere, 0.25 * small[:, [1, 2, 0]] - [0.3, 0.1, 0.2]])
    count = len(sphere)
    triangles = np.concatenate([faces + count, faces[:-20:2], faces + 2 * count])
    kept = np.unique(triangles)
    order = np.random.default_rng(0).permutation(len(kept))
    parts = kept[order] // count
    return vertices[kept][order], np.argsort(order)[np.searchsorted(kept, triangles)], parts


def bent(vertices):
    x, y, z = vertices.T
    return np.stack([x + 0.2 * z**2, 1.1 * y + 0.1 * x * z, z - 0.15 * y**2], 1)


def gaps(vertices, parts):
    """Where the small balls are as the big one sees it."""
    return np.array([vertices[parts == k].mean(0) - vertices[parts == 1].mean(0) for k in (0, 2)])


def test_the_one_with_most_vertices_is_the_first(balls, ball):
    vertices, faces, parts = balls
    components = mesh_components(vertices, faces)
    assert components.count == 3 and (np.bincount(components.labels)[:-1] >= np.bincount(components.labels)[1:]).all()
    assert all(len(np.unique(components.labels[parts == k])) == 1 for k in range(3))
    assert components.bonds.shape == (2 * POINTS, len(vertices)) and components.hangers.shape == (2, len(vertices))
    single = mesh_components(*ball)
    assert single.count == 1 and single.bonds.shape == (0, 300) and single.hangers.shape == (0, 300)
    np.testing.assert_array_equal(single.hang(ball[0], 0 * ball[0]), ball[0])


def test_components_are_numbered_by_their_sizes():
    """Strips of 4, 6, 3, 7 and 6 vertices; of two of one size the one with the first vertex comes first."""
    sizes = [4, 6, 3, 7, 6]
    starts = np.cumsum([0, *sizes[:-1]])
    faces = np.concatenate(
        [start + np.arange(size - 2)[:, None] + [0, 1, 2] for start, size in zip(starts, sizes, strict=True)]
    )
    labels = component_labels(faces[::-1], sum(sizes))
    np.testing.assert_array_equal(labels, np.repeat([3, 1, 4, 0, 2], sizes))


def test_bonds_see_no_affine_map_and_are_no_levers(balls):
    vertices, faces, _ = balls
    components = mesh_components(vertices, faces)
    matrix = np.random.default_rng(1).normal(size=(3, 3))
    assert np.abs(components.bonds @ (vertices @ matrix + [3, -2, 1])).max() < 1e-9
    assert np.abs(components.bonds).sum(1).max() < 6


def test_points_that_are_bound_are_spread_over_their_component(balls):
    vertices, faces, _ = balls
    components = mesh_components(vertices, faces)
    for part in (1, 2):
        own = components.bonds[components.owners == part][:, np.flatnonzero(components.labels == part)].toarray()
        assert ((own == 0) | (own == 1)).all() and (own.sum(1) == 1).all() and (own.sum(0) <= 1).all()
        points = own @ vertices[components.labels == part]
        size = np.ptp(vertices[components.labels == part], axis=0).max()
        apart = np.linalg.norm(points[:, None] - points, axis=2) + size * np.eye(POINTS)
        assert apart.min() > 0.4 * size


def test_bonds_are_of_those_that_are_not_held_and_others_only_carried(balls):
    vertices, faces, _ = balls
    components = mesh_components(vertices, faces)
    held = np.flatnonzero(components.labels == 2)[[30, 5]]
    loose = components.bonds[components.owners == 1]
    np.testing.assert_allclose(components.stiffness(held).toarray(), (loose.T @ loose).toarray(), atol=1e-12)
    own, others = components.pull(held)
    np.testing.assert_allclose((own + others).toarray()[components.labels == 0], 0, atol=1e-12)
    forces = (loose.T @ loose).toarray()[components.labels == 1]
    np.testing.assert_allclose((own + others).toarray()[components.labels == 1], forces, atol=1e-12)
    moved = np.random.default_rng(3).normal(size=vertices.shape)
    carried = components.carry(moved)
    np.testing.assert_array_equal(carried[components.labels == 0], moved[components.labels == 0])
    np.testing.assert_allclose(components.hangers @ carried, 0, atol=1e-12)
    for part in (1, 2):
        assert np.ptp(carried[components.labels == part], axis=0).max() < 1e-12


def test_components_are_hung_and_placed(balls):
    vertices, faces, _ = balls
    components = mesh_components(vertices, faces)
    like = bent(vertices)
    hung = components.hang(vertices, like)
    np.testing.assert_allclose(components.hangers @ hung, components.hangers @ like, atol=1e-12)
    np.testing.assert_array_equal(hung[components.labels == 0], vertices[components.labels == 0])
    means = np.arange(9.0).reshape(3, 3)
    np.testing.assert_allclose(components.averages @ components.place(vertices, means), means, atol=1e-12)


def test_features_keep_components_together(balls):
    vertices, faces, parts = balls
    gradients = DeformationGradients(vertices, faces)
    moved = vertices @ TURN.T * 1.3
    found = gradients.vertices(gradients.features(moved))
    np.testing.assert_allclose(found, moved - moved.mean(0), atol=1e-6)
    # Each keeps its own shape exactly, and none is farther from its place than the bending says.
    shape = bent(vertices)
    found = gradients.vertices(gradients.features(shape))
    for part in range(3):
        own = parts == part
        same = shape[own] - shape[own].mean(0)
        np.testing.assert_allclose(found[own] - found[own].mean(0), same, atol=1e-6)
    assert np.abs(gaps(found, parts) - gaps(shape, parts)).max() < 0.1
    like = gradients.vertices_like(gradients.features(shape), shape)
    np.testing.assert_allclose(like - like.mean(0), shape - shape.mean(0), atol=1e-6)


@pytest.mark.parametrize("way", ["laplacian", "elastic", "arap"])
def test_what_no_anchor_holds_goes_along(balls, way):
    vertices, faces, parts = balls
    anchors = np.flatnonzero(parts == 1)[::20]
    goals = vertices[anchors] + [0.1, 0.2, -0.1]
    if way == "laplacian":
        found = LaplacianDeformation(vertices, faces, anchors, 10.0).move(goals)
    elif way == "elastic":
        elastic = ElasticAnchors(vertices, faces, anchors)
        found = vertices + elastic.move(anchors, goals - vertices[anchors], 1e3)
    else:
        found = deform_arap(vertices, faces, anchors, goals - vertices[anchors])
    np.testing.assert_allclose(found, vertices + [0.1, 0.2, -0.1], atol=1e-4)


def test_a_part_beside_a_pull_follows_and_one_far_from_it_less(balls):
    vertices, faces, parts = balls
    skin = np.flatnonzero(parts == 1)
    near = skin[np.argsort(((vertices[skin] - vertices[parts == 0].mean(0)) ** 2).sum(1))[:15]]
    anchors = np.concatenate([near, skin[::7][~np.isin(skin[::7], near)]])
    goals = vertices[anchors].copy()
    goals[:15] += [0.0, 0.0, 0.3]
    moved = LaplacianDeformation(vertices, faces, anchors, 10.0).move(goals) - vertices
    assert moved[parts == 0, 2].mean() > 0.1 > 4 * abs(moved[parts == 2, 2].mean())


def test_curvature_is_exaggerated_together(balls):
    vertices, faces, parts = balls
    found = exaggerate_curvature(vertices, faces, [0.0, 0.2])
    np.testing.assert_allclose(found[0], vertices, atol=1e-6)
    assert np.abs(gaps(found[1], parts) - gaps(vertices, parts)).max() < 0.3


def test_what_lies_in_a_pocket_does_not_push_it(ball):
    vertices, faces = ball
    region = np.flatnonzero(vertices[:, 2] > 0.3)
    dent = vertices.copy()
    dent[region, 2] = 0.6 - dent[region, 2]
    inner = 0.02 * vertices + [0, 0, -0.3]
    alone = Cavities(dent, faces, [region]).tuck(dent)
    both, triangles = np.concatenate([dent, inner]), np.concatenate([faces, faces + len(dent)])
    np.testing.assert_allclose(Cavities(both, triangles, [region]).tuck(both)[: len(dent)], alone, atol=1e-9)
