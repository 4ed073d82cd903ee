import igl
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import NumericsError
from caricli.geometry.deformation.exaggerate_curvature import MAX_LOG_WEIGHT, SMOOTHING, exaggerate_curvature


@pytest.fixture(scope="module")
def lump(ball):
    """The ball with a sharp nose in front and a flattened back."""
    vertices, faces = ball
    nose = np.exp(-6 * ((vertices - [0, 0, 1]) ** 2).sum(1))
    vertices = vertices + 0.5 * nose[:, None] * [0, 0, 1]
    return vertices * np.where(vertices[:, 2:] < 0, [1.0, 1.0, 0.6], [1.0, 1.0, 1.0]), faces


def edge_lengths(vertices, faces):
    return np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=-1)


def dense_weights(vertices, faces, exponent, hold):
    """|K|^gamma by angle defects, smoothed in dense matrices."""
    corners = vertices[faces]
    defect = np.full(len(vertices), 2 * np.pi)
    for k in range(3):
        u, v = corners[:, k - 1] - corners[:, k], corners[:, k - 2] - corners[:, k]
        cosine = (u * v).sum(1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
        np.subtract.at(defect, faces[:, k], np.arccos(cosine))
    laplacian, mass = -igl.cotmatrix(vertices, faces).toarray(), igl.massmatrix(vertices, faces).toarray()
    area = mass.sum()
    curvature = np.abs(defect) / np.diag(mass) * area
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    once, count = np.unique(edges, axis=0, return_counts=True)
    rim = np.unique(once[count == 1])
    curvature[rim] = np.median(curvature)
    smooth = np.linalg.inv(mass + SMOOTHING * area * laplacian) @ mass
    logarithm = smooth @ np.log(np.maximum(curvature, 1e-3))
    logarithm -= np.diag(mass) @ logarithm / area
    logarithm *= np.clip(1 - smooth @ hold, 0, 1) * (1 - hold)
    weights = np.exp(np.clip(exponent * logarithm, -MAX_LOG_WEIGHT, MAX_LOG_WEIGHT))
    return weights / (np.diag(mass) @ weights / area)


@pytest.mark.parametrize("mesh", ["lump", "patch"])
def test_the_dense_minimiser_of_the_energy_agrees(mesh, request):
    vertices, faces = request.getfixturevalue(mesh)
    hold = np.exp(-4 * ((vertices - vertices[40]) ** 2).sum(1))
    weights = dense_weights(vertices, faces, 0.3, hold)[faces].mean(1)
    rows, right = [], []
    for face, weight in zip(faces, weights, strict=True):
        a, b, c = vertices[face]
        # The gradient of a linear function in the triangle's plane, from its values at the corners.
        frame = np.stack([b - a, c - a])
        gradient = np.zeros((3, len(vertices)))
        gradient[:, face] = np.linalg.pinv(frame) @ [[-1, 1, 0], [-1, 0, 1]]
        root = np.sqrt(np.linalg.norm(np.cross(*frame)) / 2)
        rows.append(root * gradient)
        right.append(root * weight * gradient @ vertices)
    expected = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=1e-10)[0]
    expected += vertices.mean(0) - expected.mean(0)
    assert np.abs(exaggerate_curvature(vertices, faces, [0.3], hold)[0] - expected).max() < 1e-6


def test_exponent_zero_changes_nothing(lump):
    vertices, faces = lump
    before = vertices.copy()
    unchanged = exaggerate_curvature(vertices, faces, [0.0])
    assert unchanged.shape == (1, *vertices.shape)
    assert np.abs(unchanged[0] - vertices).max() < 1e-6
    assert np.array_equal(vertices, before)


def test_larger_exponents_deviate_more_and_keep_the_centroid(lump):
    levels = exaggerate_curvature(*lump, [0.05, 0.1, 0.2, 0.3])
    deviation = np.linalg.norm(levels - lump[0], axis=-1).mean(-1)
    assert (np.diff(deviation) > 0.3 * deviation[0]).all()
    assert np.abs(levels.mean(1) - lump[0].mean(0)).max() < 1e-9


def test_the_sharp_tip_grows_and_the_flat_back_shrinks(lump):
    vertices, faces = lump
    before, after = (edge_lengths(v, faces) for v in (vertices, exaggerate_curvature(vertices, faces, [0.3])[0]))
    height = vertices[faces][..., 2]
    tip, back = (height > 1.2).all(1), (height < -0.5).all(1)
    assert (after / before)[tip].mean() > 1.2
    assert (after / before)[back].mean() < 1.0


def test_a_sphere_stays_a_sphere(ball):
    for vertices in exaggerate_curvature(*ball, [0.1, 0.3]):
        assert np.abs(np.linalg.norm(vertices - vertices.mean(0), axis=1) - 1).max() < 0.01


def test_every_level_is_what_it_is_alone(lump):
    together = exaggerate_curvature(*lump, [0.1, 0.25])
    assert np.allclose(together[1], exaggerate_curvature(*lump, [0.25])[0], atol=1e-12)


def test_the_result_turns_moves_and_scales_with_the_input(lump):
    vertices, faces = lump
    rotation = Rotation.from_rotvec([0.5, 1.5, -0.8]).as_matrix()
    expected = 3 * exaggerate_curvature(vertices, faces, [0.25])[0] @ rotation.T + [1, 2, 3]
    found = exaggerate_curvature(3 * vertices @ rotation.T + [1, 2, 3], faces, [0.25])[0]
    assert np.abs(found - expected).max() < 1e-6


def test_a_held_region_keeps_its_size(lump):
    vertices, faces = lump
    hold = (vertices[:, 2] > 0.6).astype(float)
    inside = (vertices[faces][..., 2] > 0.8).all(1)
    lengths = edge_lengths(vertices, faces)[inside]
    free, held = (edge_lengths(exaggerate_curvature(vertices, faces, [0.3], h)[0], faces)[inside] for h in (None, hold))
    changes = [np.abs(e / lengths - 1).mean() for e in (free, held)]
    assert changes[1] < 0.1 < changes[0]
    assert np.std(held / lengths) < 0.05


def test_everything_held_changes_nothing(lump):
    vertices, faces = lump
    assert np.abs(exaggerate_curvature(vertices, faces, [0.3], np.ones(len(vertices)))[0] - vertices).max() < 1e-6


def test_a_surface_with_a_boundary_stays_sane(patch):
    vertices, faces = patch
    exaggerated = exaggerate_curvature(vertices, faces, [0.3])[0]
    assert np.linalg.norm(exaggerated - vertices, axis=1).max() < 0.5 * np.ptp(vertices)


@pytest.mark.parametrize("where", [0.0, 0.3])
def test_a_triangle_without_area_is_refused(ball, where):
    vertices, faces = ball[0].copy(), ball[1]
    a, b, c = faces[7]
    vertices[c] = (1 - where) * vertices[a] + where * vertices[b]
    with pytest.raises(NumericsError, match="area"):
        exaggerate_curvature(vertices, faces, [0.1])


def test_a_vertex_outside_every_triangle_is_refused(ball):
    with pytest.raises(NumericsError, match="every vertex"):
        exaggerate_curvature(np.concatenate([ball[0], [[2.0, 0, 0]]]), ball[1], [0.1])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(ball, value):
    vertices = ball[0].copy()
    vertices[3, 0] = value
    with pytest.raises(NumericsError):
        exaggerate_curvature(vertices, ball[1], [0.1])
