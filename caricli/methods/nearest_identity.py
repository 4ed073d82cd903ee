"""Whose face a face is."""

import numpy as np


def nearest_identity(latents, neutrals):
    """The nearest neutral face of every face, by the Euclidean distance of whitened latents.

    latents: (N, D) whitened. neutrals: (I, D) whitened, one for every person.
    Returns (N,) rows of neutrals.
    """
    return np.linalg.norm(latents[:, None] - neutrals[None], axis=-1).argmin(1)
