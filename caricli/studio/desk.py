"""What one tab of the page works on, without the page."""

import secrets
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from caricli.errors import InputError, naming
from caricli.methods.rig.add_eyeballs import eye_turns
from caricli.methods.session.history import History
from caricli.methods.session.operations import operate
from caricli.methods.session.pose import Poser
from caricli.methods.session.work import Work
from caricli.render.eyes.place_eyeballs import place_eyeball
from caricli.render.face_look import with_parts
from caricli.render.pixels.srgb import to_linear
from caricli.render.shade import Look
from caricli.store.session_tools import SessionTools, load_start, start_of
from caricli.structures import Operation, Session, Start

EYES = 2 * 6
"""Numbers of the eyes before the positions: centre, radius, turns about y and x of the left and the right one."""


class Desk:
    """A history of works, and what is shown of it; everything here runs in one thread.

    key: text that nobody can guess, by which the page asks for it. start: Start of the session, or None. away: Session
    that goes on when the file is opened that it began with, or None.
    """

    def __init__(self, tools: SessionTools, work: Work, start: Start | None = None) -> None:
        """work: Work before the first operation. start: Start of the file that it is from, or None."""
        self.key = secrets.token_urlsafe(16)
        self.tools = tools
        self.poser = Poser(tools)
        self.basis = np.zeros((3, 0, 3))
        self.away: Session | None = None
        self._begin(History(work, tools), start)

    def open(self, path: Path | None) -> None:
        """Begin anew with a file, or an empty canvas; what is away and began so goes on. Where it is refused nothing
        changes. Raises InputError."""
        work = load_start(path, self.tools)
        start = start_of(path)
        away = self.away
        if away is None or away.start != start:
            self._begin(History(work, self.tools), start)
        else:
            self.away = None
            self._begin(self._done_again(work, away.operations), start)

    def _begin(self, history: History, start: Start | None) -> None:
        self.start = start
        self.history = history
        self.tried: Work | None = None

    def restore(self, start: Start | None, operations: Sequence[Operation]) -> None:
        """Do again what was done before, from the same start. Raises InputError where it is another one."""
        if start != self.start:
            begun = "an empty canvas" if start is None else start.file
            raise InputError(f"expected to go on from {begun}: open it first")
        self._begin(self._done_again(self.history.start, operations), start)

    def open_session(self, session: Session) -> None:
        """Do a session again: one that began with an empty canvas whatever is there, others as ``restore``. Where it
        is refused nothing changes. Raises InputError."""
        if session.start is None:
            self._begin(self._done_again(load_start(None, self.tools), session.operations), None)
        else:
            self.restore(session.start, session.operations)

    def _done_again(self, work: Work, operations: Sequence[Operation]) -> History:
        """The History of operations from a work."""
        history = History(work, self.tools)
        for number, operation in enumerate(operations):
            with naming(f"operation {number}"):
                history.do(operation)
        return history

    @property
    def session(self) -> Session:
        """What was done so far."""
        return Session(self.start, tuple(self.history.done))

    @property
    def work(self) -> Work:
        """What is shown: what is tried while a hand moves, or the present."""
        return self.history.work if self.tried is None else self.tried

    def do(self, operation: Operation, picture: np.ndarray | None = None) -> None:
        """Do an operation for good. picture: (H, W, 3) that it is for, or None for any. Raises InputError."""
        if picture is not None and self.history.work.picture is not picture:
            raise InputError("expected the picture that this is for, found another, which was opened meanwhile")
        self.tried = None
        self.history.do(operation)

    def attempt(self, operation: Operation) -> None:
        """Show what an operation would do, and do not keep it. Raises InputError."""
        self.tried = operate(self.history.work, operation, self.tools)

    def forget(self) -> None:
        """Show the present again, in place of what is tried."""
        self.tried = None

    def undo(self) -> None:
        """One operation back."""
        self.tried = None
        self.history.undo()

    def redo(self) -> None:
        """One forth."""
        self.tried = None
        self.history.redo()

    def frame(self) -> bytes:
        """Eyes and positions of what is shown, (EYES + 3 V) float32, metres, as the head of the page takes them: of
        the skin, then of its parts."""
        work = self.work
        parts = [part.mesh.vertices for part in self.poser.parts(work)]
        vertices = np.concatenate([self.poser.vertices(work), *parts])
        eyes = np.zeros((2, EYES // 2))
        for row, side in enumerate(("left", "right")):
            placed = place_eyeball(work.face.mesh, self.tools.model.template.annotation, side)
            if placed is not None:
                eyes[row, :4] = [*placed[0], placed[1]]
        eyes[:, 4:] = eye_turns(work.weights)
        return np.concatenate([eyes.ravel(), vertices.ravel()]).astype("<f4").tobytes()

    def layout(self) -> bytes:
        """How positions become triangles, the skin first and hair last.

        int32 counts of vertices, corners, triangles, triangles of the skin and of hair; of every corner its vertex; the
        corners (F, 3) of every triangle; then float32 UVs (C, 2) and colours (C, 3) of the corners, linear light.
        """
        work = self.work
        parts = self.poser.parts(work)
        mesh, look = with_parts(work.face.mesh, Look(vertex_colours=np.full(work.face.vertices.shape, 255.0)), parts)
        corners = mesh.faces.ravel()
        if mesh.uvs is None:
            owners = np.arange(len(mesh.vertices))
            places = np.zeros((len(owners), 2))
            triangles = corners
        else:
            pairs, triangles = np.unique(
                np.stack([corners, mesh.uv_faces.ravel()], axis=1), axis=0, return_inverse=True
            )
            owners = pairs[:, 0]
            places = mesh.uvs[pairs[:, 1]]
        colours = to_linear(np.asarray(look.vertex_colours) / 255)[owners]
        hair = sum(len(part.mesh.faces) for part in parts if part.name == "hair")
        head = [len(mesh.vertices), len(owners), len(mesh.faces), len(work.face.mesh.faces), hair]
        whole = np.concatenate([head, owners, triangles.ravel()]).astype("<i4")
        return whole.tobytes() + places.astype("<f4").tobytes() + colours.astype("<f4").tobytes()
