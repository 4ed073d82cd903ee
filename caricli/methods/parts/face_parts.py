"""What is on and in a face beside its skin."""

from collections.abc import Collection, Sequence

import numpy as np

from caricli.errors import InputError
from caricli.methods.parts.attachment import attachment_for
from caricli.methods.parts.close_neck import close_neck
from caricli.methods.parts.shoulders import NO_SHOULDERS, add_shoulders
from caricli.structures import Face, Mesh, Part
from caricli.structures.materials import HEAD_PARTS, SHOULDERS, materials_of
from caricli.template.template import Template

_ATTACHED = {"teeth", "tongue", "lashes"}


def face_parts(
    face: Face,
    template: Mesh,
    chosen: Collection[str] = tuple(HEAD_PARTS),
    names: Sequence[str] = (),
    deltas: np.ndarray | None = None,
) -> list[Part]:
    """The parts of a head on a face, what closes its neck, and the hair that it has.

    face: Face. template: of its topology; where it is a Template that knows parts, or has the topology of the open
    head, these are attached. chosen: some of ``HEAD_PARTS``, and ``SHOULDERS``. names, deltas: K expressions and
    (K, V, 3) metres, what they do to the face.
    Returns Parts, the hair last. Raises InputError where shoulders are chosen and it has not the open head's topology.
    """
    parts: list[Part] = []
    if isinstance(template, Template) and template.topology_id == face.mesh.topology_id:
        moves = np.zeros((0, *face.vertices.shape)) if deltas is None else deltas
        attachment = attachment_for(template) if _ATTACHED & {*chosen} else None
        parts = [] if attachment is None else [*attachment.animate(face.mesh, names, moves)]
        close = add_shoulders if SHOULDERS in chosen else close_neck
        neck = close(template, face.vertices, names, moves)
        parts += [] if neck is None else [neck]
    elif SHOULDERS in chosen:
        raise InputError(NO_SHOULDERS)
    if face.hair is not None:
        parts.append(face.hair.part)
    return [part for part in parts if np.isin(part.materials, materials_of(chosen)).all()]
