import numpy as np
import pytest

from caricli.methods.texture.estimate_light import GAMMA, LightSettings, estimate_light, harmonics

VIEW = np.array([0.0, 0, 1])
SKIN = np.array([205.0, 160, 130])


@pytest.fixture(scope="module")
def surface():
    """Normals (N, 3) that a camera sees of a bumpy sphere, and its places."""
    generator = np.random.default_rng(0)
    places = generator.normal(size=(1500, 3))
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    normals = places + 0.35 * generator.normal(size=places.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = (normals @ VIEW > 0.15) & (places @ VIEW > 0.15)
    return normals[seen], places[seen]


def lit(normals):
    """Factors (N, 3) of linear light: a warm lamp from the left above and a bluish sky."""
    way = np.array([-0.6, 0.5, 0.6]) / np.linalg.norm([-0.6, 0.5, 0.6])
    light = np.maximum(normals @ way, 0)[:, None] * [1.1, 1.0, 0.9]
    return light + (0.4 + 0.1 * normals[:, 1:2]) * [0.9, 1.0, 1.1]


def estimated(colours, surface):
    normals, places = surface
    return estimate_light(colours, normals, places, np.ones(len(normals)), VIEW)


def test_harmonics_are_orthonormal():
    generator = np.random.default_rng(1)
    ways = generator.normal(size=(200_000, 3))
    basis = harmonics(ways / np.linalg.norm(ways, axis=1, keepdims=True))
    np.testing.assert_allclose(4 * np.pi * basis.T @ basis / len(ways), np.eye(9), atol=0.03)


def test_light_is_taken_out_though_a_fifth_is_hair(surface):
    normals, places = surface
    hair = places[:, 1] > 0.55
    assert 0.1 < hair.mean() < 0.3
    own = np.where(hair[:, None], [40.0, 30, 25], SKIN * (1 + 0.03 * np.sin(40 * places[:, :1])))
    pictured = own * lit(normals) ** (1 / GAMMA)
    light = estimated(pictured, surface)
    assert light.explained > 0.3
    plain = (pictured / light.shade(normals))[~hair]
    before = (pictured[~hair] / pictured[~hair].mean(0)).std(0).max()
    after = (plain / plain.mean(0)).std(0).max()
    assert after < 0.45 * before, (before, after)


def test_flat_colours_have_no_light(surface):
    normals, places = surface
    generator = np.random.default_rng(2)
    spots = np.where((places[:, :1] > 0.2) & (places[:, 1:2] < 0), [225.0, 120, 110], SKIN)
    assert estimated(spots, surface) is None
    assert estimated(SKIN + generator.normal(0, 6, spots.shape), surface) is None
    assert estimate_light(SKIN[None], VIEW[None], VIEW[None], np.ones(1), VIEW) is None


@pytest.mark.parametrize("colour", [SKIN, np.zeros(3), np.full(3, 255.0)])
def test_one_colour_all_over_has_no_light(surface, colour):
    """There is nothing to explain, so all of it would be."""
    assert estimated(np.tile(colour, (len(surface[0]), 1)), surface) is None


def test_the_mean_of_what_a_camera_sees_stays(surface):
    normals, _ = surface
    light = estimated(SKIN * lit(normals) ** (1 / GAMMA), surface)
    generator = np.random.default_rng(3)
    ways = generator.normal(size=(20_000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    np.testing.assert_allclose((harmonics(ways[ways @ VIEW > 0]) @ light.coefficients).mean(0), 1, atol=0.03)


def test_no_light_is_brighter_on_the_face_than_lamps_are(surface):
    """A flat face in a drawing whose colours darken towards its outlines, as if lit from the camera alone."""
    towards = surface[0] @ VIEW
    normals, places = (each[towards > 0.5] for each in surface)
    light = estimated(SKIN * (normals @ VIEW)[:, None] ** (2 / GAMMA), (normals, places))
    assert np.isclose((harmonics(normals) @ light.coefficients).mean(), LightSettings().brightest)


def test_a_brighter_picture_has_the_same_light(surface):
    normals, _ = surface
    pictured = 0.6 * SKIN * lit(normals) ** (1 / GAMMA)
    first = estimated(pictured, surface)
    second = estimated(1.3 * pictured, surface)
    np.testing.assert_allclose(first.coefficients, second.coefficients, rtol=1e-3, atol=1e-3)


def test_a_point_far_from_all_others_hardly_changes_what_is_explained(surface):
    """Parts that are left out are of equal weight, wherever single points are."""
    normals, places = surface
    pictured = SKIN * lit(normals) ** (1 / GAMMA)
    usual = estimated(pictured, surface)
    places = np.concatenate([places, [[0.0, -9.0, 0.0]]])
    normals = np.concatenate([normals, [VIEW]])
    pictured = np.concatenate([pictured, [SKIN]])
    weights = np.ones(len(places))
    light = estimate_light(pictured, normals, places, weights, VIEW)
    assert abs(light.explained - usual.explained) < 0.02
    # Where it is nearly all that counts, no part but its own has any weight.
    weights[-1] = 1e9
    assert estimate_light(pictured, normals, places, weights, VIEW) is None


def painted(surface, generator):
    """Colours (N, 3) of a face in soft light with a cloth of another colour before its lower half."""
    normals, places = surface
    cloth = generator.uniform(40, 200, 3)
    own = np.where(places[:, 1:2] < generator.uniform(-0.3, 0.1), cloth, SKIN)
    return own * (0.5 + 0.5 * lit(normals)) ** (1 / GAMMA) * generator.normal(1, 0.1, (len(normals), 1))


@pytest.mark.parametrize("seed", range(12))
def test_light_before_a_cloth_is_light_that_can_be(surface, seed):
    """Nowhere less than none, and without opposite colours on opposite sides."""
    light = estimated(painted(surface, np.random.default_rng(seed)), surface)
    if light is not None:
        relative = light.coefficients[1:] / light.coefficients[0]
        # A single lamp in the dark has so much of the first and the second order.
        assert (np.linalg.norm(relative[:3], axis=0) < 1.155).all()
        assert (np.linalg.norm(relative[3:], axis=0) < 0.56).all()
        assert np.linalg.norm(relative - relative.mean(1, keepdims=True), axis=0).max() < 0.65
