"""A head before a coloured wall, whose picture is drawn again."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
import pytest

from caricli.methods.redraw.original import Original
from caricli.methods.rig.make_rig import make_rig
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera, Depiction, Material, Pictures, Rig
from caricli.structures.materials import FINISHES
from caricli.structures.parsing import Region
from caricli.template.template import Template
from tests.drawn_albedo import soft_skin
from tests.textured_pictures import render_textured

SIDE = 200
WALL = np.array([90.0, 140, 200])
CAMERA = Camera(700.0, np.diag([1.0, -1.0, -1.0]), np.array([100.0, 190.0]))


@dataclass(frozen=True)
class Stage:
    """A rig, and pictures of what it does. template: Template of its skin."""

    rig: Rig
    template: Template

    def shape(self, **weights):
        """(W, 3) vertices of expressions by name."""
        deltas = self.rig.deltas
        return self.rig.neutral + sum(w * deltas[self.rig.names.index(n)] for n, w in weights.items())

    def picture(self, vertices):
        """(SIDE, SIDE, 3) uint8 of the rig in a shape before the wall."""
        placed = CAMERA.place(vertices)
        image = render_textured(self.rig, placed, SIDE, SIDE, paper=WALL)
        face = rasterise(placed, self.rig.faces, SIDE, SIDE).face
        for material, finish in FINISHES.items():
            if self.rig.pictures.of(material) is None:
                image[(face >= 0) & (self.rig.triangle_materials[face] == material)] = finish.colour
        return image

    def mouth(self, vertices):
        """(SIDE, SIDE) bool: where a shape shows what is in its mouth, with a pixel around it."""
        face = rasterise(CAMERA.place(vertices), self.rig.faces, SIDE, SIDE).face
        inside = np.isin(self.rig.triangle_materials, (Material.TEETH, Material.GUMS, Material.TONGUE))
        wall = self.template.mask("inner_mouth")
        inside |= np.pad(wall, (0, len(self.rig.neutral) - len(wall)))[self.rig.faces].any(1)
        return cv2.dilate(((face >= 0) & inside[face]).astype(np.uint8), np.ones((3, 3))) > 0

    def regions(self, vertices):
        """(SIDE, SIDE) values of Region: skin, and background."""
        shown = rasterise(CAMERA.place(vertices), self.rig.faces, SIDE, SIDE).face >= 0
        return np.where(shown, Region.SKIN, Region.BACKGROUND).astype(np.uint8)

    def original(self, vertices, **others):
        """The Original of a shape."""
        depiction = Depiction(CAMERA, vertices.astype(np.float32))
        given = {"picture": self.picture(vertices), "regions": self.regions(vertices)} | others
        return Original(replace(self.rig, depiction=depiction), self.template, **given)


@pytest.fixture(scope="session")
def stage(head, head_template):
    """A Stage of a person whom no model was trained on."""
    shape = head_template.with_vertices(head.evaluate(gender=0.3, age=0.6))
    skin = soft_skin(head_template)
    return Stage(make_rig(shape, pictures=Pictures(skin)).rig, head_template)
