import json

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.models.style.config import STEP
from caricli.models.style.model import StyleModel, style_from_checkpoint, style_to_checkpoint
from caricli.models.style.networks import StyleNetwork, renormalised, statistics


@pytest.fixture(scope="module")
def model():
    network = StyleNetwork(4, 3, torch.Generator().manual_seed(0))
    torch.nn.init.normal_(network.decoder.last.weight, std=0.1, generator=torch.Generator().manual_seed(1))
    return StyleModel(network, ("oil", "ink", "pencil"), {"seed": 0})


@pytest.fixture(scope="module")
def pictures():
    return np.random.default_rng(0).integers(0, 256, (3, 48, 40, 3), np.uint8)


def test_features_are_renormalised_as_by_hand():
    generator = torch.Generator().manual_seed(0)
    content, style = torch.rand(2, 3, 5, 7, generator=generator), 4 * torch.rand(2, 3, 6, 4, generator=generator) + 1
    lent = renormalised(content, statistics(content), statistics(style)).numpy()
    for row in range(2):
        for channel in range(3):
            values, wanted = content[row, channel].numpy(), style[row, channel].numpy()
            slow = wanted.std() * (values - values.mean()) / values.std() + wanted.mean()
            np.testing.assert_allclose(lent[row, channel], slow, atol=1e-3)


def test_what_is_equal_in_two_pictures_of_a_person_stays_so(model, pictures):
    changed = np.repeat(pictures[:1], 2, 0)
    changed[1, 30:34, 18:24] = 255 - changed[1, 30:34, 18:24]
    lent = model.lend(changed, model.look(pictures[1]))
    np.testing.assert_array_equal(lent[0, :8], lent[1, :8])
    assert (lent[0, 30:34, 18:24] != lent[1, 30:34, 18:24]).any()


def test_strength_goes_from_the_picture_to_the_look(model, pictures):
    look = model.look(pictures[1])
    weak, half, full = (model.lend(pictures[:1], look, strength).astype(float) for strength in (0, 0.5, 1))
    np.testing.assert_array_equal(weak, model.lend(pictures[:1], model.look(pictures[2]), 0))
    assert np.abs(full - weak).mean() > np.abs(half - weak).mean() > 0


@pytest.mark.parametrize("size", [(1, 1), (7, 30), (33, 16)])
def test_pictures_of_any_size(model, size):
    pictures = np.zeros((2, *size, 3), np.uint8)
    assert model.lend(pictures, model.look(pictures[0])).shape == pictures.shape


def test_a_checkpoint_rebuilds_it(model, pictures):
    tensors, about = style_to_checkpoint(model)
    again = style_from_checkpoint(tensors, json.loads(json.dumps(about)), "it")
    assert again.media == model.media and again.recipe == {"seed": 0} and again.model_id == model.model_id
    lent = [one.lend(pictures, one.look(pictures[1])).astype(int) for one in (model, again)]
    assert np.abs(lent[0] - lent[1]).max() <= 3


@pytest.mark.parametrize(
    "change",
    [{"schema": "caricli.model/1"}, {"width": 3}, {"width": "4"}, {"media": "oil"}, {"media": []}, {"width": 8}],
)
def test_what_does_not_fit_is_refused(model, change):
    tensors, about = style_to_checkpoint(model)
    with pytest.raises(InputError, match="^it: "):
        style_from_checkpoint(tensors, json.loads(json.dumps(about)) | change, "it")


def test_a_picture_with_its_own_look_stays_as_it_is(model, pictures):
    own = model.look(pictures[0])
    same, plain = (model.lend(pictures[:1], own, strength).astype(int) for strength in (1, 0))
    assert np.abs(same - plain).max() <= 1


def test_people_in_another_order_look_the_same(model, pictures):
    look = model.look(pictures[2])
    lent, turned = (model.lend(each, look).astype(int) for each in (pictures, pictures[::-1]))
    assert np.abs(lent - turned[::-1]).max() <= 1


def test_what_is_added_to_make_sizes_even_is_cut_off_again(model, pictures):
    part = pictures[:, :33, :30]
    wide = np.pad(part, ((0, 0), (0, -33 % STEP), (0, -30 % STEP), (0, 0)), mode="edge")
    look = model.look(pictures[0])
    assert wide.shape != part.shape
    np.testing.assert_array_equal(model.lend(part, look), model.lend(wide, look)[:, :33, :30])


def test_the_noise_is_that_of_the_seed(model, pictures):
    look = model.look(pictures[1])
    first, same, other = (model.lend(pictures[:1], look, seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, same)
    assert (first != other).any()


def test_smooth_skin_becomes_no_blotches(model, pictures, monkeypatch):
    smooth = (120 + np.random.default_rng(1).integers(0, 2, (1, 48, 40, 3))).astype(np.uint8)
    look = model.look(pictures[1])
    seen = []

    def decoder(lent, noise):
        seen.append([level.std((2, 3)) for level in lent])
        return torch.zeros(1, 3, *noise.shape[2:])

    monkeypatch.setattr(model.network.decoder, "forward", decoder)
    for strength in (0, 1):
        model.lend(smooth, look, strength)
    for plain, lent in zip(*seen, strict=True):
        assert (lent <= 2.6 * plain + 1e-6).all() and (lent > 1.5 * plain).any()
