"""Left and right of a sketch's names, which are the subject's and often taken for the picture's."""

import numpy as np

from caricli.structures.sketch import Sketch

_HIGH = ("brow_", "eye_")
_LOW = ("mouth_", "nose", "nostril_")
"""What the names of curves begin with that lie high and low in a face."""


def sides_exchanged(sketch: Sketch) -> bool:
    """Whether most curves that a sketch names left and right lie as if both were exchanged, however it is turned.

    Up is from mouth and nose to eyes and brows, or in the picture where these are not named.
    """
    middles = {stroke.curve: stroke.points.mean(0) for stroke in sketch.strokes if stroke.curve}
    pairs = {name: name.removesuffix("_left") + "_right" for name in middles if name.endswith("_left")}
    across = [middles[left] - middles[right] for left, right in pairs.items() if right in middles]
    if not across:
        return False
    high, low = ([middle for name, middle in middles.items() if name.startswith(begin)] for begin in (_HIGH, _LOW))
    up = np.mean(high, axis=0) - np.mean(low, axis=0) if high and low else np.array([0.0, -1.0])
    leftward = np.array([-up[1], up[0]])
    return bool(np.mean(np.array(across) @ leftward < 0) > 0.5)
