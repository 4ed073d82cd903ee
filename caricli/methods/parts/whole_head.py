"""A face as a whole head."""

from dataclasses import fields

import numpy as np

from caricli.errors import InputError
from caricli.methods.faces.subdivide_face import finer_face
from caricli.methods.parts.face_parts import face_parts
from caricli.methods.parts.shoulders import add_shoulders
from caricli.methods.rig.add_eyeballs import add_eyeballs, fit_eyeballs
from caricli.methods.rig.add_parts import add_parts, choose_parts
from caricli.structures import Face, HeadChoice, Rig
from caricli.structures.head_choice import BARE, WHOLE
from caricli.template.fine_mesh import FineMesh
from caricli.template.head import load_head
from caricli.template.template import Template, WholeHead

_OWN_TEETH = "has its parts already; --teeth is for a skin alone, such as a face NPZ, or for `caricli rig`"


def whole_head(face: Face, template: Template, choice: HeadChoice = WHOLE) -> WholeHead:
    """The template in the shape of a face of its topology, with the parts of a head and the hair of the face."""
    own = {field.name: getattr(template, field.name) for field in fields(Template)} | {"vertices": face.vertices}
    return WholeHead(**own, dressed=tuple(face_parts(face, template, choice)), eyes="eyes" in choice.parts)


def whole_face(face: Face, choice: HeadChoice = WHOLE) -> Face:
    """A face with the parts of a head, and its hair, as one mesh: what there is to see of it.

    face: Face; one of the open head's topology gets the parts of this, one with materials has its own already. choice:
    HeadChoice; eyes are put in where it is drawn.
    Returns Face, with what it wears alone. Raises InputError where there are no shoulders or no such teeth for it.
    """
    rig = Rig((), face.mesh, np.zeros((0, *face.vertices.shape), np.float32), face.materials, face.pictures)
    if face.materials is not None:
        if choice.teeth is not None:
            raise InputError(_OWN_TEETH)
        return choose_head(rig, choice).face
    return add_parts(rig, face_parts(face, load_head().template(), choice)).face


def mesh_face(face: Face, template: Template, choice: HeadChoice | None, fine: FineMesh) -> Face:
    """What a mesh file for other programs holds of a face: a head of the parts that are chosen, its eyes among them.

    face: Face of the template's topology. choice: HeadChoice, or None for the skin alone. fine: FineMesh in the shape
    of the face, which is taken for the skin. Eyes are painted where the face has no picture of them.
    Returns Face, with what it wears alone. Raises InputError where there are no shoulders or no such teeth for it.
    """
    skin = finer_face(face, fine)
    if choice is None:
        return skin
    still = np.zeros((0, *skin.vertices.shape), np.float32)
    rig = Rig((), skin.mesh.with_vertices(skin.vertices.astype(np.float32)), still, skin.materials, skin.pictures)
    if "eyes" in choice.parts:
        eyeballs = fit_eyeballs(face.mesh, template.annotation, np.zeros((0, *face.vertices.shape)))
        rig = add_eyeballs(rig, eyeballs, np.random.default_rng(0), face.pictures.eyes)
    return add_parts(rig, face_parts(face, template, choice)).face


def choose_head(rig: Rig, choice: HeadChoice) -> Rig:
    """A rig with its parts, with only those that are chosen, and with shoulders where these are.

    choice: HeadChoice, but for its teeth, which are those that the rig has.
    Returns Rig. Raises InputError where shoulders are chosen and its skin has not the open head's topology.
    """
    if not choice.shoulders:
        return choose_parts(rig, choice)
    skin = choose_parts(rig, BARE)
    shoulders = add_shoulders(skin.mesh, skin.neutral, skin.names, skin.deltas)
    others = [name for name in choice.parts if name != "bust"]
    return add_parts(choose_parts(rig, HeadChoice(others)), [shoulders])
