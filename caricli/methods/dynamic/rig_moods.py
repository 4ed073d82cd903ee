"""Pictures of a rig's skin in expressions (expressions paper, section 3.3)."""

from collections.abc import Mapping

import cv2
import numpy as np
from scipy.optimize import lsq_linear

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid, texture_to_chart
from caricli.methods.dynamic.dress_texture import ChangedTexture
from caricli.methods.dynamic.mouth_parts import MouthParts
from caricli.methods.dynamic.shape_maps import PersonShapes, pair_maps
from caricli.models.texture.model import TextureModel
from caricli.structures import Face, Mood, Rig
from caricli.structures.arkit import ARKIT_NAMES
from caricli.template.chart import face_chart
from caricli.template.template import Template

USUAL_MOODS = ("smile", "laugh", "frown", "anger", "disgust", "surprise", "mouth_open", "caricature_sad")
"""Named expressions that a rig of single actions gets pictures of, where nothing else is asked for."""

_FINER = 4
"""Texels of the picture in the chart for one that the network sees, so that this is their mean."""

_EVERY = 4
"""One of so many vertices tells which expression a face shows."""

_LEAST = 1e-9
"""Of a move, metres: where no expression moves more, there is none to tell."""

Weights = Mapping[str, Mapping[str, float]]
"""Names to weights by name."""


class MoodPainter:
    """Paints the texture of one face as its expressions show it.

    What the face shows in its picture is told by the rig's expressions, as those whose sum is nearest to it.
    """

    def __init__(self, rig: Rig, worn: Face, actions: Weights, template: Template, model: TextureModel) -> None:
        """rig: of the face's expressions, whose first vertices are the skin's. worn: Face as its picture shows it, with
        the skin's picture. actions: ARKit weights of the rig's expressions, by their names. template: Template of the
        skin. model: TextureModel.

        Raises InputError where the face has no picture, or the network is of another topology.
        """
        picture = worn.pictures.skin
        if picture is None:
            raise InputError("dynamic texture needs a face with a picture on its skin, as `caricli texture` writes one")
        if template.topology_id != model.topology_id:
            raise InputError("expected a texture network of the face's mesh, found one of another")
        count = len(template.vertices)
        self.names = rig.names
        self.model = model
        self.grid = ChartGrid(face_chart(template), model.size)
        self.neutral = np.asarray(rig.neutral[:count], float)
        self.deltas = np.asarray(rig.deltas[:, :count], float)
        self.codes = np.array([[actions[name].get(action, 0.0) for action in ARKIT_NAMES] for name in rig.names])
        self.person = PersonShapes(
            self.grid, self.neutral, MouthParts.in_face(template.with_vertices(self.neutral), self.deltas)
        )
        weights = self._shown_weights(worn.vertices[:count])
        self.shown = self.person.fields(worn.vertices[:count], weights)
        self.code = weights @ self.codes
        fine = texture_to_chart(picture, template, ChartGrid(self.grid.chart, _FINER * model.size))
        self.own = cv2.resize(fine, (model.size, model.size), interpolation=cv2.INTER_AREA)
        self.texture = ChangedTexture(picture, template, self.grid)

    def paint(self, weights: np.ndarray) -> np.ndarray:
        """(H, H, 3) uint8, the skin's picture with expressions (K,) of the rig."""
        target = self.person.fields(self.neutral + np.tensordot(weights, self.deltas, 1), weights)
        maps = pair_maps(self.grid, self.shown, target)
        return self.texture.paint(self.model.change(self.own, maps, self.code, weights @ self.codes))

    def moods(self, moods: Weights) -> tuple[Mood, ...]:
        """Pictures in moods, which are names of expressions of the rig with weights, by the moods' names."""
        painted = []
        for name, weights in moods.items():
            row = np.array([weights.get(own, 0.0) for own in self.names])
            painted.append(Mood(name, self.paint(row)))
        return tuple(painted)

    def _shown_weights(self, vertices: np.ndarray) -> np.ndarray:
        """(K,) weights from 0 to 1 of the rig's expressions whose sum is nearest to vertices (V, 3)."""
        columns = self.deltas[:, ::_EVERY].reshape(len(self.deltas), -1)
        way = (vertices - self.neutral)[::_EVERY].ravel()
        if np.abs(way).max() < _LEAST or not len(columns):
            return np.zeros(len(columns))
        return lsq_linear(columns.T, way, (0, 1)).x
