import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.texture.config import TextureConfig, TextureSize
from caricli.models.texture.model import TextureModel, texture_from_checkpoint, texture_to_checkpoint
from caricli.models.texture.networks import ATLAS, CODES, MAPS, ActionAtlas, TextureNetwork

SIDE = 32


@pytest.fixture(scope="module")
def model():
    """One with random weights, also those that a training begins with as zeros."""
    generator = torch.Generator().manual_seed(0)
    network = TextureNetwork(TextureSize(8, 4), generator)
    for parameter in network.parameters():
        if not parameter.any():
            torch.nn.init.normal_(parameter, 0, 0.2, generator)
    return TextureModel(network, SIDE, "0" * 64, {"seed": 0})


@pytest.fixture
def asked():
    """A texture, maps, and codes of source and target."""
    generator = np.random.default_rng(0)
    codes = generator.random((2, CODES // 2))
    return generator.integers(0, 256, (SIDE, SIDE, 3), np.uint8), generator.normal(size=(SIDE, SIDE, MAPS)), *codes


def test_a_checkpoint_rebuilds_it(model, asked):
    again = texture_from_checkpoint(*texture_to_checkpoint(model), "it")
    assert (again.size, again.topology_id, again.recipe) == (SIDE, "0" * 64, {"seed": 0})
    own = model.change(*asked)
    other = again.change(*asked)
    np.testing.assert_allclose(other.attention, own.attention, atol=0.02)
    np.testing.assert_allclose(other.paint(asked[0]).astype(int), own.paint(asked[0]).astype(int), atol=12)


def test_a_change_paints_as_equation_12(model, asked):
    change = model.change(*asked)
    colours = asked[0] / 255
    keep = 1 - change.attention[..., None]  # the paper's A
    painted = keep * colours + (1 - keep) * (colours + change.gain * colours + change.offset)
    np.testing.assert_array_equal(change.paint(asked[0]), np.rint(255 * painted.clip(0, 1)).astype(np.uint8))
    assert change.attention.shape == (SIDE, SIDE) and change.gain.shape == change.offset.shape == (SIDE, SIDE, 3)


def test_the_default_is_small():
    network = TextureNetwork(TextureConfig().network(), torch.Generator())
    model = TextureModel(network, 96, "0" * 64)
    assert sum(value.nbytes for value in model.tensors().values()) < 2e6


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, a: a.update(schema="other"), "expected a texture network of schema"),
        (lambda t, a: a.update(expressions=["smile"]), "ARKit's 52 expressions, found one of others"),
        (lambda t, a: a.update(topology_id=3), "the id of a topology"),
        (lambda t, a: a.update(size=7), "size from 32 to 512"),
        (lambda t, a: a.update(network={"width": 8}), "expected a network of width"),
        (lambda t, a: a["network"].update(maps=1), "true or false"),
        (lambda t, a: a["network"].update(maps=False, codes=False), "maps or codes"),
        (lambda t, a: a["network"].update(width=16), "expected"),
        (lambda t, a: t.pop("colour.last.weight"), "found others"),
    ],
)
def test_other_files_are_refused(model, change, message):
    tensors, about = texture_to_checkpoint(model)
    change(tensors, about)
    with pytest.raises(InputError, match=message):
        texture_from_checkpoint(tensors, about, "it")


def test_impossible_settings_are_refused():
    with pytest.raises(ValueError, match="multiple of 32"):
        TextureConfig(size=100)
    with pytest.raises(ValueError, match="maps or codes"):
        TextureConfig(maps=False, codes=False)


def test_the_atlas_says_what_actions_do_where():
    atlas = ActionAtlas(2)
    assert not atlas.fields.any()
    with torch.no_grad():
        atlas.fields[5, 1, 10, 20] = 4.0
        codes = torch.zeros(3, CODES)
        codes[1, 5] = 0.5
        codes[2, CODES // 2 + 5] = 0.25
        drawn = atlas(codes, ATLAS)
    assert drawn.shape == (3, 4, ATLAS, ATLAS)
    assert drawn.nonzero().tolist() == [[1, 1, 10, 20], [2, 3, 10, 20]]
    assert drawn[1, 1, 10, 20] == 2 and drawn[2, 3, 10, 20] == 1
    smaller = atlas(codes, ATLAS // 2).detach()
    assert smaller.shape[-1] == ATLAS // 2 and smaller[1, 1].argmax() == 5 * ATLAS // 2 + 10
