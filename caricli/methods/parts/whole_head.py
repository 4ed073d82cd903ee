"""A face as a whole head."""

from collections.abc import Collection
from dataclasses import fields

import numpy as np

from caricli.errors import InputError
from caricli.methods.parts.face_parts import face_parts
from caricli.methods.rig.add_parts import add_parts, choose_parts
from caricli.structures import Face, Rig
from caricli.structures.materials import HEAD_PARTS, SHOULDERS
from caricli.template.head import load_head
from caricli.template.template import Template, WholeHead


def whole_head(face: Face, template: Template) -> WholeHead:
    """The template in the shape of a face of its topology, with the parts of a head and the hair of the face."""
    own = {field.name: getattr(template, field.name) for field in fields(Template)} | {"vertices": face.vertices}
    return WholeHead(**own, dressed=tuple(face_parts(face, template)))


def whole_face(face: Face, chosen: Collection[str] = tuple(HEAD_PARTS)) -> Face:
    """A face with the parts of a head, and its hair, as one mesh: what there is to see of it.

    face: Face; one of the open head's topology gets the parts of this, one with materials has its own already. chosen:
    some of ``HEAD_PARTS``, and ``SHOULDERS``; eyes are put in where it is drawn.
    Returns Face, with what it wears alone. Raises InputError where there are no shoulders for it.
    """
    rig = Rig((), face.mesh, np.zeros((0, *face.vertices.shape), np.float32), face.materials, face.pictures)
    if face.materials is not None:
        if SHOULDERS in chosen:
            raise InputError(
                "has its parts already; --bust is for a skin alone, such as a face NPZ, or for `caricli rig`"
            )
        return choose_parts(rig, chosen).face
    head = load_head()
    same = len(face.vertices) == head.actions.shape[1]
    return add_parts(rig, face_parts(face, head.template() if same else face.mesh, chosen)).face
