"""Whose face a face is."""

from dataclasses import dataclass

import numpy as np

from caricli.models.shape_model import ShapeModel
from caricli.structures import Face


def nearest_identity(latents: np.ndarray, neutrals: np.ndarray) -> np.ndarray:
    """The nearest neutral face of every face, by the Euclidean distance of whitened latents.

    latents: (N, D) whitened. neutrals: (I, D) whitened, one for every person.
    Returns (N,) rows of neutrals.
    """
    return np.linalg.norm(latents[:, None] - neutrals[None], axis=-1).argmin(1)


@dataclass(frozen=True)
class Likeness:
    """How much an edited face is still like itself, in distances of whitened latents.

    own: to the face that it was made of.
    nearest_other: to the nearest other person.
    kept: whether its own is the nearest.
    people: how many others there are.
    """

    own: float
    nearest_other: float
    kept: bool
    people: int


def likeness(before: Face, after: Face, model: ShapeModel, people: np.ndarray) -> Likeness | None:
    """Tell whether a face is still nearest to itself after an edit; both latents are found again from the meshes.

    before, after: Face of the model's topology. model: ShapeModel. people: (I, D) whitened latents of others.
    Returns Likeness, or None where there are no others.
    """
    if not len(people):
        return None
    own, edited = (model.prior.whiten(model.encode(face.vertices)) for face in (before, after))
    gallery = np.vstack([own, people])
    distances = np.linalg.norm(edited - gallery, axis=1)
    kept = bool(nearest_identity(edited[None], gallery)[0] == 0)
    return Likeness(float(distances[0]), float(distances[1:].min()), kept, len(people))
