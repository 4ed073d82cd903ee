import numpy as np
import pytest

from caricli.geometry.comb_hair import MATT, THIN, comb_hair
from caricli.render.smooth_normals import smooth_normals

SIDE = 41


def sheet(height):
    """A square of 2 x 2 around the origin, seen from +z; height: at x and y."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE))
    k = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x, y, np.broadcast_to(height(x, y), x.shape)], -1).reshape(-1, 3), faces


@pytest.fixture
def covered():
    """Flat skin below hair that is dented all over, thin on the left and thick on the right; both as one mesh."""
    skin, faces = sheet(lambda x, y: 0.0)
    hair, _ = sheet(lambda x, y: 0.005 + 0.2 * (x > 0) + 0.004 * np.cos(40 * y))
    vertices = np.concatenate([skin, hair])
    whole = np.concatenate([faces, faces + len(skin)])
    is_hair = np.arange(len(whole)) >= len(faces)
    return vertices, whole, smooth_normals(vertices, whole), is_hair, ~is_hair


def test_thin_hair_is_shaded_as_the_skin_below_and_does_not_shine(covered):
    vertices, _, normals, hair, skin = covered
    combed = comb_hair(*covered)
    shaded = combed.normals(normals)
    np.testing.assert_allclose(np.linalg.norm(shaded, axis=1), 1, atol=1e-12)
    on_hair = np.arange(len(vertices)) >= SIDE * SIDE
    np.testing.assert_array_equal(shaded[~on_hair], normals[~on_hair])
    assert (combed.shine[~on_hair] == 1).all()
    thin = on_hair & (vertices[:, 0] < -0.2)
    thick = on_hair & (vertices[:, 0] > 0.4)
    slope = {"own": np.abs(normals[:, 1]), "shaded": np.abs(shaded[:, 1])}
    assert slope["shaded"][thin].max() < 0.25 * slope["own"][thin].max()
    assert combed.shine[thin].max() < 0.2 < 0.99 < combed.shine[thick].min()
    # Above the bounds hair has normals of its own, though calmer ones.
    assert (combed.lying[vertices[on_hair, 0] > 0.4] == 0).all()
    assert 0 < slope["shaded"][thick].max() < slope["own"][thick].max()


@pytest.mark.parametrize("tall", [1, 3])
def test_between_thin_and_thick_it_goes_over_slowly(covered, tall):
    """From the skin up, by its height, twice ``tall``; how far the hair hangs down does not count."""
    skin, faces = sheet(lambda x, y: 0.0)
    hair, _ = sheet(lambda x, y: 0.12 * (x + 1) / 2)
    vertices = np.concatenate([skin * [1, tall, 1], hair * [1, 1.5 * tall, tall]])
    whole = np.concatenate([faces, faces + len(skin)])
    combed = comb_hair(vertices, whole, smooth_normals(vertices, whole), *covered[3:])
    thickness = hair[:, 2] / 2  # of both, which grow alike
    at = np.argsort(thickness, kind="stable")
    lying = combed.lying[at]
    shine = combed.shine[len(skin) :][at]
    assert lying[0] > 0.99 and (lying[thickness[at] > 1.02 * THIN] == 0).all() and (np.diff(lying) < 1e-6).all()
    # Half-way up it is half of both.
    assert abs(np.interp(THIN / 2, thickness[at], lying) - 0.5) < 0.1
    assert abs(np.interp(MATT / 2, thickness[at], shine) - 0.5) < 0.1
    assert shine[0] < 0.01 and (shine[thickness[at] > 1.02 * MATT] == 1).all() and (np.diff(shine) > -1e-6).all()


def test_skin_that_turns_away_lends_nothing(covered):
    """As the back of an ear, over which hair falls."""
    vertices, faces, _, hair, skin = covered
    faces = np.where(skin[:, None], faces[:, ::-1], faces)
    normals = smooth_normals(vertices, faces)
    combed = comb_hair(vertices, faces, normals, hair, skin)
    assert (combed.lying == 0).all() and (combed.shine == 1).all()


def test_a_mesh_that_moves_is_shaded_by_its_new_normals(covered):
    vertices, faces, normals, _, _ = covered
    combed = comb_hair(*covered)
    turned = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    np.testing.assert_allclose(combed.normals(normals @ turned.T), combed.normals(normals) @ turned.T, atol=1e-12)


def test_without_hair_or_skin_nothing_is_combed(covered):
    vertices, faces, normals, hair, _ = covered
    none = np.zeros(len(faces), bool)
    assert comb_hair(vertices, faces, normals, none, ~none) is None
    assert comb_hair(vertices, faces, normals, ~none, none) is None


def test_skin_without_an_area_spoils_nothing(covered):
    vertices, faces, normals, hair, skin = covered
    vertices = np.where(np.arange(len(vertices))[:, None] < 5, vertices[0], vertices)
    combed = comb_hair(vertices, faces, normals, hair, skin)
    assert np.isfinite(combed.normals(normals)).all() and np.isfinite(combed.shine).all()


def test_skin_in_one_place_spoils_nothing(covered):
    vertices, faces, normals, hair, skin = covered
    vertices = np.where(np.arange(len(vertices))[:, None] < SIDE * SIDE, vertices[0], vertices)
    combed = comb_hair(vertices, faces, normals, hair, skin)
    assert np.isfinite(combed.normals(normals)).all() and np.isfinite(combed.shine).all()
