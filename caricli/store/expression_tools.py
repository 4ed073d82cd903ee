"""What expressions of caricatures are made with, and the caricatures, by path."""

from dataclasses import dataclass
from pathlib import Path

from caricli.data.expressions import read_expressions, single_expressions
from caricli.errors import InputError, naming, shown
from caricli.io.meshes.mesh import is_mesh_file
from caricli.methods.expressions.tools import ExpressionTools
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.expression_templates import load_templates, on_template
from caricli.store.face_pictures import FaceReader
from caricli.store.faces import load_worn_face
from caricli.store.landmark_maps import landmark_map_path, load_landmark_map
from caricli.store.models import DEFAULT_LATENT, load_model, load_morphable
from caricli.store.rig_sources import PictureSources, picture_sources
from caricli.structures import Face, Mesh
from caricli.structures.detection import FacePicture


@dataclass(frozen=True)
class ToolPaths:
    """Where the tools of expressions are; what is None is bundled.

    expressions: YAML or JSON of names with actions. landmark_map: of `train landmark-map`. model: of `train morphable`.
    templates: folder with a neutral OBJ and actions.
    """

    expressions: Path | None = None
    landmark_map: Path | None = None
    model: Path | None = None
    templates: Path | None = None


def load_tools(paths: ToolPaths = ToolPaths(), latent: bool = False) -> tuple[ExpressionTools, list[Path]]:  # noqa: B008 (frozen)
    """The ExpressionTools of paths, and the files that were read.

    latent: whether landmarks are followed in the latent of a model.
    Raises InputError where they are not of one mesh, or no expression moves anything.
    """
    morphable = load_morphable(paths.model)
    actions, template_files = load_templates(paths.templates)
    model = load_model(kind=DEFAULT_LATENT) if latent else None
    meshes = [actions.mesh, *([model.template] if model else [])]
    if any(mesh.topology_id != morphable.template.topology_id for mesh in meshes):
        expected = f"templates and models of one mesh, that of the morphable model ({len(morphable.mean)} vertices)"
        raise InputError(f"{shown(paths.model or paths.templates)}: expected {expected}, found another")
    expressions = single_expressions(actions.names)
    if paths.expressions is not None:
        expressions = read_expressions(paths.expressions, actions.names)
    actions = on_template(actions, morphable.template)
    tools = ExpressionTools(actions, expressions, morphable, load_landmark_map(paths.landmark_map), model)
    if not tools.templates.deltas.any():
        raise InputError(f"{shown(paths.expressions)}: expected expressions that move something, found none")
    files = [paths.expressions, paths.model, landmark_map_path(paths.landmark_map), *template_files]
    return tools, [path for path in files if path is not None]


def load_neutral_tools(mesh: Mesh) -> ExpressionTools | None:
    """The bundled tools, which find the neutral face of a mesh; None for one of another topology than theirs."""
    actions, _ = load_templates()
    return load_tools()[0] if mesh.topology_id == actions.mesh.topology_id else None


@dataclass(frozen=True, eq=False)
class Caricature:
    """What expressions are to be of.

    face: Face with the camera of its picture. worn: PictureSources of what it wears. source: FacePicture that it was
    reconstructed from, or None where it was there.
    """

    face: Face
    worn: PictureSources
    source: FacePicture | None = None


def caricature_pictures(source: Path, texture: Path | None = None) -> PictureSources:
    """What the caricature of ``load_caricature`` wears, told before it is reconstructed."""
    return picture_sources(source, texture) if source.suffix.lower() == ".npz" else PictureSources(texture)


def load_caricature(
    source: Path,
    tools: ExpressionTools,
    texture: Path | None = None,
    reader: FaceReader = FaceReader(),  # noqa: B008 (frozen)
) -> Caricature:
    """A caricature that is there, or is reconstructed.

    source: a face (NPZ), or landmarks or a picture, from which it is reconstructed. texture: the skin's picture, or
    None for the face's own. reader: FaceReader of landmarks and pictures.
    Raises InputError for a face without a camera or of another mesh than the tools', and a picture without a face.
    """
    morphable = tools.morphable
    worn = caricature_pictures(source, texture)
    if is_mesh_file(source):
        raise InputError(
            f"{shown(source)}: expected FACE.npz, a picture or landmarks, found a mesh, which has no camera"
        )
    if source.suffix.lower() == ".npz":
        face = load_worn_face(source, morphable)
        with naming(source):
            face.require_camera()
        return Caricature(face, worn)
    intrinsic = load_model()
    if intrinsic.template.topology_id != morphable.template.topology_id:
        raise InputError(f"{shown(source)}: expected a FACE.npz for a model of another mesh, found landmarks")
    count = len(intrinsic.template.annotation.landmarks)
    picture = reader.read(source, count)
    fit = fit_landmarks(picture.landmarks.head_points, intrinsic, spreads=picture.landmarks.spreads)
    face = Face(morphable.template.with_vertices(fit.face.vertices), fit.face.camera, fit.face.landmarks)
    return Caricature(face, worn, picture)
