"""Pictures of a rig's skin in expressions (expressions paper, section 3.3)."""

from collections.abc import Iterable, Mapping

import cv2
import numpy as np
from scipy.optimize import lsq_linear

from caricli.data.expressions import MAX_WEIGHT, named_expressions
from caricli.errors import InputError, shown
from caricli.geometry.eye_openness import eye_openness
from caricli.methods.dynamic.chart_pictures import ChartGrid, texture_to_chart
from caricli.methods.dynamic.dress_texture import ChangedTexture
from caricli.methods.dynamic.mouth_parts import MouthParts
from caricli.methods.dynamic.own_manner import MannerReader
from caricli.methods.dynamic.shape_maps import GAP, PersonShapes, pair_maps
from caricli.models.texture.model import TextureModel
from caricli.structures import Mesh, Mood, Rig
from caricli.structures.arkit import ARKIT_NAMES, action_codes, arkit_name
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT
from caricli.structures.texture_change import TextureChange
from caricli.template.chart import face_chart
from caricli.template.template import Template

USUAL_MOODS = ("smile", "laugh", "frown", "anger", "disgust", "surprise", "mouth_open", "caricature_sad")
"""Named expressions that a rig of single actions gets pictures of, where nothing else is asked for."""

_FINER = 4
"""Texels of the picture in the chart for one that the network sees, so that this is their mean."""

_EVERY = 4
"""One of so many vertices tells which expression a face shows."""

_LEAST = 1e-6
"""Of a move, metres: where no expression moves more, there is none to tell."""

_APART = 0.15
"""Gap between lips, of a quarter of the face's width, from which on a picture shows none that are closed."""

_SHUT = 0.12
"""Height of an eye for its width up to which a picture shows it shut."""

Weights = Mapping[str, Mapping[str, float]]
"""Names to weights by name."""


class MoodPainter:
    """Paints the skin of a rig as its expressions show it.

    What the face shows in its picture is told by the rig's expressions, as those whose sum is nearest to it.
    """

    def __init__(self, rig: Rig, template: Template, model: TextureModel) -> None:
        """rig: with a picture of its skin; its first vertices are the template's. template: Template of the skin.
        model: TextureModel.

        Raises InputError where the rig has no picture, or another skin, where nothing tells what its expressions are,
        or where the network is of another topology.
        """
        if template.topology_id != model.topology_id:
            raise InputError("expected a texture network of the face's mesh, found one of another")
        skin = rig_skin(rig, template)
        picture = rig.pictures.skin
        assert picture is not None
        count = len(template.vertices)
        self.names = rig.names
        self.model = model
        self.grid = ChartGrid(face_chart(template), model.size)
        self.neutral = np.asarray(rig.neutral[:count], float)
        self.deltas = np.asarray(rig.deltas[:, :count], float)
        self.codes = expression_codes(rig)
        mouth = MouthParts.in_face(template.with_vertices(self.neutral), self.deltas)
        self.person = PersonShapes(self.grid, self.neutral, mouth)
        self.depicted = rig.depiction is not None
        seen = self.neutral if rig.depiction is None else np.asarray(rig.depiction.vertices[:count], float)
        weights = self._shown_weights(seen)
        self.shown = self.person.fields(seen, weights)
        self.code = weights @ self.codes
        points = seen[template.annotation.landmarks]
        self.eyes = min(eye_openness(points[list(eye)]) for eye in (EYE_RIGHT, EYE_LEFT))
        fine = texture_to_chart(picture, skin, ChartGrid(self.grid.chart, _FINER * model.size))
        self.own = cv2.resize(fine, (model.size, model.size), interpolation=cv2.INTER_AREA)
        self.manner = MannerReader(self.grid, template).read(self.own)
        self.texture = ChangedTexture(picture, skin, self.grid)

    def change(self, weights: np.ndarray) -> TextureChange:
        """What the picture becomes with expressions (K,) of the rig, in the chart."""
        target = self.person.fields(self.neutral + np.tensordot(weights, self.deltas, 1), weights)
        maps = pair_maps(self.grid, self.shown, target)
        code = np.minimum(weights @ self.codes, MAX_WEIGHT)
        return self.model.change(self.own, maps, self.code, code, self.manner)

    def paint(self, weights: np.ndarray) -> np.ndarray:
        """(H, H, 3) uint8, the skin's picture with expressions (K,) of the rig."""
        return self.texture.paint(self.change(weights))

    def moods(self, moods: Weights) -> tuple[Mood, ...]:
        """Pictures in moods, which are names of expressions of the rig with weights, by the moods' names."""
        painted = []
        for name, weights in moods.items():
            row = np.array([weights.get(own, 0.0) for own in self.names])
            painted.append(Mood(name, self.paint(row)))
        return tuple(painted)

    def unknown(self) -> list[str]:
        """What the rig and its picture do not tell, for messages."""
        notes = []
        if not self.depicted:
            notes.append("it does not say what its picture shows, which is taken for the face at rest; an NPZ of a "
                         "face with a camera does")  # fmt: skip
        if self.shown.values[:, GAP].max() > _APART:
            notes.append("the picture shows the mouth open: how lips look that close, it does not tell")
        if self.eyes < _SHUT:
            notes.append("the picture shows an eye shut: how its lid looks when it opens is made up")
        still = [name for name, code in zip(self.names, self.codes, strict=True) if not code.any()]
        if still:
            notes.append(f"painted by shape alone, as no action of ARKit is known of them: {shown(_list(still), 200)}")
        return notes

    def _shown_weights(self, vertices: np.ndarray) -> np.ndarray:
        """(K,) weights from 0 to 1 of the rig's expressions whose sum is nearest to vertices (V, 3)."""
        way = (vertices - self.neutral)[::_EVERY].ravel()
        if not len(self.deltas) or np.abs(way).max() < _LEAST:
            return np.zeros(len(self.deltas))
        columns = self.deltas[:, ::_EVERY].reshape(len(self.deltas), -1)
        return lsq_linear(columns.T, way, (0, 1)).x


