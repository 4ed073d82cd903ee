"""Faces between two faces, along the straight line of their latents."""

import numpy as np

from caricli.geometry.untangle import untangle
from caricli.methods.faces.encode_face import decode_face, encode_face


def interpolate_faces(first, second, model, steps):
    """Go from one face to another in equal steps of the latent, and of what it leaves over.

    The ends are the given faces exactly; in between, triangles that flip on the way are turned back.

    first, second: EncodedFace of the model. model: ShapeModel. steps: number of faces, both ends included, at least 2.
    Yields an EncodedFace for every step.
    """
    yield first
    for weight in np.linspace(0, 1, steps)[1:-1]:
        latent, residual, shift = (
            (1 - weight) * getattr(first, name) + weight * getattr(second, name)
            for name in ("latent", "residual", "shift")
        )
        vertices = decode_face(latent, residual, model, shift)
        yield encode_face(untangle(vertices, model.template.gradients), model, latent)
    yield second
