"""The head of a work with its expression."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.methods.faces.encode_face import EncodedFace, encode_face
from caricli.methods.parts.face_parts import face_parts, let_tongue_out
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.methods.session.tools import Tools
from caricli.methods.session.work import Work
from caricli.structures import HeadChoice, Part
from caricli.structures.arkit import alone, reachable

DRESSED = HeadChoice(("skin", "teeth", "tongue", "lashes", "hair", "bust"))
"""What the page shows of a head beside its eyes."""


@dataclass(frozen=True, eq=False)
class _Acting:
    """What expressions do to a face. rest: (V, 3) metres. names: K. deltas: (K, V, 3) metres."""

    rest: np.ndarray
    names: tuple[str, ...]
    deltas: np.ndarray


class Poser:
    """Gives works their expressions; what these do to a face is asked once for every face, as for a rig."""

    def __init__(self, tools: Tools) -> None:
        """tools: Tools."""
        self.tools = tools
        self._acting: _Acting | None = None
        self._transferred: np.ndarray | None = None
        self._dressed: tuple[_Acting | None, list[Part]] = (None, [])

    def vertices(self, work: Work) -> np.ndarray:
        """(V, 3) metres. Raises NumericsError for a face that nothing can be transferred to."""
        acting = self._acts(work)
        return _moved(acting.rest, acting.names, acting.deltas, work)

    def parts(self, work: Work) -> list[Part]:
        """The Parts of DRESSED that the face has, in its expression, as they stand and without expressions. Raises as
        ``vertices``."""
        acting = self._acts(work)
        if self._dressed[0] is not acting:
            template = self.tools.model.template
            self._dressed = acting, face_parts(work.face, template, DRESSED, alone(acting.names), acting.deltas)
        parts = []
        for part in self._dressed[1]:
            vertices = _moved(part.mesh.vertices, part.names, part.deltas, work)
            parts.append(replace(part, mesh=part.mesh.with_vertices(vertices), names=(), deltas=part.deltas[:0]))
        return parts

    def face(self, work: Work) -> EncodedFace:
        """The EncodedFace in its expression, which is in its residual."""
        if not work.weights:
            return work.face
        return encode_face(work.face.with_vertices(self.vertices(work)), self.tools.model)

    def _acts(self, work: Work) -> _Acting:
        """What at least the expressions of a work do to its face."""
        rest = work.face.vertices
        last = self._acting
        same = last is not None and last.rest is rest
        if last is not None and same and set(work.weights) <= set(last.names):
            return last
        if not same:
            self._transferred = None
        names = tuple(work.weights)
        deltas = np.zeros((0, *rest.shape))
        if names:
            if self._transferred is None:
                self._transferred = transfer_rig(self.tools.templates, rest)
            rows = [self.tools.templates.names.index(name) for name in names]
            face, template = work.face.mesh, self.tools.model.template
            deltas = let_tongue_out(face, template, DRESSED, alone(names), self._transferred[rows])
        self._acting = _Acting(rest, names, deltas)
        return self._acting


def _moved(rest: np.ndarray, names: Sequence[str], deltas: np.ndarray, work: Work) -> np.ndarray:
    """Vertices (W, 3) with what the expressions of a work, where they know them, do to them. deltas: (K, W, 3).

    None goes farther than another leaves room to.
    """
    if not work.weights:
        return rest
    reached = reachable(work.weights)
    moves = [weight * deltas[names.index(name)] for name, weight in reached.items() if name in names]
    return rest + np.sum(moves, axis=0) if moves else rest