def rig_skin(rig: Rig, template: Template) -> Mesh:
    """The skin of a rig at rest, without its parts, on the UVs of its picture.

    template: Template of the skin. Raises InputError where it has no picture, or one that is not square, or the rig
    another skin.
    """
    count = len(template.faces)
    if not np.array_equal(rig.faces[:count], template.faces):
        raise InputError(
            f"dynamic texture needs a rig of the head's own skin, {len(template.vertices)} vertices that are not "
            "subdivided, found another"
        )
    if rig.pictures.skin is None or rig.mesh.uvs is None:
        raise InputError("dynamic texture needs a face with a picture on its skin, as `caricli texture` writes one")
    height, width = rig.pictures.skin.shape[:2]
    if height != width:
        raise InputError(f"dynamic texture needs a square picture on the skin, found {width} x {height}")
    vertices = np.asarray(rig.neutral[: len(template.vertices)], float)
    return Mesh(vertices, template.faces, rig.mesh.uvs, rig.mesh.uv_faces[:count])


def expression_codes(rig: Rig) -> np.ndarray:
    """(K, 52) weights of ARKit's actions that a rig's expressions are made of: as it says, else by their names.

    Raises InputError where neither tells anything.
    """
    if rig.actions is not None:
        return rig.actions
    usual: dict[str, dict[str, float]] = named_expressions(ARKIT_NAMES)
    alone = {name: {action: 1.0} for name in rig.names if (action := arkit_name(name))}
    codes = action_codes([(usual | alone).get(name, {}) for name in rig.names])
    if not codes.any():
        raise InputError(
            "dynamic texture needs expressions that are made of ARKit's actions, found a rig that says of none what "
            f"it is ({shown(_list(rig.names), 60)}); `caricli blendshapes` writes one"
        )
    return codes


def _list(names: Iterable[str]) -> str:
    return ", ".join(names)
