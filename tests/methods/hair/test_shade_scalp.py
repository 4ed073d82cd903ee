import numpy as np
import pytest

from caricli.methods.hair import shade_scalp as module
from caricli.methods.hair.dress_hair import dress_hair
from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.shade_scalp import Scalp
from caricli.methods.texture.settings import PaintSettings
from caricli.methods.texture.texture_face import FaceTexture
from caricli.render.visibility.uv_map import uv_map
from tests.methods.hair.conftest import BROWN, CAMERA, SKIN

SIZE = 192


def shading(head, hair):
    """What is painted on a head of one colour of which nothing or all is seen, and where regions are in it."""
    face, _ = uv_map(head, SIZE)
    plain = np.full((SIZE, SIZE, 3), SKIN, np.uint8)

    def painted(seen, colour=BROWN):
        texture = FaceTexture(plain, np.broadcast_to(np.float32(seen), (SIZE, SIZE)), face >= 0, None)
        picture = np.full((SIZE, SIZE, 3), colour, np.uint8)
        return Scalp(head, hair).shaded(texture, picture, np.random.default_rng(0))

    def where(*names):
        return (face >= 0) & head.mask(*names)[head.faces].all(1)[face]

    return painted, where


@pytest.fixture(scope="module")
def scalp(sitter):
    """The shading of a head whose hair is that of a picture."""
    dressed = dress_hair(sitter.face, sitter.head, sitter.image, PaintSettings(SIZE))
    return shading(sitter.head.with_vertices(dressed.face.vertices), dressed.hair)


def test_skin_under_hair_has_its_colour(scalp):
    painted, where = scalp
    away = np.abs(painted(0.0).astype(int) - BROWN).max(-1)
    assert np.median(away[where("scalp")]) <= 1 and (away[where("scalp")] < 60).mean() > 0.8


def test_skin_shines_through_light_hair(sitter):
    """Where it is cropped beside a shell that ends where the picture says so, at its sides, too."""
    hair, head = make_shell(sitter.head, CAMERA, sitter.hair, ShellSettings(aside=0.0))
    painted, _ = shading(head, hair)
    dark, light = (
        (painted(0.0, colour).astype(float) - SKIN).mean(-1) / (np.array(colour) - SKIN).mean()
        for colour in (BROWN, (250, 250, 250))
    )
    cropped = (dark > 0.8) & (dark < 0.99)
    assert cropped.sum() > 100
    assert 0.2 < np.median(light[cropped]) < 0.8 * np.median(dark[cropped])
    assert light[dark == 1].mean() > 0.998


def test_a_face_and_its_ears_stay_as_they_are(scalp):
    painted, where = scalp
    others = where("ear_left", "ear_right") | where("nose", "mouth", "chin")
    assert others.sum() > 1000 and (painted(0.0)[others] == SKIN).all()


def test_it_fades_out_and_stays_nearer_where_skin_is_seen(scalp):
    painted, _ = scalp
    share = [np.abs(painted(seen).astype(float) - SKIN).max(-1) / 140 for seen in (0.0, 1.0)]
    between = (share[0] > 0.1) & (share[0] < 0.9)
    assert between.mean() > 0.005
    assert share[1].sum() < 0.97 * share[0].sum()


def test_the_seed_decides_its_grain(scalp):
    painted, _ = scalp
    np.testing.assert_array_equal(painted(0.0), painted(0.0))


def test_a_glimpse_of_skin_is_no_hole_in_hair(scalp):
    painted, where = scalp
    row, column = np.argwhere(where("scalp"))[len(np.argwhere(where("scalp"))) // 2]
    seen = np.zeros((SIZE, SIZE), np.float32)
    seen[row - 3 : row + 4, column - 3 : column + 4] = 1
    np.testing.assert_array_equal(painted(seen), painted(0.0))
    assert (painted(np.ones((SIZE, SIZE), np.float32)) != painted(0.0)).any()


def test_slivers_and_holes_of_a_few_directions_do_not_count():
    hair = np.zeros((40, 60), bool)
    hair[5:30] = True
    torn = hair.copy()
    torn[35, 10:12] = True
    torn[12:15, 20:23] = False
    np.testing.assert_array_equal(module._without_specks(torn), hair)
    wide = hair.copy()
    wide[10:20, 20:30] = False
    np.testing.assert_array_equal(module._without_specks(wide), wide)
