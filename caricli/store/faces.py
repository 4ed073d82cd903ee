"""Faces by path, in the terms of a model, and the files that they become."""

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from caricli.data.units import UNITS, measured_unit
from caricli.errors import InputError, naming, shown
from caricli.geometry.alignment.require_upright import require_upright
from caricli.geometry.repair.flat_triangles import flat_triangles
from caricli.io.face import read_face, write_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import write_png
from caricli.io.meshes.obj import write_obj
from caricli.io.worn import PictureNames
from caricli.methods.faces.encode_face import EncodedFace, encode_face, size_note
from caricli.models.morphable.model import MorphableModel
from caricli.models.shape_model import ShapeModel
from caricli.store.models import DEFAULT_ELASTIC, bundled_kind, load_model, model_name
from caricli.store.rig_sources import BUST_FILE, EYES_FILE, load_pictures
from caricli.structures import Face, Mesh, Pictures

if TYPE_CHECKING:
    from caricli.methods.dynamic.face_in_chart import ChartedFace
    from caricli.methods.texture.paint_head import Painted

FILES = {"skin": "texture.png", "eyes": EYES_FILE, "hair": "hair.png", "bust": BUST_FILE}
"""Names of the pictures beside their OBJ, by what wears them."""

CHARTED = "face-arap"
CHARTED_PICTURE = "texture-arap.png"
"""Stem of the files of a face in the chart, and its picture beside them."""

_SMALLEST = 0.2
_LARGEST = 5.0
"""Heights of the template between which a face is a head in metres."""

_MOST_FLAT = 0.01
"""Share of triangles without area up to which a face is a surface; exaggerated ones have a few."""


def load_face(path: Path, model: ShapeModel) -> Face:
    """The Face of a file, OBJ or NPZ.

    Raises InputError when its mesh is not the model's, its size not a head's, it is turned or a mirror image, more than
    a few of its triangles have no area, or its latent is the model's by name but not by length.
    """
    return _checked(read_face(path), path, model)


def load_shape(path: Path, model: ShapeModel) -> np.ndarray:
    """The vertices (V, 3) of a face of a file, metres, though the file be in dm, cm or mm, which its height tells.

    Raises InputError as ``load_face``.
    """
    face = read_face(path)
    if not _is_high_as_a_head(face.mesh.height, model):
        with suppress(InputError):
            metres = UNITS[measured_unit([face.mesh.height])]
            face = Face(face.mesh.with_vertices(metres * face.vertices))
    return _checked(face, path, model).vertices


def _is_high_as_a_head(height: float, model: ShapeModel) -> bool:
    """Whether a height is that of a head in metres, exaggerated ones among them."""
    return _SMALLEST < height / model.template.height < _LARGEST


def _checked(face: Face, path: Path, model: ShapeModel) -> Face:
    """A face of a file that is one of a model; for what is refused see ``load_face``."""
    template = model.template
    if face.mesh.topology_id != template.topology_id:
        counts = f"{len(template.vertices)} vertices, {len(template.faces)} triangles"
        other = f"{len(face.vertices)} vertices, {len(face.faces)} triangles"
        other = "as many in another order" if other == counts else other
        hint = "; the skin of a whole head is what --parts skin writes" if face.mesh.begins_with(template) else ""
        cut = face.mesh.cut_hint(template)
        hint = hint if cut is None else f"; {cut}"
        raise InputError(f"{shown(path)}: expected the topology of the model ({counts}), found another ({other}){hint}")
    height = face.mesh.height
    if not _is_high_as_a_head(height, model):
        raise InputError(f"{shown(path)}: expected a head about {template.height:.3g} m high, found {height:.3g} m")
    with naming(path):
        require_upright(face.vertices, template.vertices)
    flat = flat_triangles(face.vertices, face.faces)
    if flat.mean() > _MOST_FLAT:
        raise InputError(f"{shown(path)}: expected triangles with an area, found {flat.sum()} of {len(flat)} without")
    dimension = len(model.prior.mean)
    if face.latent is not None and face.model_id == model.model_id and len(face.latent) != dimension:
        raise InputError(f"{shown(path)}: expected a latent of {dimension} numbers, found {len(face.latent)}")
    return face


def load_worn_face(path: Path, model: ShapeModel) -> Face:
    """The same with the pictures that it wears, in polygons to go on with: the model's, whose quads and UVs it takes
    unless it has UVs of its own.

    Raises InputError, too, where a picture that the file names is not there.
    """
    return _worn(load_face(path, model), path, model)


def _worn(face: Face, path: Path, model: ShapeModel) -> Face:
    """A face of a file with what it wears, see ``load_worn_face``."""
    pictures = Pictures()
    # A picture lies nowhere on a mesh without UVs.
    if face.mesh.uvs is not None:
        with naming(path):
            pictures = face.pictures or load_pictures(path)
        if not face.mesh.same_layout(model.template):
            return replace(face, pictures=pictures)
    materials = face.materials if len(face.mesh.polygons) == len(model.template.polygons) else None
    return replace(face, mesh=model.template.with_vertices(face.vertices), pictures=pictures, materials=materials)


