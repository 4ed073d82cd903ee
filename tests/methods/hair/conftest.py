"""Heads in front of a plain wall, with hair and without."""

from dataclasses import dataclass

import numpy as np
import pytest

from caricli.methods.hair.make_shell import make_shell
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import ShellSettings
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera, Face
from caricli.template.template import Template

SIDE = 320
CAMERA = Camera(800.0, np.diag([1.0, -1.0, -1.0]), np.array([160.0, 270.0]))
WALL = (150, 170, 190)
SKIN = (220, 170, 140)
BROWN = (80, 50, 30)


@dataclass(frozen=True)
class Sitter:
    """A head, its picture with hair, the same bald, and which pixels hair and background are."""

    head: Template
    face: Face
    image: np.ndarray
    bald: np.ndarray
    hair: HairMask


@pytest.fixture(scope="session")
def sitter(head, head_template):
    """A Sitter whose hair is an ellipse around the skull, in front of which is the face."""
    shape = head_template.with_vertices(head.evaluate(gender=0.3, age=0.6))
    marks = CAMERA.project(shape.vertices[shape.annotation.landmarks[:68]])
    shown = rasterise(CAMERA.place(shape.vertices), shape.faces, SIDE, SIDE).face >= 0
    rows, columns = np.mgrid[:SIDE, :SIDE]
    brows = marks[17:27, 1].min() - 25
    middle = marks[27, 0]
    ellipse = ((columns - middle) / 82) ** 2 + ((rows - brows - 15) / 75) ** 2 < 1
    fringe = (np.abs(columns - middle) < 58) & (rows > brows)
    hair = ellipse & ~fringe & (rows < marks[29, 1])
    grain = np.random.default_rng(0).normal(0, 2.5, (SIDE, SIDE, 1))
    bald = np.where(shown[..., None], SKIN, WALL) + grain
    image = np.where(hair[..., None], BROWN, bald) + grain
    hairy, bare = (np.clip(each, 0, 255).astype(np.uint8) for each in (image, bald))
    mask = HairMask(hair, ~(hair | shown), 0.0, True)
    return Sitter(shape, Face(shape, CAMERA, marks), hairy, bare, mask)


@pytest.fixture(scope="session")
def shell(sitter):
    """One that ends where the picture says so, at its sides, too."""
    return make_shell(sitter.head, CAMERA, sitter.hair, ShellSettings(aside=0.0))[0]
