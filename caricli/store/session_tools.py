"""What sessions begin with and work with, by path."""

import os
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

from caricli.errors import InputError, naming, shown
from caricli.io.image import is_image_file, read_image
from caricli.io.meshes.mesh import is_mesh_file
from caricli.io.meshes.mtl import material_library
from caricli.io.provenance import sha256_file
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.encode_landmarks import LandmarkEncoder
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.head_expressions import open_head_expressions
from caricli.methods.session.operations import operate
from caricli.methods.session.work import CANVAS_SIDE, Work
from caricli.methods.sketch.read_strokes import read_strokes
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.models.gesture.model import GestureModel
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel
from caricli.store.directions import load_directions
from caricli.store.faces import load_latent_face
from caricli.store.gestures import load_gestures
from caricli.store.landmark_encoders import elastic_encoder
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.store.pictures import PICTURES
from caricli.store.sketch_networks import load_sketch_pair
from caricli.store.sketches import load_sketch
from caricli.store.strokes import load_strokes
from caricli.structures import Directions, Face, Operation, Sketch, Start


@dataclass(frozen=True, eq=False)
class SessionTools:
    """The Tools of sessions, of the bundled models; each is loaded when it is first asked for."""

    @cached_property
    def model(self) -> ShapeModel:
        """The shape model of all faces."""
        return load_model(kind=DEFAULT_LATENT)

    @cached_property
    def encoder(self) -> LandmarkEncoder:
        """Faces of landmarks."""
        return elastic_encoder(self.model)

    @cached_property
    def _sketches(self) -> tuple[SketchModel, ShapeModel]:
        return load_sketch_pair()

    @property
    def network(self) -> SketchModel:
        """Faces of sketches."""
        return self._sketches[0]

    @property
    def basis(self) -> ShapeModel:
        """The model whose latents the network tells."""
        return self._sketches[1]

    @cached_property
    def reconstruction(self) -> SketchReconstruction:
        """Faces that follow lines."""
        see = partial(see_sketch, network=self.network, basis=self.basis)
        return SketchReconstruction.of(self.encoder, see, partial(read_strokes, network=load_strokes()))

    @cached_property
    def directions(self) -> Directions:
        """Labels."""
        return load_directions(self.model)

    @cached_property
    def templates(self) -> ExpressionTemplates:
        """The 52 expressions of ARKit."""
        return open_head_expressions()

    @cached_property
    def gestures(self) -> GestureModel:
        """What strokes on the head mean."""
        return load_gestures()


def load_start(path: Path | None, tools: SessionTools) -> Work:
    """The Work that a file begins: a face (NPZ or mesh), a picture to draw over or to place landmarks on, or a sketch.

    path: None for the mean face and an empty canvas. Raises InputError for other files.
    """
    model = tools.model
    mean = Face(model.template.with_vertices(model.decode(model.prior.mean)))
    if path is None:
        return Work(encode_face(mean, model))
    if path.suffix.lower() == ".npz" or is_mesh_file(path):
        return Work(load_latent_face(path, model, anew=True)[0])
    if is_image_file(path) or path.suffix.lower() in PICTURES:
        picture = read_image(path)
        height, width = picture.shape[:2]
        return Work(encode_face(mean, model), Sketch(size=(width, height)), picture=picture)
    sketch = load_sketch(path).scaled((CANVAS_SIDE, CANVAS_SIDE))
    with naming(path):
        return operate(Work(encode_face(mean, model), sketch), Operation("follow"), tools)


def lacks_materials(path: Path) -> bool:
    """Whether a file is an OBJ whose materials are not beside it."""
    library = material_library(path)
    return library is not None and not os.path.exists(library)


def start_of(path: Path | None) -> Start | None:
    """The Start of a file. Raises InputError when it cannot be read."""
    return None if path is None else Start(path.name, sha256_file(path))


def find_start(session: Path, start: Start | None, given: Path | None) -> Path | None:
    """The file that a session began with: the given one, or that of its name beside the session.

    session: path. start: of the session. Raises InputError where it is not there, or another than it was.
    """
    if start is None:
        if given is not None:
            raise InputError(f"{shown(given)}: expected no file, for the session began without one, found it")
        return None
    path = session.with_name(start.file) if given is None else given
    if not path.is_file():
        raise InputError(f"{shown(session)}: expected {shown(start.file)}, which it began with, beside it, found none")
    content = sha256_file(path)
    if content != start.sha256:
        raise InputError(
            f"{shown(path)}: expected the file that the session began with, SHA-256 {start.sha256[:12]}..., found "
            f"another, {content[:12]}..."
        )
    return path
