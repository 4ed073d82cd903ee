from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.hidden_hairline import hidden_reach, reach_inside, usual_reach, without_corners
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.settings import ShellSettings
from tests.methods.hair.conftest import CAMERA

SETTINGS = ShellSettings()


@pytest.fixture(scope="module")
def sphere(sitter):
    return HeadSphere(sitter.head, SETTINGS)


def above_skin(shell, head):
    """Metres that the vertices of a shell are above the skin, by directions from the middle of a head."""
    fine = HeadSphere(head, SETTINGS, fine=True)
    longitudes, angles, radii = fine.seen_from(shell.shell.vertices)
    return radii - fine.ground(longitudes, angles), fine.directions(longitudes, angles)


def test_bare_ears_stay_free(sitter):
    """And those that the picture shows under hair do not."""
    picture = np.ones_like(sitter.hair.pixels)
    for hair, free in ((sitter.hair, True), (replace(sitter.hair, pixels=picture, behind=~picture), False)):
        shell, head = make_shell(sitter.head, CAMERA, hair)
        above, ways = above_skin(shell, head)
        sphere = HeadSphere(head, SETTINGS)
        ears = head.vertices[head.mask("ear_left", "ear_right")]
        x, y = CAMERA.project(ears).T.round().astype(int)
        ears = ears[~sitter.hair.pixels[y, x]]
        assert len(ears) > 100
        longitudes, angles, _ = sphere.seen_from(ears)
        near = KDTree(sphere.directions(longitudes, angles)).query(ways)[0] * 0.08 < SETTINGS.clear / 2 * head.height
        assert near.sum() > 50
        assert (above[near].max() < 0) == free


def test_an_ear_that_mostly_shows_stays_free_of_strands_on_its_top(sitter):
    ears = [sitter.head.vertices[sitter.head.annotation.regions[name]] for name in ("ear_left", "ear_right")]
    pixels = sitter.hair.pixels.copy()
    for ear in ears:
        x, y = CAMERA.project(ear).T.round().astype(int)
        pixels[y.min() : y.max() + 1, x.min() : x.max() + 1] = False
        pixels[y.min() : y.min() + (y.max() - y.min()) // 3, x.min() : x.max() + 1] = True
    shell, head = make_shell(
        sitter.head, CAMERA, replace(sitter.hair, pixels=pixels, behind=sitter.hair.behind & ~pixels)
    )
    above, ways = above_skin(shell, head)
    sphere = HeadSphere(head, SETTINGS)
    for ear in ears:
        longitudes, angles, _ = sphere.seen_from(ear)
        near = KDTree(sphere.directions(longitudes, angles)).query(ways)[0] * 0.08 < SETTINGS.clear / 2 * head.height
        assert near.sum() > 20
        assert above[near].max() < 0


def test_it_thins_towards_the_nape(sitter):
    shell, head = make_shell(sitter.head, CAMERA, sitter.hair)
    above = above_skin(shell, head)[0][1:].reshape(SETTINGS.rows, SETTINGS.columns)
    nape = above[:, SETTINGS.columns // 2]
    rows = np.flatnonzero(nape > 0)[-10:]
    ends = nape[rows]
    assert (np.diff(ends) < 0).all() and ends[-1] < 0.25 * ends[0]
    last = [np.flatnonzero(column > 0)[-1] for column in above.T[80:112]]
    assert len(set(last)) > 1


def test_no_corner_is_left(sphere):
    count = len(sphere.longitudes)
    edge = np.where(np.abs(sphere.longitudes - np.pi) < 1, 2.1, 1.2)
    calm = without_corners(sphere, edge, SETTINGS)
    turn = 2 * np.pi / count
    assert (calm <= edge).all()
    assert np.abs(np.diff(calm)).max() <= 1.01 * SETTINGS.slope * turn
    assert calm[count // 2] == pytest.approx(2.1)
    np.testing.assert_allclose(without_corners(sphere, np.full(count, 1.5), SETTINGS), 1.5)


def test_reach_is_measured_across_the_hairline(sphere):
    plain = replace(SETTINGS, tuft=0.0)
    level = hidden_reach(sphere, np.full(len(sphere.longitudes), 2.0), plain)
    assert (level[sphere.angles < 2.0] > 0).all() and (level[sphere.angles > 2.0] < 0).all()
    steep = 1.6 + 0.4 * np.sin(3 * sphere.longitudes)
    reach = hidden_reach(sphere, steep, plain)
    along = (steep - sphere.angles[:, None]) * sphere.radii
    assert (np.abs(reach) <= np.abs(along) + 1e-12).all()
    assert np.abs(reach).sum() < 0.9 * np.abs(along).sum()


def test_reach_inside_is_the_way_to_the_border(sphere):
    cap = np.broadcast_to(sphere.angles[:, None] < 1.2, sphere.radii.shape)
    reach = reach_inside(sphere, cap)
    turn = sphere.angles[1] - sphere.angles[0]
    clear = np.abs(sphere.angles - 1.2) > 3 * turn
    assert ((reach > 0) == cap)[clear].all()
    assert (np.diff(reach, axis=0)[20:30] < 0).all()


def test_hair_usually_goes_round_the_ears_to_the_nape(sphere):
    reach = usual_reach(sphere, SETTINGS)
    marks = sphere.head.vertices[sphere.head.annotation.landmarks]
    crown, brow, nose = marks.mean(0) + [0, 0.2, -0.1], marks[19], marks[30]
    nape = sphere.middle + [0, -0.02, -0.1]
    behind = sphere.middle + [0.08, 0, -0.05]
    places = np.stack([crown, nape, behind, brow, nose])
    longitudes, angles, _ = sphere.seen_from(places)
    assert ((sphere.sample(reach, longitudes, angles) > 0) == [True, True, True, False, False]).all()


def test_what_is_hidden_grows_to_the_usual_hairline(sitter):
    shell, head = make_shell(sitter.head, CAMERA, sitter.hair)
    above, ways = above_skin(shell, head)
    fine = HeadSphere(head, SETTINGS, fine=True)
    longitudes, angles, _ = fine.seen_from(fine.middle + ways)
    deep = fine.sample(usual_reach(fine, SETTINGS), longitudes, angles) > 0.03 * head.height
    behind = ways @ CAMERA.rotation[2] > 0.5
    assert (above[deep & behind] > 0).mean() > 0.98


def test_it_is_a_number_where_there_is_no_hair(sphere):
    ends = np.full(len(sphere.longitudes), 1.5)
    ends[10:20] = 0.0
    reach = hidden_reach(sphere, ends, SETTINGS)
    assert np.isfinite(reach).all() and (reach[2:, 11:19] < 0).all()
    assert (reach[2:20, 30:] > 0).all()
