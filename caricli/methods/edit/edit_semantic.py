"""A face moved along the directions of labels."""

from difflib import get_close_matches

import numpy as np

from caricli.errors import InputError
from caricli.methods.faces.encode_face import decode_face, encode_face

STRONGEST = 20.0
_LEAST = 0.05


def edit_semantic(face, model, directions, strengths, keep=()):
    """Move the whitened latent by ``sum_k s_k n_k``; what the latent cannot express stays as it is.

    face: EncodedFace of the model. model: ShapeModel. directions: Directions of the model. strengths: dict from labels
    to standard deviations, at most ``STRONGEST`` in size. keep: labels that are not to change, see ``label_direction``.
    Returns EncodedFace. Raises InputError.
    """
    for name, strength in strengths.items():
        if not abs(strength) <= STRONGEST:
            raise InputError(f"label {name}: expected a strength of at most {STRONGEST:g}, found {strength}")
    step = sum(strength * label_direction(directions, name, keep) for name, strength in strengths.items())
    latent = face.latent + model.prior.factor @ step
    return encode_face(decode_face(latent, face.residual, model, face.shift), model, latent, face.residual)


def label_direction(directions, name, keep=()):
    """The unit normal of a label, free of the labels to keep (Shen et al. 2020, conditional manipulation).

    It is projected onto the orthogonal complement of their normals, which part their classes, and of their gradients,
    along which their measures change. Returns (D,). Raises InputError for unknown labels, and for one that the kept
    ones leave no way to change.
    """
    normal = directions.normals[label_index(directions, name)]
    kept = [label_index(directions, other) for other in keep]
    if not kept:
        return normal
    rows = np.vstack([directions.normals[kept], directions.gradients[kept]])
    rows = rows[np.linalg.norm(rows, axis=1) > 0]
    _, sizes, span = np.linalg.svd(rows / np.linalg.norm(rows, axis=1, keepdims=True), full_matrices=False)
    span = span[sizes > 1e-6 * sizes[0]]
    free = normal - span.T @ (span @ normal)
    length = np.linalg.norm(free)
    if length < _LEAST:
        raise InputError(f"label {name}: cannot change while {', '.join(keep)} is kept: they say the same of a face")
    return free / length


def label_index(directions, name):
    """Where a label stands in Directions. Raises InputError that suggests the nearest of their names."""
    if name in directions.names:
        return directions.names.index(name)
    lower = {known.lower(): known for known in directions.names}
    near = get_close_matches(name.lower(), lower, 1, 0.0)
    raise InputError(f"label {name!r}: not among the {len(directions.names)} known; did you mean {lower[near[0]]!r}?")
