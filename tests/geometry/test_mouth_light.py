import numpy as np

from caricli.geometry.mouth_light import mouth_light
from caricli.structures import Material

FACES = np.arange(12).reshape(4, 3)
MATERIALS = np.array([Material.SKIN, Material.TEETH, Material.TONGUE, Material.GUMS])


def test_light_falls_off_behind_the_foremost_tooth():
    """Skin behind all, teeth from 0.02 to 0, a tongue that is out, and gums far back."""
    depth = np.array([-9.0, -9, -9, 0.02, 0.01, 0.0, 0.03, 0.02, -0.01, -0.02, 0, 0.02])
    vertices = np.column_stack([np.zeros((12, 2)), depth])
    light = mouth_light(vertices, FACES, MATERIALS)
    assert light.dtype == np.float32 and (light[:3] == 1).all()
    # As bright as what is foremost, and no brighter before it.
    np.testing.assert_allclose(light[[3, 6, 7, 11]], 1)
    np.testing.assert_allclose(light[9, 0], 0.1, atol=1e-6)
    order = np.argsort(depth[3:], kind="stable")
    assert (np.diff(light[3:][order], axis=0) >= 0).all() and light[4].max() < 0.5
    # What is left of it is red.
    assert (light[[4, 5, 9], 0] > 1.2 * light[[4, 5, 9], 1]).all() and (light[:, 1] >= light[:, 2]).all()


def test_a_mouth_without_teeth_and_a_head_without_a_mouth():
    vertices = np.column_stack([np.zeros((12, 2)), np.linspace(0, -1, 12)])
    tongue = np.where(MATERIALS == Material.TEETH, Material.TONGUE, MATERIALS)
    assert (mouth_light(vertices, FACES, tongue)[3] == 1).all()
    np.testing.assert_array_equal(mouth_light(vertices, FACES, np.full(4, Material.SKIN)), np.ones((12, 3)))
    assert np.isfinite(mouth_light(0 * vertices, FACES, MATERIALS)).all()


def test_in_a_head_without_colour_it_has_none():
    vertices = np.column_stack([np.zeros((12, 2)), np.linspace(0, -1, 12)])
    light = mouth_light(vertices, FACES, MATERIALS, 0.0)
    assert light.min() < 0.5
    np.testing.assert_array_equal(light, light[:, :1].repeat(3, 1))
