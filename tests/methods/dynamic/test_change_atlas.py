import numpy as np
import pytest

from caricli.methods.dynamic.change_atlas import LARGEST, change_atlas, paint_changes
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.change_atlas import NOTHING
from caricli.structures.texture_change import TextureChange
from tests.methods.dynamic.test_rig_moods import painter, picture, rig  # noqa: F401

S = 32


class Linear:
    """Stands in for a network whose offset is linear in the weights of two expressions, and -0.1 at rest."""

    size = S

    def change(self, own, maps, source, target, hue):
        more = -0.1 + 0.3 * target[ARKIT_NAMES.index("jawOpen")] + 0.2 * target[ARKIT_NAMES.index("browInnerUp")]
        return TextureChange(np.full((S, S, 3), -more / 2), np.full((S, S, 3), more / 2))


@pytest.fixture
def linear(head, head_template, rig, picture):  # noqa: F811
    own = painter(head, head_template, rig, picture)
    own.model = Linear()
    return own


@pytest.mark.parametrize("weights", [(0, 0), (1, 0), (0.5, 0.25), (1, 1)])
def test_a_change_that_is_linear_comes_back(linear, picture, weights):  # noqa: F811
    atlas = change_atlas(linear)
    direct = linear.paint(np.array(weights, float)).astype(int)
    mixed = paint_changes(atlas, picture, np.array(weights, float))
    # Tiles are coarser than the picture, and have 127 levels.
    assert np.abs(mixed - direct).mean() < 0.5 and np.quantile(np.abs(mixed - direct), 0.99) < 8


def test_it_is_no_larger_than_engines_take(linear):
    atlas = change_atlas(linear)
    assert (atlas.columns, atlas.side) == (3, S) and atlas.picture.shape == (4 * S, 4 * S, 3)
    linear.model.size = 4096
    assert max(change_atlas(linear).picture.shape) <= LARGEST


def test_beside_the_window_and_at_its_border_nothing_changes(linear, picture):  # noqa: F811
    atlas = change_atlas(linear)
    rim = atlas.picture[:S, :S].copy()
    rim[1:-1, 1:-1] = NOTHING
    assert np.abs(rim.astype(int) - NOTHING).max() <= 1 + 0.2 * np.abs(atlas.picture.astype(int) - NOTHING).max()
    left, top, right, bottom = (round(256 * share) for share in atlas.window)
    changed = (paint_changes(atlas, picture, np.ones(2)) != picture).any(-1)
    changed[top:bottom, left:right] = False
    assert not changed.any()
