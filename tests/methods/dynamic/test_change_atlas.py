import cv2
import numpy as np
import pytest

from caricli.methods.dynamic.change_atlas import LARGEST, _shown_weights, change_atlas
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


def tile(atlas, number):
    """Tile (S, S, 3) of an atlas, from -1 to 1."""
    row, column = divmod(number, atlas.columns)
    places = [slice(first * atlas.side, (first + 1) * atlas.side) for first in (row, column)]
    return (atlas.picture[tuple(places)].astype(np.float32) - NOTHING) / (255 - NOTHING)


def shaded(atlas, skin, weights):
    """A skin (H, H, 3) uint8 as a shader shows it that changes it by an atlas with weights (K,)."""
    size = len(skin)
    left, top, right, bottom = (round(share * size) for share in atlas.window)
    window = np.s_[top:bottom, left:right]
    colours = skin[window] / np.float32(255)
    change = np.zeros((2, atlas.side, atlas.side, 3))
    for number, weight in enumerate([1.0, *weights]):
        if weight:
            change += weight * np.stack(
                [atlas.gain * tile(atlas, 2 * number), atlas.offset * tile(atlas, 2 * number + 1)]
            )
    shape = colours.shape[1::-1]
    gain, offset = (cv2.resize(values, shape, interpolation=cv2.INTER_LINEAR) for values in change)
    painted = skin.copy()
    painted[window] = np.rint(255 * np.clip(colours + gain * colours + offset, 0, 1))
    return painted


@pytest.mark.parametrize("weights", [(0, 0), (1, 0), (0.5, 0.25), (1, 1)])
def test_a_change_that_is_linear_comes_back(linear, picture, weights):  # noqa: F811
    atlas = change_atlas(linear)
    direct = linear.paint(np.array(weights, float)).astype(int)
    mixed = shaded(atlas, picture, np.array(weights, float))
    # Tiles are coarser than the picture, and have 127 levels.
    assert np.abs(mixed - direct).mean() < 0.5 and np.quantile(np.abs(mixed - direct), 0.99) < 8


def test_actions_in_another_spelling_are_asked_for_alike():
    spelt = tuple(name[0].upper() + name[1:] for name in ARKIT_NAMES)
    np.testing.assert_array_equal(_shown_weights(spelt), _shown_weights(ARKIT_NAMES))
    assert len(_shown_weights(spelt)) > len(spelt) == len(_shown_weights(spelt[:-1])) + 1


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
    changed = (shaded(atlas, picture, np.ones(2)) != picture).any(-1)
    changed[top:bottom, left:right] = False
    assert not changed.any()
