import numpy as np

from caricli.methods.morphable.coefficients import turned_light
from caricli.methods.texture.estimate_light import harmonics
from caricli.structures.detection import turn_axes


def test_a_light_that_is_turned_with_what_it_shines_on_lights_it_as_before():
    generator = np.random.default_rng(0)
    light = generator.normal(size=9)
    normals = generator.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    turned = normals.copy()
    turned[:, :2] = normals[:, :2] @ turn_axes(0.7)  # x to the right and a little down: clockwise
    np.testing.assert_allclose(harmonics(turned) @ turned_light(light, 0.7), harmonics(normals) @ light, atol=1e-12)
