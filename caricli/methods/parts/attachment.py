"""Teeth, tongue and lashes put into a face and moved with its expressions."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from caricli.data.identities import usual_size
from caricli.errors import InputError
from caricli.methods.parts.behind_teeth import behind_teeth
from caricli.methods.parts.bones import Bone
from caricli.methods.parts.frames import Frames, plain_frames
from caricli.methods.parts.jaw import Jaw
from caricli.methods.parts.lids import Lids
from caricli.methods.parts.pocket import Mouths, Pocket
from caricli.methods.parts.posed import Posed
from caricli.structures import Mesh, Part
from caricli.structures.arkit import Expressions
from caricli.structures.head_choice import Teeth
from caricli.template.head import BasePart, Head, load_head
from caricli.template.head_parts import head_parts, part_lips
from caricli.template.template import FittedParts, Template

POSED = 0.25
"""Weight of expressions: the neutral face of a drawing that laughs keeps some of its laughter."""

NO_TEETH = "expected a skin of the bundled head's topology for --teeth, found another"
"""What is said of a face into which none can be put."""


class Attachment:
    """What holds parts of a template in any face of its topology, prepared once."""

    def __init__(
        self,
        template: Template,
        parts: Sequence[Part],
        frames: Mapping[str, Frames] | None = None,
        actions: np.ndarray | None = None,
    ) -> None:
        """template: the head without expression. parts: in its shape, with what its expressions do to them. frames: by
        names of parts, where more is known of them than their place. actions: (K, V, 3) metres, what the expressions of
        the parts do to the skin."""
        # What parts are held by is weighed in metres: all faces are brought to this height, and parts back from it.
        self.height = template.height
        moves = np.zeros((0, *template.vertices.shape)) if actions is None else actions
        rigid = next((part for part in parts if part.hangs_on == "jaw"), None)
        jaw = None if rigid is None else Jaw(template, rigid, moves)
        lined = template.mask("inner_mouth")[template.faces].all(1).any()
        self.pocket = Pocket(template, template.annotation.regions["inner_mouth"]) if lined else None
        self.holds: list[Bone | Lids] = []
        for part in parts:
            if part.hangs_on == "lids":
                self.holds.append(Lids(template, part))
            else:
                own = (frames or {}).get(part.name) or plain_frames(part)
                self.holds.append(Bone(template, part, own, jaw if part.hangs_on == "jaw" else None))

    def without_lashes(self) -> "Attachment":
        """The same without what hangs on the lids."""
        other = copy(self)
        other.holds = [hold for hold in self.holds if not isinstance(hold, Lids)]
        return other

    def attach(self, mesh: Mesh) -> tuple[Part, ...]:
        """The parts of a face, without expressions. mesh: Mesh of its skin, metres, in the template's topology."""
        return self.animate(mesh, {}, np.zeros((0, *mesh.vertices.shape)))

    def animate(
        self,
        mesh: Mesh,
        expressions: Expressions,
        deltas: np.ndarray,
        given: np.ndarray | None = None,
        teeth: np.ndarray | None = None,
    ) -> tuple[Part, ...]:
        """The parts of a face with expressions.

        mesh: Mesh of its skin, metres, in the template's topology. expressions: K, of what actions they are made.
        deltas: (K, V, 3) metres, what they do to the skin. given: (V, 3) metres, the face with the expression that this
        neutral one was found from, whose lips may have shown teeth; or None. teeth: (2,) metres, of a Face, or None
        where no picture tells.
        """
        size = mesh.height / self.height
        face = Posed(np.asarray(mesh.vertices, float), expressions, np.asarray(deltas, float), given, teeth)
        face = face.sized(1 / size)
        mouths = self._mouths(face)
        parts = tuple(hold.place(face) if isinstance(hold, Lids) else hold.place(face, mouths) for hold in self.holds)
        if teeth is not None and given is None:
            parts = behind_teeth(parts, self.height)
        return tuple(_sized(part, size) for part in parts)

    def let_out(self, mesh: Mesh, expressions: Expressions, deltas: np.ndarray) -> np.ndarray:
        """(K, V, 3) metres, what expressions do to the skin where lips part as far as a tongue needs to come out.

        mesh, expressions, deltas: as in ``animate``; the other expressions stay as they are.
        """
        size = mesh.height / self.height
        face = Posed(np.asarray(mesh.vertices, float), expressions, np.asarray(deltas, float)).sized(1 / size)
        mouths = self._mouths(face)
        opened = face
        for hold in self.holds:
            if isinstance(hold, Bone) and mouths is not None:
                opened = replace(opened, deltas=hold.let_out(opened, mouths))
        # As they were, to the last bit, where nothing is opened.
        return deltas + size * (opened.deltas - face.deltas)

    def _mouths(self, face: Posed) -> Mouths | None:
        return None if self.pocket is None else Mouths(self.pocket, face.neutral, face.names, face.deltas)


def attachment_for(template: Template, teeth: Teeth | None = None) -> Attachment | None:
    """The Attachment of a template's own parts, or of the open head's where it has its topology, else None.

    teeth: how they are modelled, or None for natural ones, or those that it has.
    Raises InputError where teeth are asked for and it has its own, or none can be put in.
    """
    if template.parts is not None:
        if teeth is not None:
            raise InputError(
                f"expected a head without teeth of its own for {teeth} ones, found one whose annotation has them"
            )
        return _own_attachment(template.parts)
    if template.topology_id == open_head_topology():
        return open_head_attachment(teeth or "natural")
    if teeth is not None:
        raise InputError(NO_TEETH)
    return None


def _sized(part: Part, size: float) -> Part:
    """A part that is so many times as large."""
    mesh = part.mesh.with_vertices(size * np.asarray(part.mesh.vertices))
    return replace(part, mesh=mesh, deltas=size * np.asarray(part.deltas))


@lru_cache(maxsize=4)
def _own_attachment(fitted: FittedParts) -> Attachment:
    return Attachment(fitted.head, fitted.parts)


@cache
def open_head_attachment(teeth: Teeth = "natural") -> Attachment:
    """Of the open head in its usual shape."""
    head = load_head()
    skin = _examples(head, head)
    rigid = {name: part for name, part in head.parts.items() if name != "lashes"}
    frames = {name: Frames(part.evaluate(), (skin, _examples(head, part))) for name, part in rigid.items()}
    actions = head.actions.astype(float)
    actions[head.action_names.index("tongueOut")] += part_lips(head.action_names, actions)
    return Attachment(head.template(), head_parts(head, teeth), frames, actions)


def _examples(head: Head, shapes: Head | BasePart) -> np.ndarray:
    """(E, V, 3) how heads differ, in the skin or a part: by changes of usual size, by gender, age and weight."""
    identity = [k for k, name in enumerate(head.change_names) if usual_size(name)]
    sizes = np.array([usual_size(head.change_names[k]) for k in identity])[:, None, None]
    nodes = shapes.phenotype.reshape(-1, *shapes.phenotype.shape[-2:]) - shapes.evaluate()
    ways = [sizes * changes[identity] for changes in (shapes.changes_up, shapes.changes_down)]
    return np.concatenate([*ways, nodes, POSED * shapes.actions])


@cache
def open_head_topology() -> str:
    """The topology of the open head."""
    return load_head().template().topology_id
