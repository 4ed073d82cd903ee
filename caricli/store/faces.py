"""Faces of files, in the terms of a model."""

from dataclasses import replace

from caricli.errors import InputError, shown
from caricli.io.face import read_face
from caricli.methods.faces.encode_face import encode_face
from caricli.store.models import DEFAULT_ELASTIC, bundled_kind, load_model, model_name


def load_face(path, model):
    """The Face of a file, OBJ or NPZ, refused when its mesh is not the model's or its size not a head's."""
    face, template = read_face(path), model.template
    if face.mesh.topology_id != template.topology_id:
        raise InputError(
            f"{shown(path)}: expected the topology of the model ({len(template.vertices)} vertices, "
            f"{len(template.faces)} triangles), found another ({len(face.vertices)} vertices, {len(face.faces)})"
        )
    height = float(np.ptp(face.vertices[:, 1]))
    if not 0.2 < height / template.height < 5:
        raise InputError(f"{shown(path)}: expected a head about {template.height:.3g} m high, found {height:.3g} m")
    return face


def load_seen_face(path, model=None):
    """A face that knows its camera, with what it is a face of.

    path: NPZ. model: path of the model of its mesh; where none is given, the bundled one that made it, or the default.
    Returns Face, ShapeModel and Camera. Raises InputError for a face without a camera.
    """
    kind = None if model is not None else bundled_kind(read_face(path).model_id)
    shape_model = load_model(model, kind or DEFAULT_ELASTIC)
    face = load_face(path, shape_model)
    if face.latent is not None and face.model_id != shape_model.model_id:
        face = replace(face, latent=None, residual=None)
    return face, shape_model, face_camera(face, path)


def face_camera(face, path):
    """The Camera of a Face that was read from a path. Raises InputError for a face without one."""
    if face.camera is None:
        raise InputError(
            f"{shown(path)}: expected a face with the camera of its picture, found none; make one with caricli "
            "reconstruct-from-landmarks and give its NPZ"
        )
    return face.camera


def load_latent_face(path, model, anew=False):
    """A face for commands that need a latent: its own where the file has one, else it is encoded first.

    path: OBJ or NPZ. model: ShapeModel. anew: encode also what has a latent of another bundled model.
    Returns EncodedFace, the Face of the file, and a line that says that it was encoded, or None.
    Raises InputError for another topology, and for a latent of another model.
    """
    face, dimension = load_face(path, model), len(model.prior.mean)
    foreign = anew and face.model_id != model.model_id and bundled_kind(face.model_id)
    if face.latent is None or face.model_id is None or foreign:
        code = encode_face(face.vertices, model)
        had = f"its latent is of {model_name(face.model_id)}" if foreign else "had no latent"
        error = f"shape error {code.millimetres:.2f} mm ({code.percent:.2f} %)"
        return code, face, f"{shown(path)}: {had}; encoded by {model_name(model.model_id)}, {error}"
    if face.model_id != model.model_id:
        its, ours = (bundled_kind(i) or "MODEL" for i in (face.model_id, model.model_id))
        names = model_name(face.model_id), model_name(model.model_id)
        raise InputError(
            f"{shown(path)}: its latent is of {names[0]}, not of {names[1]}; give --model "
            f"{its}, or encode it again: caricli encode {shown(path)} --model {ours} --out NEW.npz"
        )
    if len(face.latent) != dimension:
        raise InputError(f"{shown(path)}: expected a latent of {dimension} numbers, found {len(face.latent)}")
    return encode_face(face.vertices, model, face.latent, face.residual), face, None
