"""The face of a work with its expression."""

import numpy as np

from caricli.methods.faces.encode_face import EncodedFace, encode_face
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work

_TURNS = {"Up": (0.0, -22.0), "Down": (0.0, 25.0), "In": (-30.0, 0.0), "Out": (30.0, 0.0)}
"""Degrees that the left eye turns at full weight, about y and about x, as rigs have it."""


class Poser:
    """Gives works their expressions; what these do to a face is transferred once for every face, as for a rig."""

    def __init__(self, tools: Tools) -> None:
        """tools: Tools."""
        self.tools = tools
        self._vertices: np.ndarray | None = None
        self._deltas = np.zeros((0, 0, 3))

    def vertices(self, work: Work) -> np.ndarray:
        """(V, 3) metres. Raises NumericsError for a face that nothing can be transferred to."""
        rest = work.face.vertices
        if not work.weights:
            return rest
        if self._vertices is not rest:
            self._deltas = transfer_rig(self.tools.templates, rest)
            self._vertices = rest
        names = self.tools.templates.names
        moved = [weight * self._deltas[names.index(name)] for name, weight in work.weights.items()]
        return rest + np.sum(moved, axis=0)

    def face(self, work: Work) -> EncodedFace:
        """The EncodedFace in its expression, which is in its residual."""
        if not work.weights:
            return work.face
        return encode_face(work.face.with_vertices(self.vertices(work)), self.tools.model)


def eye_turns(work: Work) -> np.ndarray:
    """(2, 2) radians, of the left and the right eye about y, to the subject's left, and about x, down."""
    turns = np.zeros((2, 2))
    for row, (side, mirror) in enumerate((("Left", 1), ("Right", -1))):
        for way, (about_y, about_x) in _TURNS.items():
            turns[row] += work.weights.get(f"eyeLook{way}{side}", 0) * np.array([mirror * about_y, about_x])
    return np.radians(turns)