def load_seen_face(path: Path, model: Path | None = None) -> tuple[Face, ShapeModel]:
    """A face that knows its camera, with what it is a face of.

    path: NPZ. model: path of the model of its mesh; where none is given, the bundled one that made it, or the default.
    Returns Face, without a latent that is not the model's, and ShapeModel. Raises InputError for a face without a
    camera.
    """
    face = read_face(path)
    kind = None if model is not None else bundled_kind(face.model_id)
    shape_model = load_model(model, kind or DEFAULT_ELASTIC)
    face = _worn(_checked(face, path, shape_model), path, shape_model)
    if face.latent is not None and face.model_id != shape_model.model_id:
        face = replace(face, latent=None, residual=None)
    with naming(path):
        face.require_camera()
    return face, shape_model


def load_latent_face(path: Path, model: ShapeModel, anew: bool = False) -> tuple[EncodedFace, str | None]:
    """A face for commands that need a latent: its own where the file has one, else it is encoded first.

    path: OBJ or NPZ. model: ShapeModel. anew: encode also what has a latent of another bundled model.
    Returns the EncodedFace with what it wears, and a line that says that a mesh alone was encoded, or None.
    Raises InputError for another topology, and for a latent of another model.
    """
    face = load_worn_face(path, model)
    foreign = anew and face.model_id != model.model_id and bundled_kind(face.model_id)
    if face.latent is None or face.model_id is None or foreign:
        code = encode_face(face, model)
        error = f"shape error {code.millimetres:.2f} mm ({code.percent:.2f} %)"
        size = size_note(face, model)
        note = f"{shown(path)}: had no latent; encoded by {model_name(model.model_id)}, {error}"
        note += f"; {size}" if size else ""
        # From one bundled model to another nothing is lost: what the new latent cannot express stays beside it.
        return code, None if foreign else note
    if face.model_id != model.model_id:
        its, ours = (bundled_kind(i) or "MODEL" for i in (face.model_id, model.model_id))
        raise InputError(
            f"{shown(path)}: its latent is of {model_name(face.model_id)}, not of {model_name(model.model_id)}; give "
            f"--model {its}, or encode it again: caricli encode {shown(path)} --model {ours} --out NEW.npz"
        )
    return encode_face(face, model), None


def load_identity(path: Path | None, model: MorphableModel) -> tuple[np.ndarray, str | None]:
    """Identity coefficients (I,) of a face, or of the mean face where there is none.

    path: OBJ or NPZ, or None. Returns them, and a line that says that the face was encoded, or None.
    Raises InputError for another topology, and for a latent of a model that is not bundled.
    """
    if path is None:
        return np.zeros(len(model.identity)), None
    code, note = load_latent_face(path, model, anew=True)
    return model.parts(code.latent)[0], note


def write_painted_head(folder: Path, painted: "Painted") -> None:
    """Write a textured head: OBJ with material and pictures, NPZ for the next command, GLB with eyes.

    folder: of face.obj, .mtl, .npz and .glb, texture.png and eyes.png.
    Raises OutputError when a file cannot be written.
    """
    rig = painted.rig
    names = PictureNames(*(None if picture is None else FILES[name] for name, picture in rig.pictures.items()))
    for name, picture in rig.pictures.items():
        if picture is not None:
            write_png(folder / FILES[name], picture)
    mesh = _trimmed(painted.head)
    write_obj(folder / "face.obj", mesh, names.skin, others=names.others)
    write_face(folder / "face.npz", replace(painted.face, mesh=mesh, pictures=painted.pictures, materials=None), names)
    write_gltf(folder / "face.glb", rig)


def write_charted_face(folder: Path, charted: "ChartedFace") -> None:
    """Write the face by itself, in the chart: texture-arap.png and face-arap.obj, .mtl and .npz in a folder.

    Raises OutputError when a file cannot be written.
    """
    write_png(folder / CHARTED_PICTURE, charted.picture)
    write_obj(folder / f"{CHARTED}.obj", charted.mesh, CHARTED_PICTURE)
    worn = Face(charted.mesh, pictures=Pictures(charted.picture))
    write_face(folder / f"{CHARTED}.npz", worn, PictureNames(CHARTED_PICTURE))


def _trimmed(mesh: Mesh) -> Mesh:
    """The mesh without the last UVs, those of parts that it does not have."""
    assert mesh.uvs is not None and mesh.uv_polygons is not None
    return Mesh(mesh.vertices, mesh.polygons, mesh.uvs[: mesh.uv_polygons.max() + 1], mesh.uv_polygons)
