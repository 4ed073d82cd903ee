"""What is on and in a face beside its skin."""

import numpy as np

from caricli.errors import InputError
from caricli.methods.parts.attachment import NO_TEETH, Attachment, attachment_for
from caricli.methods.parts.close_neck import close_neck
from caricli.methods.parts.shoulders import NO_SHOULDERS, add_shoulders
from caricli.structures import Face, HeadChoice, Mesh, Part
from caricli.structures.arkit import Expressions
from caricli.structures.head_choice import WHOLE
from caricli.template.template import Template

_ATTACHED = {"teeth", "tongue", "lashes"}


def face_parts(
    face: Face,
    template: Mesh,
    choice: HeadChoice = WHOLE,
    expressions: Expressions | None = None,
    deltas: np.ndarray | None = None,
    given: np.ndarray | None = None,
) -> list[Part]:
    """The parts of a head on a face, what closes its neck, and the hair that it has.

    face: Face. template: of its topology; where it is a Template that knows parts, or has the topology of the open
    head, these are attached. choice: HeadChoice. expressions, deltas: K, of what actions they are made, and (K, V, 3)
    metres, what they do to the face. given: (V, 3) metres, the face with the expression that this neutral one was found
    from; or None.
    Returns Parts, the hair last. Raises InputError where shoulders or teeth are chosen and it has not the open head's
    topology, and where teeth are chosen for a template that brings its own.
    """
    parts: list[Part] = []
    if isinstance(template, Template) and template.topology_id == face.mesh.topology_id:
        expressions = expressions or {}
        moves = np.zeros((0, *face.vertices.shape)) if deltas is None else deltas
        attachment = chosen_attachment(template, choice)
        parts = [] if attachment is None else [*attachment.animate(face.mesh, expressions, moves, given, face.teeth)]
        close = add_shoulders if choice.shoulders else close_neck
        neck = close(template, face.vertices, tuple(expressions), moves)
        parts += [] if neck is None else [neck]
    elif choice.shoulders or choice.teeth is not None:
        raise InputError(NO_SHOULDERS if choice.shoulders else NO_TEETH)
    if face.hair is not None:
        parts.append(face.hair.part)
    return [part for part in parts if choice.takes(part.materials)]


def chosen_attachment(template: Template, choice: HeadChoice) -> Attachment | None:
    """The Attachment of a template's parts, which is kept for later faces, or None where none is chosen.

    Raises InputError as `face_parts`.
    """
    return attachment_for(template, choice.teeth) if _ATTACHED & {*choice.parts} else None


def let_tongue_out(
    mesh: Mesh, template: Mesh, choice: HeadChoice, expressions: Expressions, deltas: np.ndarray
) -> np.ndarray:
    """(K, V, 3) metres, what expressions do to a face that wears a tongue: its lips part as far as that needs.

    mesh: Mesh of the face. template, choice, expressions, deltas: as in ``face_parts``.
    """
    attachment = None
    if "tongue" in choice.parts and isinstance(template, Template) and template.topology_id == mesh.topology_id:
        attachment = attachment_for(template, choice.teeth)
    return deltas if attachment is None else attachment.let_out(mesh, expressions, deltas)
