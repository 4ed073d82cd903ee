from dataclasses import replace

import numpy as np

from caricli.methods.hair.fit_outline import Outline
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.structures import Camera
from tests.methods.hair.conftest import CAMERA

SETTINGS = ShellSettings()


def test_hair_that_the_border_of_the_picture_cuts_off_goes_on_round(sitter):
    top = np.nonzero(sitter.hair.pixels.any(1))[0][0]
    sphere = HeadSphere(sitter.head, SETTINGS)
    whole = Outline.of(sitter.hair, sphere, CAMERA, SETTINGS.bins)
    for rows, some in ((8, True), (60, False)):
        cut = replace(sitter.hair, pixels=sitter.hair.pixels[top + rows :], behind=sitter.hair.behind[top + rows :])
        camera = Camera(CAMERA.scale, CAMERA.rotation, CAMERA.translation - [0, top + rows])
        outline = Outline.of(cut, sphere, camera, SETTINGS.bins)
        upwards = slice(SETTINGS.bins * 3 // 4 - 3, SETTINGS.bins * 3 // 4 + 3)
        assert np.isfinite(outline.radii[upwards]).all() == some
        if some:
            np.testing.assert_allclose(outline.radii[upwards], whole.radii[upwards], rtol=0.12)


def test_what_is_a_rounding_error_before_the_right_is_there():
    outline = Outline(np.array([50.0, 50.0]), np.full(240, 20.0), np.full(240, np.nan))
    share, outermost = outline.compare(np.array([[90.0, 50 - 7.2e-15]]), np.array([True]))
    np.testing.assert_allclose(share, 0.5)
    assert outermost.all()
