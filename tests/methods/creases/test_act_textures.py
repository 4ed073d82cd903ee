import numpy as np
import pytest

from caricli.data.identities import Identity
from caricli.data.regular_face import align_person
from caricli.methods.creases import act_textures
from caricli.methods.creases.act_textures import ActSettings, Role, TextureSource
from caricli.methods.pictures.settings import PoseSettings
from caricli.template.head import load_head

BROWS = {"browInnerUp": 1.0, "browOuterUpLeft": 1.0, "browOuterUpRight": 1.0}
STILL = PoseSettings(yaw=0, pitch=0, roll=0, turned=0, rolled=0, perspective=0, aside=0)


@pytest.fixture(scope="module")
def source():
    return TextureSource(load_head().template(), 96, 5, ActSettings(pose=STILL))


@pytest.fixture(scope="module")
def old(source):
    """An old man who is calm, raises his brows, and opens his mouth."""
    head = load_head()
    identity = Identity(1.0, 1.0, 0.5, {})
    person = align_person(identity, head.evaluate(**vars(identity)), source.template)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(act_textures, "random_acts", lambda *_: [{}, BROWS, {"jawOpen": 0.8}])
        yield source.act(Role(4, 0, person, 1, 0.0, "train", 3))


def changes(source, acted, name, k):
    """Mean change of seen texels of a region."""
    region = source.grid.bake(source.template.mask(name)[:, None].astype(float))[..., 0] > 0.9
    shown = region & acted.seen[0] & acted.seen[k]
    return np.abs(acted.pictures[k].astype(float) - acted.pictures[0])[shown].mean()


def test_an_old_forehead_folds_when_brows_rise(source, old):
    assert old.age > 0.5
    folded = changes(source, old, "forehead", 1)
    assert folded > 2.5 * changes(source, old, "chin", 1)
    assert folded > 2.5 * changes(source, old, "forehead", 2)


def test_an_open_mouth_is_dark_where_lips_were(source, old):
    inside = source.grid.mouth
    calm, _, opened = old.pictures.astype(float).mean(-1)
    assert opened[inside].mean() < 0.75 * calm[inside].mean()
    assert old.seen[2][inside].all()


def test_without_an_expression_nothing_changes(source, old):
    np.testing.assert_array_equal(old.vertices[0], old.neutral)
    assert changes(source, old, "nose", 2) < 6
