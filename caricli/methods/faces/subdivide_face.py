"""A face on a finer mesh."""


def subdivide_face(vertices, latent, model, fine):
    """Decode a latent on a finer mesh and add what the face has beyond it, carried along linearly.

    vertices: (V, 3) of the face, which come first in the result. latent: (D,). model: ShapeModel. fine: FineMesh of the
    model's template.
    Returns (W, 3).
    """
    if not fine.levels:
        return vertices
    return model.decode_on(latent, fine.weights) + fine.weights @ (vertices - model.decode(latent))
