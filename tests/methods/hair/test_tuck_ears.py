from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.hair.fit_outline import Outline
from caricli.methods.hair.hair_view import HairView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.tuck_ears import tuck_ears
from caricli.template.annotation import EARS
from tests.methods.hair.conftest import CAMERA

SETTINGS = ShellSettings()


def covered(sitter, share):
    """The view of a sitter whose ears are under hair down to a share of their height."""
    pixels = sitter.hair.pixels.copy()
    for name in EARS:
        x, y = CAMERA.project(sitter.head.vertices[sitter.head.annotation.regions[name]]).T
        columns = slice(int(x.min()) - 2, int(x.max()) + 3)
        pixels[int(y.min()) - 2 : int(y.max()) + 3, columns] = False
        pixels[int(y.min()) - 2 : int(y.min() + share * np.ptp(y)), columns] = True
    hair = replace(sitter.hair, pixels=pixels)
    sphere = HeadSphere(sitter.head, SETTINGS)
    return HairView(sitter.head, CAMERA, hair, Outline.of(hair, sphere, CAMERA, SETTINGS.bins))


def standing_out(head):
    """Metres, how far vertices are out of the skin without ears."""
    sphere = HeadSphere(head, SETTINGS, fine=True)
    return sphere.heights(head.vertices)


def test_what_is_under_hair_lies_against_the_head_and_the_lobe_stays(sitter):
    view = covered(sitter, 0.75)
    tucked = tuck_ears(HeadSphere(sitter.head, SETTINGS, fine=True), view, SETTINGS)
    ears = sitter.head.mask(*EARS)
    np.testing.assert_allclose(tucked.vertices[~ears], sitter.head.vertices[~ears], rtol=0, atol=1e-12)
    for name in EARS:
        ids = sitter.head.annotation.regions[name]
        y = CAMERA.project(sitter.head.vertices[ids])[:, 1]
        top, lobe = ids[y < y.min() + 0.5 * np.ptp(y)], ids[y > y.max() - 0.1 * np.ptp(y)]
        before, after = (np.maximum(standing_out(head)[top], 0).max() for head in (sitter.head, tucked))
        assert after < 0.4 * before
        np.testing.assert_allclose(tucked.vertices[lobe], sitter.head.vertices[lobe], rtol=0, atol=2e-3)


def test_the_head_under_a_shell_has_them_so(sitter):
    _, under = make_shell(sitter.head, CAMERA, covered(sitter, 0.75).hair)
    moved = np.linalg.norm(under.vertices - sitter.head.vertices, axis=1)
    ears = sitter.head.mask(*EARS)
    assert moved[ears].max() > 0.01 * sitter.head.height


@pytest.mark.parametrize("share", [0.6, 0.75, 0.9])
def test_no_triangle_of_a_tucked_ear_is_turned_over(sitter, share):
    tucked = tuck_ears(HeadSphere(sitter.head, SETTINGS, fine=True), covered(sitter, share), SETTINGS)
    before, after = (flipped_triangles(head.vertices, sitter.head.gradients) for head in (sitter.head, tucked))
    assert not (after & ~before).any()


@pytest.mark.parametrize("share", [0.2, 1.2])
def test_ears_that_mostly_show_or_not_at_all_stay(sitter, share):
    tucked = tuck_ears(HeadSphere(sitter.head, SETTINGS, fine=True), covered(sitter, share), SETTINGS)
    np.testing.assert_allclose(tucked.vertices, sitter.head.vertices, rtol=0, atol=1e-12)
