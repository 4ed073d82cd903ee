from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.shape_maps import CHANNELS, PART
from caricli.methods.evaluate.evaluate_texture import KEPT, TextureChoice, evaluate_texture, regions
from caricli.methods.evaluate.texture_flicker import FRAMES, flicker, takes_of
from caricli.methods.evaluate.texture_rivals import linear_painter, spline_painter, train_reader
from caricli.methods.train.texture.texture_pairs import TexturePairs, painted_people
from caricli.models.texture.config import TextureConfig
from caricli.template.chart import face_chart
from tests.acted_textures import acted_people

CONFIG = TextureConfig(size=32, looks=0, mirrored=0, plain=1)
ACROSS = CHANNELS.index("displacement_x")


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), 32)


@pytest.fixture(scope="module")
def people(head):
    return acted_people(head)


@pytest.fixture(scope="module")
def pairs(people, grid):
    def of(split):
        return TexturePairs(painted_people([p for p in people if p.split == split], grid, CONFIG), grid, CONFIG)

    return of("train"), of("test")


@pytest.fixture(scope="module")
def batch(pairs):
    return pairs[1].draw(6, np.random.default_rng(0), paired=True)


def moved(batch, across):
    """The same with other displacements to the right, (S, S) quarters of the face's width."""
    forth = batch.forth.clone()
    forth[:, ACROSS : ACROSS + 3] = 0
    forth[:, ACROSS] = across
    return replace(batch, forth=forth)


def test_a_spline_keeps_what_moves_as_a_whole(batch, grid, head_template):
    paint = spline_painter(grid, head_template.annotation.landmarks)
    ramp = torch.linspace(0, 0.3, grid.size)
    shown = paint(moved(batch, ramp))
    away = (shown - batch.source).abs()[:, :, grid.covered]
    assert away.max() < 0.02


def test_a_spline_slides_what_moves_by_itself(batch, grid, head_template):
    """A cheek without landmarks that goes right by a tenth of the face takes the paint from its right."""
    paint = spline_painter(grid, head_template.annotation.landmarks)
    row, column = 20, 7
    across = torch.zeros(grid.size, grid.size)
    across[row, column] = 0.1 / PART
    texels = 0.1 * np.ptp(grid.chart.uvs[:, 0]) * grid.size
    ramp = torch.linspace(0, 1, grid.size).expand_as(batch.source)
    shown = paint(moved(replace(batch, source=ramp.contiguous()), across))
    slid = (shown[0, 0, row, column] - ramp[0, 0, row, column]) * (grid.size - 1)
    assert float(slid) == pytest.approx(texels, abs=0.05)
    still = torch.ones(grid.size, grid.size, dtype=torch.bool)
    still[row, column] = False
    assert (shown - ramp).abs()[..., still].max() < 1e-4


def test_what_is_linear_is_learnt_by_what_is_linear(pairs):
    painters = {"linear": linear_painter(pairs[0], 0)}
    tally = evaluate_texture(painters, train_reader(pairs[0], 0, steps=120), pairs[1], TextureChoice(48))
    figures = tally.figures()
    assert figures["linear"]["mouth"]["percent"] < 60
    for table in (figures[KEPT], figures["linear"]):
        for figure in table.values():
            assert figure["low"] <= figure["percent"] + 1e-6 <= figure["high"] + 2e-6
    assert figures[KEPT]["attention"]["percent"] == pytest.approx(100)
    assert set(tally.reading) == {KEPT, "linear", "true"}
    assert tally.reading["true"] < tally.reading[KEPT]


def test_regions_do_not_overlap_and_count_what_was_seen(batch, grid):
    masks = regions(batch, torch.from_numpy(grid.mouth))
    together = masks["attention"].int() + masks["outside"].int() + masks["mouth"].int()
    assert together.max() == 1
    assert not (masks["opens"] & ~masks["mouth"]).any()
    assert not (together.bool() & ~batch.seen[:, 0]).any()
    share = masks["attention"].sum() / (masks["attention"] | masks["outside"]).sum()
    assert 0.2 < float(share) <= 0.31
    for mask, least in ((masks["attention"], True), (masks["outside"], False)):
        row = 0
        moves = batch.moved[row, 0][mask[row]]
        other = batch.moved[row, 0][(masks["outside"] if least else masks["attention"])[row]]
        assert bool(moves.min() >= other.max()) if least else bool(moves.max() <= other.min())


def test_flicker_is_nothing_for_what_goes_straight_and_much_for_chance(pairs, people, grid):
    takes = takes_of([person for person in people if person.split == "test"], grid)
    assert [len(take.source) for take in takes] == [FRAMES, FRAMES]
    np.testing.assert_allclose(takes[0].target_code[-1], people[-2].weights[1], atol=1e-6)
    np.testing.assert_allclose(takes[0].source.var(0), 0, atol=1e-12)

    def straight(batch):
        return 0.5 + batch.target_code[:, :1, None, None] * batch.source

    generator = torch.Generator().manual_seed(0)

    def chance(batch):
        return torch.rand(batch.source.shape, generator=generator)

    assert flicker(lambda batch: batch.source + batch.forth[:, :3], takes) < 15
    assert flicker(chance, takes) == pytest.approx(173, rel=0.2)
    linear = linear_painter(pairs[0], 0)
    assert flicker(linear, takes) < 1
