"""A face moved along the directions of labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np

from caricli.errors import InputError
from caricli.methods.faces.encode_face import EncodedFace, decode_face, encode_face, require_encoded
from caricli.models.shape_model import ShapeModel
from caricli.structures import Directions

STRONGEST = 20.0
"""Standard deviations, beyond which no face is left."""

_LEAST = 0.05
"""Length of a unit normal that must be left beside the labels to keep: what is shorter points anywhere."""

_INDEPENDENT = 1e-6
"""Singular value, relative to the largest, from which on labels to keep say something of their own."""


@dataclass(frozen=True, eq=False)
class SemanticEdit:
    """How far a face goes towards labels.

    directions: Directions of its model.
    strengths: standard deviations by label, at most ``STRONGEST`` in size.
    keep: labels that are not to change, see ``label_direction``.
    Raises InputError for a strength that is larger, or no number.
    """

    directions: Directions
    strengths: Mapping[str, float]
    keep: Sequence[str] = ()

    def __post_init__(self) -> None:
        """Check the strengths."""
        for name, strength in self.strengths.items():
            if not abs(strength) <= STRONGEST:
                raise InputError(f"label {name}: expected a strength of at most {STRONGEST:g}, found {strength}")

    def scaled(self, share: float) -> "SemanticEdit":
        """The same way, a share of it."""
        return replace(self, strengths={name: share * strength for name, strength in self.strengths.items()})

    def step(self) -> np.ndarray:
        """(D,) that a whitened latent goes. Raises InputError for unknown labels, and those that cannot change."""
        start = np.zeros(self.directions.normals.shape[1])
        steps = (size * label_direction(self.directions, name, self.keep) for name, size in self.strengths.items())
        return sum(steps, start)


def edit_semantic(face: EncodedFace, model: ShapeModel, edit: SemanticEdit) -> EncodedFace:
    """Move the whitened latent by ``sum_k s_k n_k``; what the latent cannot express stays as it is.

    The shape is mended (``Template.mended``): far out triangles turn over, and cavities come through the skin. Latent
    and residual say nothing of this, so that the opposite edit leads back to the face, mended if it was not sound.

    face: EncodedFace of the model. model: ShapeModel. edit: SemanticEdit by directions of the model.
    Returns EncodedFace. Raises InputError for a face or directions of another model, and as ``SemanticEdit.step``.
    """
    require_encoded(face, model)
    if edit.directions.model_id not in ("", model.model_id):
        raise InputError("expected directions in the latents of this model, found those of another model")
    step = edit.step()
    if not step.any():
        return face
    latent = face.latent + model.prior.factor @ step
    moved = encode_face(decode_face(replace(face, latent=latent), model, face.shift), model)
    sound = face.with_vertices(model.template.mended(moved.vertices))
    return replace(moved, mesh=sound.mesh, hair=sound.hair)


def label_direction(directions: Directions, name: str, keep: Sequence[str] = ()) -> np.ndarray:
    """The unit normal of a label, free of the labels to keep (Shen et al. 2020, conditional manipulation).

    It is projected onto the orthogonal complement of their normals, which part their classes, and of their gradients,
    along which their measures change.

    directions: Directions. name: of a label. keep: names of labels.
    Returns (D,). Raises InputError for unknown labels, and for one that the kept ones leave no way to change.
    """
    normal = directions.normals[label_index(directions, name)]
    kept = [label_index(directions, other) for other in keep]
    if not kept:
        return normal
    rows = np.vstack([directions.normals[kept], directions.gradients[kept]])
    rows = rows[np.linalg.norm(rows, axis=1) > 0]
    _, sizes, span = np.linalg.svd(rows / np.linalg.norm(rows, axis=1, keepdims=True), full_matrices=False)
    span = span[sizes > _INDEPENDENT * sizes[0]]
    free = normal - span.T @ (span @ normal)
    length = np.linalg.norm(free)
    if length < _LEAST:
        raise InputError(f"label {name}: cannot change while {', '.join(keep)} is kept: they say the same of a face")
    return free / length


def label_index(directions: Directions, name: str) -> int:
    """Where a label stands in Directions. Raises InputError that suggests the nearest of their names."""
    if name in directions.names:
        return directions.names.index(name)
    names = {label.lower(): label for label in directions.names}
    near = names[get_close_matches(name.lower(), names, 1, 0.0)[0]]
    raise InputError(f"label {name!r}: not among the {len(directions.names)} known; did you mean {near!r}?")
