from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.mouth_parts import MouthParts
from caricli.methods.dynamic.own_manner import MannerReader
from caricli.methods.dynamic.shape_maps import PersonShapes, pair_maps
from caricli.models.texture.config import TextureConfig, TextureSize
from caricli.models.texture.model import TextureModel, texture_from_checkpoint, texture_to_checkpoint
from caricli.models.texture.networks import ATLAS, CODES, MAPS, ActionAtlas, Change, TextureNetwork
from caricli.store.texture_networks import load_texture_network
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.texture_change import Manner
from caricli.template.chart import face_chart

SIDE = 32
STILL = Manner(np.ones(3), np.zeros((SIDE, SIDE)), np.zeros((SIDE, SIDE)), 1.0)


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
    """A texture, maps, codes of source and target, and a manner that leaves the change as it is."""
    generator = np.random.default_rng(0)
    codes = generator.random((2, CODES // 2))
    return (
        generator.integers(0, 256, (SIDE, SIDE, 3), np.uint8),
        generator.normal(size=(SIDE, SIDE, MAPS)),
        *codes,
        STILL,
    )


@pytest.mark.parametrize(
    ("epochs", "unpaired", "paired"),
    [(80, 0.05, 76), (10, 0.05, 9), (100, 0.07, 93), (4, 0.5, 2), (2, 0.9, 1), (1, 0.05, 1), (4, 0, 4), (4, 1, 0)],
)
def test_however_few_epochs_there_are_some_are_unpaired(epochs, unpaired, paired):
    assert TextureConfig(epochs=epochs, unpaired=unpaired).paired_epochs == paired


def test_a_checkpoint_rebuilds_it(model, asked):
    again = texture_from_checkpoint(*texture_to_checkpoint(model), "it")
    assert (again.size, again.topology_id, again.recipe) == (SIDE, "0" * 64, {"seed": 0})
    own = model.change(*asked)
    other = again.change(*asked)
    np.testing.assert_allclose(other.gain, own.gain, atol=0.05)
    np.testing.assert_allclose(other.paint(asked[0]).astype(int), own.paint(asked[0]).astype(int), atol=12)


def test_a_change_paints_as_equation_12(model, asked):
    picture, maps, source, target, _ = asked
    codes = torch.from_numpy(np.concatenate([source, target]).astype(np.float32))[None]
    colours = torch.from_numpy(picture / np.float32(255)).permute(2, 0, 1)[None]
    change = model.network(colours, torch.from_numpy(maps.astype(np.float32)).permute(2, 0, 1)[None], codes)
    keep = 1 - change.attention  # the paper's A
    painted = keep * colours + (1 - keep) * (colours + change.gain * colours + change.offset)
    expected = 255 * painted[0].permute(1, 2, 0).clamp(0, 1).numpy()
    np.testing.assert_allclose(model.change(*asked).paint(picture), expected, atol=0.51)


def test_paint_keeps_its_hue_and_becomes_as_light():
    """The same order of channels, and a grey stays grey, whatever colours the change had."""
    generator = torch.Generator().manual_seed(0)
    pictures = torch.full((1, 3, SIDE, SIDE), 0.6)
    pictures[0, :, : SIDE // 2] = torch.tensor([0.75, 0.6, 0.45]).view(3, 1, 1)
    gain, offset = (0.4 * torch.rand((1, 3, SIDE, SIDE), generator=generator) - 0.2 for _ in range(2))
    free = Change(torch.full((1, 1, SIDE, SIDE), 0.5), gain, offset)
    glazed = free.in_own_shades(pictures, torch.ones(1, 3), torch.ones(SIDE, SIDE)).paint(pictures)
    luminance = torch.tensor([0.2126, 0.7152, 0.0722]).view(1, 3, 1, 1)
    torch.testing.assert_close((luminance * glazed).sum(1), (luminance * free.paint(pictures)).sum(1))
    warm, grey = glazed[0].split(SIDE // 2, dim=1)
    assert (warm.diff(dim=0) < 0).all()
    assert (grey - grey.mean(0)).abs().max() < 1e-4
    same = free.in_own_shades(pictures, torch.ones(1, 3), torch.zeros(SIDE, SIDE)).paint(pictures)
    torch.testing.assert_close(same, free.paint(pictures))


def test_darker_paint_has_the_hue_of_the_pictures_shades():
    """Where shades lose red slower than green, what becomes darker becomes redder, and what becomes lighter less so."""
    pictures = torch.full((1, 3, SIDE, SIDE), 0.5)
    shades = torch.tensor([[0.5, 1.2, 1.2]])
    for gain, redder in ((-0.4, True), (0.4, False)):
        change = Change(torch.ones(1, 1, SIDE, SIDE), torch.full_like(pictures, gain), torch.zeros_like(pictures))
        red, green, blue = change.in_own_shades(pictures, shades, torch.ones(SIDE, SIDE)).paint(pictures)[0]
        assert ((red > green) == redder).all()
        torch.testing.assert_close(green, blue)


def test_folds_are_no_deeper_than_is_asked():
    """A dark line becomes as deep as the bound, a faint one stays; beside skin, and what is lighter, stays too."""
    pictures = torch.full((1, 3, SIDE, SIDE), 0.5)
    gain = torch.zeros_like(pictures)
    gain[..., 8] = -0.5
    gain[..., 16] = -0.01
    gain[..., 24] = 0.5
    change = Change(torch.ones(1, 1, SIDE, SIDE), gain, torch.zeros_like(pictures))
    skin = torch.ones(SIDE, SIDE)
    skin[: SIDE // 2] = 0
    shallow = change.with_folds_up_to(pictures, torch.tensor([0.1]), torch.ones(1, 3), skin).paint(pictures)[0, 0]
    free = change.paint(pictures)[0, 0]
    torch.testing.assert_close(shallow[: SIDE // 2], free[: SIDE // 2])
    depth = (0.5 / shallow[-SIDE // 4]).log()
    assert 0.08 < depth[8] < 0.3 and free[0, 8] == 0.25
    torch.testing.assert_close(shallow[:, 16:], free[:, 16:], atol=2e-3, rtol=0)


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
        (lambda t, a: a.update(topology_id="0" * 63), "the id of a topology"),
        (lambda t, a: a.update(size=7), "size from 32 to 512"),
        (lambda t, a: a.update(size=100), "a size that is a multiple of 32, found 100"),
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


def test_the_bundled_one_opens_a_mouth(head, head_template):
    """On a face of one colour that opens its mouth, darkness comes between the lips, and the forehead keeps still."""
    model = load_texture_network()
    grid = ChartGrid(face_chart(head_template), model.size)
    shape = head.evaluate(actions={"jawOpen": 0.9})
    mouth = MouthParts.in_face(head_template, shape[None] - head_template.vertices)
    person = PersonShapes(grid, head_template.vertices, mouth)
    rest = person.fields(head_template.vertices)
    opened = person.fields(shape, np.ones(1))
    codes = np.zeros((2, CODES // 2), np.float32)
    codes[1, ARKIT_NAMES.index("jawOpen")] = 0.9
    skin = np.full((model.size, model.size, 3), (200, 150, 130), np.uint8)
    manner = MannerReader(grid, head_template).read(skin)
    change = model.change(skin, pair_maps(grid, rest, opened), codes[0], codes[1], manner)
    painted = skin / 255 + change.gain * skin / 255 + change.offset
    darker = (skin / 255 - painted).mean(-1)
    forehead = grid.covered & (np.arange(model.size)[:, None] < 0.3 * model.size)
    assert darker[grid.mouth].mean() > 0.1
    assert np.abs(darker[forehead]).mean() < 0.02


def test_a_grey_picture_stays_grey(model, asked):
    picture, *others, manner = asked
    grey = picture[..., :1].repeat(3, 2)
    free, toned = (model.change(grey, *others, replace(manner, coloured=share)) for share in (1.0, 0.0))
    assert np.ptp(free.paint(grey).astype(int), axis=2).max() > 5
    assert np.ptp(toned.paint(grey).astype(int), axis=2).max() <= 1
    np.testing.assert_allclose(toned.gain.mean(2), free.gain.mean(2), atol=1e-6)
