import numpy as np
import pytest

from caricli.methods.texture.fill_unseen import FillSettings, fill_unseen, region_colours, vertex_areas
from caricli.methods.texture.picture_view import SeenColours

SKIN = np.array([200.0, 150, 120])
HAIR = np.array([40.0, 30, 25])


@pytest.fixture(scope="module")
def front(head_template):
    """(V,) what a camera in front sees, roughly."""
    z = head_template.vertices[:, 2]
    return np.clip((z - z.min() - 0.6 * np.ptp(z)) / (0.2 * np.ptp(z)), 0, 1)


def test_hair_of_the_scalp_stays_on_the_scalp(head_template, front):
    scalp = head_template.mask("scalp")
    colours = np.where(scalp[:, None], HAIR, SKIN)
    filled = fill_unseen(head_template, SeenColours(colours, front))
    behind = front == 0
    deep = behind & scalp
    assert np.median(np.abs(filled[deep] - HAIR)) < 8
    for names in (("ear_left", "ear_right"), ("neck",)):
        region = head_template.mask(*names) & behind
        assert np.abs(filled[region] - SKIN).mean() < 12, names


def test_a_bald_head_is_bald_behind(head_template, front):
    colours = np.tile(SKIN, (len(front), 1))
    np.testing.assert_allclose(fill_unseen(head_template, SeenColours(colours, front)), colours, atol=0.5)


def test_a_strand_on_a_temple_does_not_go_on(head_template, front):
    strand = head_template.mask("temple_left", "temple_right")
    colours = np.where(strand[:, None], HAIR, SKIN)
    filled = fill_unseen(head_template, SeenColours(colours, front))
    assert np.abs(filled[front == 0] - SKIN).max() < 20


def test_the_dark_of_a_socket_goes_on_in_it(head_template, front):
    """Of which only the left half is seen."""
    socket = head_template.mask("eye_socket_left")
    colours = np.where(socket[:, None], HAIR, SKIN)
    hidden = socket & (head_template.vertices[:, 0] < np.median(head_template.vertices[socket, 0]))
    filled = fill_unseen(head_template, SeenColours(colours, np.where(hidden, 0, front)))
    assert np.abs(filled[hidden] - HAIR).mean() < 60


def test_another_thing_on_ears_is_not_their_colour(head_template, front):
    """On most of what is seen of them, their front halves."""
    ears = head_template.mask("ear_left", "ear_right")
    _, y, z = head_template.vertices.T
    seen = np.where(ears, z > np.median(z[ears]), front)
    blue = ears & (y > np.quantile(y[ears & (seen > 0)], 0.1))
    colours = SeenColours(np.where(blue[:, None], (40, 60, 200), SKIN), seen)
    usual = region_colours(head_template, colours, vertex_areas(head_template), FillSettings())
    np.testing.assert_allclose(usual[ears], np.tile(SKIN, (ears.sum(), 1)), atol=5)


def test_what_is_seen_stays(head_template, front):
    generator = np.random.default_rng(0)
    colours = SKIN + 5 * generator.normal(size=(len(front), 3))
    filled = fill_unseen(head_template, SeenColours(colours, front))
    assert np.abs(filled - colours)[front == 1].max() < 1
