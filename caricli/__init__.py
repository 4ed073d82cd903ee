"""caricli: drawings, sketches, portraits or landmarks to editable, rigged 3D caricatures.

The names below are the library; each is imported when it is first used, so that ``import caricli`` costs nothing.
docs/python.md walks through them.
"""

from importlib import import_module

TYPE_CHECKING = False  # typing's own would have to be imported, and `caricli` listens to Ctrl-C only after it
if TYPE_CHECKING:
    from caricli.errors import CaricliError
    from caricli.io.face import read_face, write_face
    from caricli.io.gltf.write_gltf import write_gltf
    from caricli.io.image import read_image
    from caricli.io.landmarks import read_landmarks
    from caricli.io.meshes.mesh import read_mesh, write_mesh
    from caricli.methods.animate.animate_rig import animate_rig
    from caricli.methods.edit.caricaturize_face import caricaturize_face
    from caricli.methods.edit.edit_handles import edit_handles
    from caricli.methods.edit.edit_semantic import edit_semantic
    from caricli.methods.expressions.find_neutral import find_neutral
    from caricli.methods.faces.encode_face import encode_face
    from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
    from caricli.methods.reconstruct.refine_face import refine_face
    from caricli.methods.rig.make_rig import make_rig
    from caricli.methods.texture.paint_head import paint_head
    from caricli.store.directions import load_directions
    from caricli.store.expression_tools import load_neutral_tools
    from caricli.store.models import load_model
    from caricli.store.tracks import load_track
    from caricli.structures import Camera, Face, Landmarks, Mesh, Rig

__version__ = "0.1.0"

_HOMES = {
    "caricli.errors": ("CaricliError",),
    "caricli.structures": ("Camera", "Face", "Landmarks", "Mesh", "Rig"),
    "caricli.io.image": ("read_image",),
    "caricli.io.landmarks": ("read_landmarks",),
    "caricli.io.meshes.mesh": ("read_mesh", "write_mesh"),
    "caricli.io.face": ("read_face", "write_face"),
    "caricli.io.gltf.write_gltf": ("write_gltf",),
    "caricli.store.models": ("load_model",),
    "caricli.store.tracks": ("load_track",),
    "caricli.store.directions": ("load_directions",),
    "caricli.methods.reconstruct.fit_landmarks": ("fit_landmarks",),
    "caricli.methods.reconstruct.refine_face": ("refine_face",),
    "caricli.methods.texture.paint_head": ("paint_head",),
    "caricli.methods.faces.encode_face": ("encode_face",),
    "caricli.methods.edit.edit_handles": ("edit_handles",),
    "caricli.methods.edit.edit_semantic": ("edit_semantic",),
    "caricli.methods.edit.caricaturize_face": ("caricaturize_face",),
    "caricli.store.expression_tools": ("load_neutral_tools",),
    "caricli.methods.expressions.find_neutral": ("find_neutral",),
    "caricli.methods.rig.make_rig": ("make_rig",),
    "caricli.methods.animate.animate_rig": ("animate_rig",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Camera",
    "CaricliError",
    "Face",
    "Landmarks",
    "Mesh",
    "Rig",
    "animate_rig",
    "caricaturize_face",
    "edit_handles",
    "edit_semantic",
    "encode_face",
    "find_neutral",
    "fit_landmarks",
    "load_directions",
    "load_model",
    "load_neutral_tools",
    "load_track",
    "make_rig",
    "paint_head",
    "read_face",
    "read_image",
    "read_landmarks",
    "read_mesh",
    "refine_face",
    "write_face",
    "write_gltf",
    "write_mesh",
]


def __getattr__(name: str) -> object:
    """Import a public name when it is first used (PEP 562)."""
    if name not in _HOME_OF:
        raise AttributeError(f"module 'caricli' has no attribute {name!r}")
    value = getattr(import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, imported or not."""
    return sorted({*globals(), *__all__})
