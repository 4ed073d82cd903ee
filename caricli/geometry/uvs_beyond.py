"""UVs beyond the picture that they lie in."""

import numpy as np

_BESIDE = 1e-3
"""Of a picture: how far beyond its border UVs may be."""


def uvs_beyond(uvs: np.ndarray) -> str | None:
    """What UVs (T, 2) span, in words such as "from 0 to 2", where that is more than 0 to 1; else None."""
    least, most = uvs.min(), uvs.max()
    if least < -_BESIDE or most > 1 + _BESIDE:
        return f"from {least:.3g} to {most:.3g}"
    return None
