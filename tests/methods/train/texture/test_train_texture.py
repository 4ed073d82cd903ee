import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.config import read_config
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.shape_maps import CHANNELS, PersonShapes, pair_attention, pair_maps
from caricli.methods.dynamic.styles import StyleBook
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.texture.texture_pairs import BRIGHT, UNSEEN, TexturePairs, mirrored, painted_people
from caricli.methods.train.texture.train_texture import TextureTraining
from caricli.models.texture.config import TextureConfig
from caricli.models.texture.networks import OPEN
from caricli.seeds import LookSeed
from caricli.structures.arkit import ARKIT_NAMES
from caricli.template.chart import face_chart
from tests.acted_textures import acted_people


@pytest.fixture(scope="module")
def people(head):
    return acted_people(head)


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), 32)


def config(*overrides):
    return read_config(config_path("texture/tiny.yaml"), TextureConfig, overrides)


@pytest.fixture(scope="module")
def pairs(people, grid):
    def of(split):
        return TexturePairs(painted_people([p for p in people if p.split == split], grid, config()), grid, config())

    return of("train"), of("validation")


def begin(pairs, *overrides, share=ALL):
    training, unseen = pairs
    return TextureTraining(training, unseen, config(*overrides), share)


def test_pairs_are_of_one_person_in_one_look_and_light(pairs, people):
    batch = pairs[0].draw(40, np.random.default_rng(0), paired=True)
    for row, number in enumerate(batch.people.tolist()):
        person = people[number]
        pictures = person.pictures / 255
        bright = None
        for picture, code in ((batch.source, batch.source_code), (batch.target, batch.target_code)):
            (shown,) = np.flatnonzero((person.weights == code[row].numpy()).all(1))
            own = pictures[shown].transpose(2, 0, 1)
            factor = np.median(picture[row].numpy()[own > 0] / own[own > 0])
            assert BRIGHT[0] - 0.05 < factor < BRIGHT[1] + 0.05
            shares = picture[row].numpy().max((1, 2)) / own.max((1, 2))
            bright = shares if bright is None else bright
        assert not torch.equal(batch.source_code[row], batch.target_code[row])


def test_maps_and_attention_are_those_of_the_shapes(pairs, people, grid):
    batch = pairs[0].draw(6, np.random.default_rng(1), paired=True)
    for row, number in enumerate(batch.people.tolist()):
        person = people[number]
        shown = [
            int(np.flatnonzero((person.weights == code[row].numpy()).all(1))[0])
            for code in (batch.source_code, batch.target_code)
        ]
        own = PersonShapes(grid, person.neutral)
        source, target = (own.fields(person.vertices[each]) for each in shown)
        forth = pair_maps(grid, source, target).transpose(2, 0, 1)
        back = pair_maps(grid, target, source).transpose(2, 0, 1)
        skin = slice(0, CHANNELS.index("source_teeth"))
        np.testing.assert_allclose(batch.forth[row, skin], forth[skin], atol=1e-5)
        np.testing.assert_allclose(batch.back[row, skin], back[skin], atol=1e-5)
        assert np.ptp(batch.forth[row, CHANNELS.index("target_depth")].numpy()) > 0.01
        moved = pair_attention(grid, source, target)
        np.testing.assert_allclose(batch.moved[row, 0], OPEN + (1 - OPEN) * moved, atol=1e-5)


def test_a_mirror_shows_the_mirrored_expression(people, grid, head):
    def pair(name):
        neutral = head.evaluate()
        shape = head.evaluate(actions={name: 1.0})
        weights = np.zeros((2, 52), np.float32)
        weights[1, ARKIT_NAMES.index(name)] = 1
        one = replace(people[0], weights=weights, vertices=np.stack([neutral, shape]), pictures=people[0].pictures[:2])
        own = TexturePairs(painted_people([replace(one, seen=one.seen[:2])], grid, config()), grid, config())
        batch = own.draw(8, np.random.default_rng(0), paired=True)
        return batch.rows(batch.target_code.any(1))

    left = pair("mouthSmileLeft")
    right = pair("mouthSmileRight")
    seen = mirrored(left, torch.ones(len(left.people), dtype=torch.bool))
    torch.testing.assert_close(seen.target_code, right.target_code)
    np.testing.assert_allclose(seen.moved, right.moved, atol=0.06)
    assert (seen.forth - right.forth).abs().mean() < 0.5 * (left.forth - right.forth).abs().mean()
    same = mirrored(left, torch.zeros(len(left.people), dtype=torch.bool))
    torch.testing.assert_close(same.forth, left.forth)


def test_without_pairs_targets_are_anybodys(pairs):
    batch = pairs[0].draw(200, np.random.default_rng(2), paired=False)
    colours = [picture[:, :, 16, 4] for picture in (batch.source, batch.target)]
    away = (colours[0] / colours[0].sum(1, keepdim=True) - colours[1] / colours[1].sum(1, keepdim=True)).abs().sum(1)
    assert 0.4 < (away > 0.02).float().mean() < 0.95
    assert not batch.paired


