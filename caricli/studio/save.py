"""What is taken home from the page."""

import io
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.session import write_session
from caricli.io.sketches.sketch import write_sketch
from caricli.methods.faces.draw_face import FaceDrawing
from caricli.methods.rig.make_rig import make_rig
from caricli.methods.session.mark_operations import placed_marks
from caricli.render.sheets.contact_sheet import contact_sheet
from caricli.store.face_files import write_face_files
from caricli.structures import Face
from caricli.studio.desk import Desk
from caricli.template.fine_mesh import fine_mesh

_SIZE = 640
"""Pixels, width and height of a view in the picture."""


def saved(desk: Desk, kind: str) -> bytes:
    """The file of a kind of SAVED. Raises CaricliError where there is none."""
    return SAVED[kind][1](desk)


def plain_face(desk: Desk) -> Face:
    """The Face in its expression, in what it wears, as commands take it."""
    return desk.poser.face(desk.history.work)


def _session(desk: Desk) -> bytes:
    return _written("session.json", lambda path: write_session(path, desk.session))


def _face(desk: Desk) -> bytes:
    """OBJ and NPZ in a ZIP, with the pictures that the face wears and the session."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        write_face_files(path / "face.obj", path / "face.npz", plain_face(desk))
        write_session(path / "session.json", desk.session)
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(path.iterdir()):
                archive.write(file, file.name)
    return stream.getvalue()


def _rig(desk: Desk) -> bytes:
    face = desk.history.work.face
    rig = make_rig(face.mesh, desk.tools.templates, pictures=face.pictures, given=face).rig
    return _written("rig.glb", lambda path: write_gltf(path, rig))


def _picture(desk: Desk) -> bytes:
    drawing = FaceDrawing(desk.tools.model, fine_mesh(desk.tools.model.template, 0), _SIZE)
    sheet = contact_sheet(drawing.draw(plain_face(desk)))
    return _written("face.png", lambda path: write_png(path, sheet))


def _sketch(desk: Desk) -> bytes:
    return _written("sketch.json", lambda path: write_sketch(path, desk.history.work.sketch))


def _landmarks(desk: Desk, name: str) -> bytes:
    marks = placed_marks(desk.history.work)
    return _written(name, lambda path: write_landmarks(path, marks))


def _written(name: str, write: Callable[[Path], object]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        write(path)
        return path.read_bytes()


SAVED: dict[str, tuple[str, Callable[[Desk], bytes]]] = {
    "rig": ("rig.glb", _rig),
    "face": ("face.zip", _face),
    "picture": ("face.png", _picture),
    "sketch": ("sketch.json", _sketch),
    "landmarks": ("landmarks.json", partial(_landmarks, name="landmarks.json")),
    "pts": ("landmarks.pts", partial(_landmarks, name="landmarks.pts")),
    "session": ("session.json", _session),
}
"""Names of files and what makes them, by kind."""
