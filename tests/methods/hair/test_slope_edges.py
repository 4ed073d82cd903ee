import numpy as np
import pytest

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.slope_edges import slope_edges
from caricli.methods.hair.visible_hair import visible_hair
from tests.methods.hair.conftest import CAMERA

SETTINGS = ShellSettings()


@pytest.fixture(scope="module")
def sphere(sitter):
    return HeadSphere(sitter.head, SETTINGS, fine=True)


def stepped(sitter, sphere, thick, steep=True):
    """Hair so thick, shares of the head's height, that goes under the skin from one row to the next."""
    hair, _ = make_shell(sitter.head, CAMERA, sitter.hair)
    longitudes, angles, _ = sphere.seen_from(hair.shell.vertices)
    ground = sphere.ground(longitudes, angles)
    above = np.where(angles < np.radians(70), thick, -0.02 if steep else thick) * sphere.head.height
    points = sphere.points(longitudes, angles, ground + above)
    return type(hair)(hair.shell.with_vertices(points), hair.roots, hair.weights)


def heights(hair, sphere):
    longitudes, angles, radii = sphere.seen_from(hair.shell.vertices)
    return (radii - sphere.ground(longitudes, angles)) / sphere.head.height, angles


def sloped(hair, sitter, sphere):
    shown = visible_hair(sitter.head, hair, CAMERA, sitter.hair.pixels.shape)
    return slope_edges(hair, sphere, CAMERA, shown, SETTINGS)


def test_short_hair_rises_in_a_slope_where_it_is_no_outline(sitter, sphere):
    hair = stepped(sitter, sphere, 0.028)
    slope = sloped(hair, sitter, sphere)
    before, angles = heights(hair, sphere)
    after, _ = heights(slope, sphere)
    edge = (before > 0) & (angles > np.radians(67))
    assert np.median(after[edge]) < 0.75 * np.median(before[edge])
    np.testing.assert_allclose(after[before < 0], before[before < 0], atol=1e-6)
    inner = angles < np.radians(50)
    np.testing.assert_allclose(after[inner], before[inner], atol=1e-3)
    # Without the skin below it, which at the whorl is that of one of many longitudes.
    rise = sphere.seen_from(slope.shell.vertices)[2] - sphere.seen_from(hair.shell.vertices)[2]
    assert (rise / sphere.head.height <= 1e-6).all()


def test_long_hair_and_hair_that_does_not_end_stay(sitter, sphere):
    for hair in (stepped(sitter, sphere, 0.07), stepped(sitter, sphere, 0.028, steep=False)):
        same = sloped(hair, sitter, sphere)
        np.testing.assert_allclose(same.shell.vertices, hair.shell.vertices, atol=2e-5)


def test_the_outline_that_a_picture_shows_stays(sitter, sphere):
    hair = stepped(sitter, sphere, 0.028)
    shape = sitter.hair.pixels.shape
    before, after = (visible_hair(sitter.head, each, CAMERA, shape) for each in (hair, sloped(hair, sitter, sphere)))
    assert (before & after).sum() / (before | after).sum() > 0.97
