"""The neutral face of a caricature that shows an expression."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.deformation_transfer import DeformationTransfer
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.methods.expressions.normal_pair import NormalPair
from caricli.methods.expressions.optimise_blendshapes import optimise_blendshapes
from caricli.methods.expressions.settings import BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.rig.keep_contacts import Contacts
from caricli.structures import Camera, Face, Mesh

_FROM_THE_FRONT = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False)
class NeutralFace:
    """A face at rest.

    given: Mesh that it was found from.
    mesh: Mesh at rest; the given one where that shows no expression.
    shown: how much expression the given face shows: how far its farthest vertex is from rest, of how far one goes in
    the middle one of the actions, less than ``BlendshapeSettings.shown`` for neutral faces; None where nobody looked.
    """

    given: Mesh
    mesh: Mesh
    shown: float | None = None

    @property
    def moved(self) -> float:
        """How far the farthest vertex is from where it was given, metres; 0 for a face as it was given."""
        return float(np.linalg.norm(self.mesh.vertices - self.given.vertices, axis=1).max())

    def figures(self) -> dict[str, dict[str, float]]:
        """What reports say of it, as JSON."""
        shown = {} if self.shown is None else {"expression_shown": self.shown}
        return {"neutral": {**shown, "moved": self.moved}}

    def describe(self) -> str:
        """What is printed of it."""
        return f"neutral face up to {1000 * self.moved:.1f} mm from the given one" if self.moved else "neutral as given"


def find_neutral(
    face: Face,
    tools: ExpressionTools | None,
    settings: BlendshapeSettings = BlendshapeSettings(),  # noqa: B008 (frozen)
) -> NeutralFace:
    """Find the face that a caricature has without its expression, with caution: of a broad smile some stays.

    face: Face of the mesh of the tools; seen from the front where it has no camera. tools: ExpressionTools, or None to
    take the face as it is.
    Raises InputError, NumericsError.
    """
    if tools is None:
        return NeutralFace(face.mesh, face.mesh)
    if face.camera is not None:
        return neutral_of(NormalPair(face, tools, settings))
    _, rotation, _ = similarity(tools.morphable.template.vertices, face.vertices)
    upright = face.mesh.with_vertices(face.vertices @ rotation)
    camera = Camera(settings.pictured / upright.height, _FROM_THE_FRONT, np.zeros(2))
    rest = neutral_of(NormalPair(Face(upright, camera), tools, settings))
    moves = (rest.mesh.vertices - upright.vertices) @ rotation.T
    return NeutralFace(face.mesh, face.mesh.with_vertices(face.vertices + moves), rest.shown)


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def neutral_of(pair: NormalPair) -> NeutralFace:
    """The NeutralFace of a caricature, where its normal face shows an expression; else as it was given.

    The normal face goes to rest, the caricature follows, and of its displacement is kept what equation 11 keeps, for
    this one shape alone; what this turns over (a throat under the jaw that closes) is smoothed until it turns back;
    then lips meet that meet on the head of the tools. Raises InputError, NumericsError.
    """
    way = pair.neutral - pair.given
    lengths = np.linalg.norm(pair.tools.actions.deltas, axis=2).max(1)
    usual = float(np.median(lengths[lengths > 0]))
    shown = float(np.linalg.norm(way, axis=1).max()) / usual
    given = pair.face.mesh
    if shown < pair.settings.shown:
        return NeutralFace(given, given, shown)
    (shape,) = pair.follow(pair.neutral[None]).shapes
    (moves,) = optimise_blendshapes((shape - pair.vertices)[None], way[None], pair.mesh, pair.settings.weights, usual)
    rest = pair.vertices + moves
    gradients = pair.template.gradients
    if (flipped_triangles(rest, gradients) & ~flipped_triangles(pair.vertices, gradients)).any():
        rest = untangle(rest, gradients)
    if pair.settings.contacts:
        transfer = DeformationTransfer(rest, pair.template.faces, pair.tools.actions.still)
        rest = rest + Contacts(pair.tools.actions, rest, transfer).rest()
    rest = pair.template.cavities.tuck(rest)
    moves = pair.scale * (rest - pair.vertices)
    return NeutralFace(given, given.with_vertices(given.vertices + moves), shown)
