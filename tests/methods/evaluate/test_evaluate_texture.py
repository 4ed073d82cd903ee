from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from caricli.methods.evaluate.evaluate_texture import (
    KEPT,
    SOURCE_GAP,
    TARGET_GAP,
    TextureChoice,
    TextureTally,
    evaluate_texture,
    regions,
)
from caricli.methods.train.texture.texture_losses import TextureBatch

SIDE = 5
MOUTH = np.arange(SIDE * SIDE).reshape(SIDE, SIDE) >= 20


@pytest.fixture
def batch():
    """Four people whose lowest row is between the lips; of the other twenty texels the later ones move more."""
    moved = torch.arange(25.0).view(1, 1, SIDE, SIDE).repeat(4, 1, 1, 1)
    maps, codes = torch.zeros(4, 23, SIDE, SIDE), torch.zeros(4, 52)
    picture = torch.full((4, 3, SIDE, SIDE), 0.5)
    seen = torch.ones(4, 1, SIDE, SIDE, dtype=torch.bool)
    return TextureBatch(
        picture, picture + 0.1, maps, maps, codes, codes + 1, moved, moved, seen, torch.tensor([0, 0, 1, 1]), True
    )


def test_mouths_are_those_that_are_open_and_seen_and_some_of_them_were_closed(batch):
    for row, (was, now) in enumerate(((0, 0.3), (0.3, 0.3), (0.3, 0), (0, 0))):
        batch.forth[row, SOURCE_GAP, 4, 2] = was
        batch.forth[row, TARGET_GAP, 4, 2] = now
    # Gaps on the skin are none.
    batch.forth[3, [SOURCE_GAP, TARGET_GAP], 0] = 0.9
    batch.seen[:, 0, 4, 0] = False
    masks = regions(batch, torch.from_numpy(MOUTH))
    assert masks["mouth"].sum((1, 2)).tolist() == [4, 4, 0, 0]
    assert masks["opens"].sum((1, 2)).tolist() == [4, 0, 0, 0]


def test_attention_is_due_to_the_skin_that_is_seen_and_moves_most(batch):
    batch.seen[1, 0, 3] = False
    masks = regions(batch, torch.from_numpy(MOUTH))
    assert torch.nonzero(masks["attention"][0].flatten())[:, 0].tolist() == [14, 15, 16, 17, 18, 19]
    assert torch.nonzero(masks["attention"][1].flatten())[:, 0].tolist() == [11, 12, 13, 14]
    assert masks["outside"].sum((1, 2)).tolist() == [14, 11, 14, 14]


def test_errors_are_means_of_texels_and_percentages_of_those_of_the_kept_texture(batch):
    """Of the second person half of the skin is seen, and three times as far off."""
    target = batch.target.clone()
    target[2:] += 0.2
    seen = batch.seen.clone()
    seen[2:, 0, :2] = False
    batch = replace(batch, target=target, seen=seen)
    pictures = {KEPT: batch.source, "half": batch.source + 0.05}
    tally = TextureTally(np.arange(2))
    tally.add(batch, MOUTH, pictures)
    figures = tally.figures()
    kept = (2 * 14 * 0.1 + 2 * 7 * 0.3) / 42
    assert figures[KEPT]["outside"] == pytest.approx({"error": kept, "percent": 100, "low": 100, "high": 100})
    half = figures["half"]["outside"]
    assert half["error"] == pytest.approx((2 * 14 * 0.05 + 2 * 7 * 0.25) / 42)
    assert half["percent"] == pytest.approx(100 * half["error"] / kept)
    assert (half["low"], half["high"]) == pytest.approx((50, 250 / 3))


def test_what_no_face_shows_is_not_measured(batch):
    """All mouths are closed."""
    tally = TextureTally(np.arange(2))
    tally.add(batch, MOUTH, {KEPT: batch.source})
    own = tally.figures()[KEPT]
    assert own["mouth"] == own["opens"] == {"error": None, "percent": None, "low": None, "high": None}
    assert own["outside"]["percent"] == 100


def test_faces_of_one_person_are_drawn_together(batch):
    """Both are of one person, so that draws of the people are all alike."""
    target = batch.target.clone()
    target[2:] += 0.2
    tally = TextureTally(np.array([7, 7]))
    tally.add(replace(batch, target=target), MOUTH, {KEPT: batch.source, "half": batch.source + 0.05})
    half = tally.figures()["half"]["outside"]
    assert tally.people == 1 and (half["low"], half["high"]) == pytest.approx((half["percent"],) * 2)


def test_expressions_are_read_against_those_that_were_to_be_painted(batch):
    tally = TextureTally(np.arange(2))
    tally.judge(batch, lambda given, pictures: given.source_code + pictures[:, :1, 0, 0] - 0.5, {KEPT: batch.source})
    assert tally.reading == pytest.approx({KEPT: 1, "true": 0.9})


def test_all_painters_paint_as_many_pairs_as_are_asked_for_of_a_seed(batch):
    asked = []

    def draw(count, generator, paired):
        asked.append((count, paired, generator.random()))
        return batch.rows(torch.arange(count) % 4)

    people = SimpleNamespace(numbers=np.arange(2))
    pairs: Any = SimpleNamespace(people=people, grid=SimpleNamespace(mouth=MOUTH), draw=draw)
    tally = evaluate_texture(
        {"own": lambda b: b.target}, lambda b, pictures: b.target_code, pairs, TextureChoice(37, seed=5)
    )
    assert [count for count, *_ in asked] == [16, 16, 5] and all(paired for _, paired, _ in asked)
    assert asked[0][2] == np.random.default_rng(5).random()
    assert len(tally.read["own"]) == 37 and tally.figures()["own"]["outside"]["percent"] == 0


def test_whom_nothing_was_painted_of_counts_as_nobody(batch):
    """Of four rows the last two, of the second person, are in no pair."""
    tally = TextureTally(np.array([0, 1, 2, 2]))
    first = replace(batch, people=torch.tensor([0, 0, 1, 1]))
    tally.add(first, MOUTH, {KEPT: batch.source})
    assert tally.people == 2
    for region in ("attention", "outside"):
        figure = tally.figures()[KEPT][region]
        assert figure["percent"] == figure["low"] == figure["high"] == pytest.approx(100)