def test_one_drawing_alone_makes_no_pairs(people, grid):
    alone = TexturePairs(painted_people(people[:1], grid, config()), grid, config())
    assert not alone.draw(4, np.random.default_rng(0), paired=False).paired
    assert alone.draw(4, np.random.default_rng(0), paired=True).paired


def test_texels_count_by_what_they_are(pairs, grid, people):
    batch = pairs[0].draw(3, np.random.default_rng(0), paired=True)
    weight = batch.weight[0, 0].numpy()
    skin = weight[grid.covered & ~grid.mouth]
    assert (weight[~grid.covered] == 0).all() and weight.mean() == pytest.approx(1, rel=1e-5)
    np.testing.assert_allclose(weight[grid.mouth], config().mouth * skin[0], rtol=1e-5)
    half = [copy.copy(person) for person in people[:1]]
    seen = half[0].seen.copy()
    seen[:, :, :16] = False
    object.__setattr__(half[0], "seen", seen)
    own = TexturePairs(painted_people(half, grid, config()), grid, config()).draw(2, np.random.default_rng(0), True)
    row = own.weight[0, 0, 12].numpy()
    assert row[6] == pytest.approx(UNSEEN * row[25], rel=1e-5) and row[6] > 0


def test_looks_go_over_all_expressions(people, grid):
    painted = painted_people(people[:2], grid, config("looks=2"), StyleBook())
    assert painted.pictures.shape == (2, 3, 4, 32, 32, 3)
    np.testing.assert_array_equal(painted.pictures[0, 0], people[0].pictures)
    again = painted_people(people[:2], grid, config("looks=2"), StyleBook())
    np.testing.assert_array_equal(painted.pictures, again.pictures)
    assert (painted.pictures[:, 1:] != painted.pictures[:, :1]).mean() > 0.5


def test_looks_are_of_somebody_and_a_use_wherever_one_stands(people, grid):
    def looks(rows, stream):
        some = [people[row] for row in rows]
        return painted_people(some, grid, config("looks=2"), StyleBook(), (0, stream)).pictures[:, 1:]

    own = looks([0, 1], LookSeed.TRAINING)
    np.testing.assert_array_equal(looks([1, 0], LookSeed.TRAINING), own[::-1])
    assert (looks([0, 1], LookSeed.EVALUATION) != own).mean() > 0.5


def test_nobody_and_textures_that_are_too_small_are_refused(people, head_template):
    grid = ChartGrid(face_chart(head_template), 64)
    with pytest.raises(InputError, match="people with textures"):
        painted_people([], grid, config())
    with pytest.raises(InputError, match="at least 64 texels, found 32"):
        painted_people(people[:1], grid, config())


def test_it_learns_what_expressions_do(pairs):
    training = begin(pairs, "epochs=6", "steps=10", "unpaired=0", "judge_every=10")
    records = list(training.epochs())
    assert records[-1].validation_error < 0.6 < records[0].train_error
    batch = pairs[1].draw(12, np.random.default_rng(3), paired=True)
    with torch.no_grad():
        attention = batch.change(training.average).attention
    together = np.corrcoef(attention.numpy().ravel(), batch.moved.numpy().ravel())[0, 1]
    assert together > 0.8


def test_left_after_any_epoch_it_goes_on_to_the_same_bytes(pairs):
    whole = begin(pairs)
    records = list(whole.epochs())
    training = begin(pairs)
    stopped = [next(training.epochs())]
    for _ in range(3):
        state = copy.deepcopy(training.state())
        training = begin(pairs)
        training.load_state(state)
        stopped.append(next(training.epochs()))
    assert stopped == records and training.ended
    for name in ("network", "average", "critic"):
        own = training.state()[name]
        for key, value in whole.state()[name].items():
            assert torch.equal(own[key], value)


def test_the_critic_and_the_cycle_take_their_part(pairs):
    training = begin(pairs, "epochs=2", "steps=2", "judge_every=1")
    before = copy.deepcopy(training.critic.state_dict())
    list(training.epochs())
    after = training.critic.state_dict()
    # What is added to every score alike makes no difference.
    assert [name for name in before if torch.equal(before[name], after[name])] == ["patch.bias"]
    assert all(parameter.requires_grad for parameter in training.critic.parameters())


def test_the_state_of_another_training_is_refused(pairs):
    state = begin(pairs).state()
    with pytest.raises(InputError, match="critic"):
        begin(pairs, "critic_width=8").load_state(state)


def test_processes_share_the_pairs_of_a_batch(pairs):
    whole = begin(pairs)._draw(0)
    parts = [begin(pairs, share=Share(process, 2))._draw(0) for process in (0, 1)]
    for process, part in enumerate(parts):
        np.testing.assert_array_equal(part.source, whole.source[process::2])
        np.testing.assert_array_equal(part.people, whole.people[process::2])
