from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from caricli.methods.dynamic.media import NAMES, Medium
from caricli.methods.dynamic.styles import LentLook, Style, StyleBook, drawn_faces
from caricli.models.style.model import StyleModel
from caricli.models.style.networks import StyleNetwork


@pytest.fixture(scope="module")
def model():
    return StyleModel(StyleNetwork(4, len(NAMES), torch.Generator().manual_seed(0)), NAMES)


@pytest.fixture(scope="module")
def drawings():
    return [np.random.default_rng(seed).integers(0, 256, (80, 60 + seed, 3), np.uint8) for seed in range(3)]


def test_without_a_network_styles_are_media():
    generator = np.random.default_rng(0)
    assert {StyleBook().draw(generator).name for _ in range(200)} == set(NAMES)


def test_looks_of_drawings_are_among_the_styles(model, drawings):
    generator = np.random.default_rng(0)
    names = [StyleBook(model, drawings).draw(generator).name for _ in range(60)]
    assert 10 < names.count("drawing") < 40


def test_two_of_five_styles_are_lent_and_none_of_them_weakly(drawings):
    generator = np.random.default_rng(0)
    lender: Any = SimpleNamespace(look=lambda part: part)
    ways = [StyleBook(lender, drawings).draw(generator).way for _ in range(400)]
    lent = [way for way in ways if isinstance(way, LentLook)]
    assert 120 < len(lent) < 200
    assert 0.6 <= min(way.strength for way in lent) < 0.65 and max(way.strength for way in lent) > 0.95


def test_strokes_of_all_expressions_go_the_ways_of_their_mean(monkeypatch):
    guides = []

    def paint(medium, picture, guide):
        guides.append(guide)
        return picture

    monkeypatch.setattr(Medium, "paint", paint)
    Style(Medium("oil", 2.0, 0)).paint(np.stack([np.full((8, 8, 3), shade, np.uint8) for shade in (40, 100)]))
    assert len(guides) == 2 and all((guide == 70).all() for guide in guides)


def test_a_style_is_the_same_for_all_expressions_and_the_same_again(model, drawings):
    faces = np.random.default_rng(1).integers(0, 256, (2, 1, 64, 64, 3), np.uint8)
    for seed in range(4):
        style, again = (StyleBook(model, drawings).draw(np.random.default_rng(seed)) for _ in range(2))
        both = np.repeat(faces[0], 2, 0)
        painted = style.paint(both)
        assert painted.shape == both.shape and painted.dtype == np.uint8
        np.testing.assert_array_equal(painted[0], painted[1])
        np.testing.assert_array_equal(painted, again.paint(both))
        assert style.paint(faces[:, 0]).shape == (2, 64, 64, 3) and style.paint(faces[0, 0]).shape == (64, 64, 3)


def test_generated_drawings_are_faces_in_media(head_template):
    pictures = drawn_faces(head_template, 3, 5)
    assert [picture.shape for picture in pictures] == [(128, 128, 3)] * 3
    np.testing.assert_array_equal(pictures[0], drawn_faces(head_template, 1, 5)[0])
    assert (pictures[0] != pictures[1]).any()
