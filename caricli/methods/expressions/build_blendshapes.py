"""Expressions of a caricature from those of a normal face (expressions paper, section 3.2)."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.geometry.deformation.deformation_transfer import DeformationTransfer, triangle_maps
from caricli.methods.expressions.find_neutral import NeutralFace, neutral_of
from caricli.methods.expressions.normal_pair import NormalPair
from caricli.methods.expressions.optimise_blendshapes import UNMOVED, displacement_masks, optimise_blendshapes
from caricli.methods.expressions.settings import BlendshapeSettings
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.methods.rig.keep_contacts import Contacts
from caricli.structures import Face
from caricli.structures.arkit import start_delta


@dataclass(frozen=True, eq=False)
class Blendshapes:
    """Expressions of a caricature and of a normal face.

    shapes: (K, V, 3) metres, of the caricature, the neutral one first; each expression alone, even one that is meant on
    top of another.
    normal: (K, V, 3) metres, of the normal face.
    normal_given: (V, 3) metres, the normal face with the expression of the picture.
    fit: LandmarkFit of the normal face.
    landmarks: (K, 68, 2) pixels, of the caricature, on top of what expressions start from; or None.
    """

    shapes: np.ndarray
    normal: np.ndarray
    normal_given: np.ndarray
    fit: LandmarkFit
    landmarks: np.ndarray | None


# The matrices are small: threads that wait for each other cost more than they bring.
@threadpool_limits.wrap(limits=1)
def build_blendshapes(
    face: Face,
    tools: ExpressionTools,
    settings: BlendshapeSettings = BlendshapeSettings(),  # noqa: B008 (frozen)
) -> Blendshapes:
    """Build the expressions of a caricature that shows one of its own.

    The landmarks of the caricature, as its vertices show them, are mapped to those of a normal face, and the morphable
    model is fitted to these (equation 2). With each expression in the place of its own (equation 3) the landmarks move,
    are mapped back, and the caricature is reconstructed from them, its camera and everything that landmarks do not show
    kept. "initial" stops there; "full" starts from the neutral face of ``find_neutral`` and optimises the displacements
    (equations 4 to 11); "transfer" instead transfers the deformations of the normal face (Sumner and Popovic 2004).
    Then lids and lips meet as they do on the head, whatever the method.

    face: Face S(e_x) with the camera of its picture, of the mesh of the tools.
    Raises InputError, NumericsError.
    """
    pair = NormalPair(face, tools, settings)
    expressions = _Expressions(pair)
    landmarks = None
    if settings.method == "transfer":
        shapes = expressions.transferred()
    else:
        followed = pair.follow(expressions.normal)
        landmarks = followed.landmarks
        shapes = followed.shapes
    if settings.method == "full":
        shapes = expressions.optimised(shapes, neutral_of(pair))
    if settings.contacts:
        shapes = expressions.in_contact(shapes)
    alone = pair.scale * expressions.alone(shapes)
    normal = pair.neutral + tools.templates.deltas
    return Blendshapes(alone, normal, pair.given, pair.fit, landmarks)


class _Expressions:
    """The expressions of a pair, each on top of what it starts from, the neutral one first."""

    def __init__(self, pair: NormalPair) -> None:
        templates = pair.tools.templates
        starts = [start_delta(templates.names, templates.deltas, k) for k in range(len(templates.names))]
        self.pair = pair
        self.templates = templates
        self.normal = pair.neutral + templates.deltas + np.array(starts)
        self.held = displacement_masks(templates.deltas).max(0) < UNMOVED

    def alone(self, shapes: np.ndarray) -> np.ndarray:
        """(K, V, 3) shapes without what they start from."""
        deltas = shapes - shapes[0]
        starts = [start_delta(self.templates.names, deltas, k) for k in range(len(shapes))]
        return shapes - np.array(starts)

    def optimised(self, shapes: np.ndarray, neutral: NeutralFace) -> np.ndarray:
        """(K, V, 3) shapes that exaggerate no more than the normal face's and relate as they do, from a neutral face.

        Equations 4 and 5 count displacements from the given face; of one that smiles, each mask would then keep another
        share of that smile. Counted from the neutral one there is no difference on a neutral face.
        """
        pair = self.pair
        rest = neutral.mesh.vertices / pair.scale
        deltas = np.zeros_like(shapes)
        initial = shapes[1:] - shapes[0]
        deltas[1:] = optimise_blendshapes(initial, self.normal[1:] - pair.neutral, pair.mesh, pair.settings.weights)
        # What moves nothing, as tongueOut does on a head without a tongue, moves nothing exactly.
        deltas[[motion is None for motion in self.templates.motions]] = 0
        return rest + deltas

    def in_contact(self, shapes: np.ndarray) -> np.ndarray:
        """(K, V, 3) shapes with lids and lips meeting as they do on the templates, from the first of them."""
        neutral = shapes[0]
        transfer = DeformationTransfer(neutral, self.templates.faces, self.held)
        contacts = Contacts(self.templates, neutral, transfer)
        return neutral + np.array([contacts.keep(k, shape - neutral) for k, shape in enumerate(shapes)])

    def transferred(self) -> np.ndarray:
        """(K, V, 3) the caricature doing what takes the given normal face to the others."""
        pair = self.pair
        faces = self.templates.faces
        deformations = DeformationTransfer(pair.vertices, faces, self.held)
        everything = np.arange(len(faces))
        maps = (triangle_maps(pair.given, shape, faces) for shape in self.normal)
        ways = self.normal - pair.given
        moves = [deformations.displacements(everything, m, way) for m, way in zip(maps, ways, strict=True)]
        return pair.vertices + np.array(moves)
