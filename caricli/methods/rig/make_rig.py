"""A rig from a neutral face: expressions, contacts, eyes, pictures, any resolution."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from caricli.geometry.alignment.require_upright import require_upright
from caricli.methods.hair.sink_rim import sink_rim
from caricli.methods.parts.close_neck import with_neck
from caricli.methods.parts.face_parts import face_parts, let_tongue_out
from caricli.methods.rig.add_eyeballs import Eyeball, add_eyeballs, fit_eyeballs
from caricli.methods.rig.add_parts import add_parts
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.head_expressions import open_head_expressions
from caricli.methods.rig.keep_pockets import keep_pockets
from caricli.methods.rig.measure_rig import RigMeasures, measure_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Face, HeadChoice, Mesh, Part, Pictures, Rig
from caricli.structures.arkit import action_codes
from caricli.structures.head_choice import BARE, WHOLE
from caricli.template.fine_mesh import FineMesh, fine_mesh


@dataclass(frozen=True)
class RigSettings:
    """What a rig is made of.

    levels: how often polygons of the face are split, linearly.
    head: HeadChoice: what is put into and on the face, where the templates know it, beside the skin.
    seed: of the picture of the eyes, where none is given.
    """

    levels: int = 0
    head: HeadChoice = WHOLE
    seed: int = 0


@dataclass(frozen=True, eq=False)
class RigResult:
    """A rig with what was measured on the way.

    rig: Rig.
    measures: RigMeasures of its expressions.
    eyeballs: those that it has.
    fine: FineMesh of the face, whose vertices come first in the rig.
    dress: makes the parts of a Face, whose vertices come last in the rig; ``given`` of it is the laugh, if any, that
    tells how far teeth show in the neutral face.
    """

    rig: Rig
    measures: RigMeasures
    eyeballs: list[Eyeball]
    fine: FineMesh
    dress: Callable[..., list[Part]]

    def shaped(self, face: Face) -> np.ndarray:
        """(W, 3) the vertices of the rig with the face in another shape, metres, its teeth those of the neutral one."""
        return self._wearing(face, self.dress(face))

    def as_given(self, face: Face) -> np.ndarray:
        """(W, 3) the same with the teeth of the face itself, as long as its picture shows them."""
        return self._wearing(face, self.dress(face, given=None))

    def _wearing(self, face: Face, parts: list[Part]) -> np.ndarray:
        skin = self.fine.shaped(face.vertices).mesh.vertices
        worn = np.concatenate([np.zeros((0, 3)), *(part.mesh.vertices for part in parts)])
        eyes = self.rig.neutral[len(skin) : len(self.rig.neutral) - len(worn)]
        return np.concatenate([skin, eyes, worn])


def make_rig(
    mesh: Mesh,
    templates: ExpressionTemplates | None = None,
    settings: RigSettings = RigSettings(),  # noqa: B008 (frozen)
    pictures: Pictures = Pictures(),  # noqa: B008 (frozen)
    deltas: np.ndarray | None = None,
    given: Face | None = None,
) -> RigResult:
    """Give a neutral face expressions, put eyes, teeth and what else belongs to a head into it, split its polygons.

    mesh: Mesh of the face, metres, of the templates' topology. templates: ExpressionTemplates; None for the 52 of ARKit
    on the open head, whose topology the bundled models have. deltas: (K, V, 3) metres, what their expressions do to the
    face; None for deformation transfer, lids and lips meeting as they do on the templates. A tongue that is put in may
    part the lips farther than they. given: Face that the neutral one was found from, whose hair it wears, and whose
    laugh tells how far its teeth show; where they are the same, so does its picture.
    Raises InputError for another topology, and for a face that looks elsewhere than its templates and is to wear more
    than its skin; NumericsError for triangles without area.
    """
    templates = templates or open_head_expressions()
    templates.require_topology(mesh)
    if {*settings.head.parts} != {*BARE.parts}:
        # Eyes look to +z, however the face stands.
        require_upright(mesh.vertices, templates.neutral)
    deltas = transfer_rig(templates, mesh.vertices) if deltas is None else deltas
    deltas = let_tongue_out(mesh, templates.mesh, settings.head, templates.expressions, deltas)
    deltas = keep_pockets(templates, mesh.vertices, deltas)
    annotation = templates.annotation if "eyes" in settings.head.parts else None
    eyeballs = [] if annotation is None else fit_eyeballs(mesh, annotation, deltas)
    measures = measure_rig(mesh.vertices, deltas, templates, eyeballs)
    fine = fine_mesh(mesh, settings.levels)
    finer = np.stack([fine.weights @ delta for delta in deltas])
    shape = fine.mesh.with_vertices((fine.weights @ mesh.vertices).astype(np.float32))
    worn = with_neck(pictures, mesh, templates.mesh) if "bust" in settings.head.parts else pictures
    actions = None if templates.weights is None else action_codes(templates.weights)
    rig = Rig(templates.names, shape, finer.astype(np.float32), pictures=replace(worn, eyes=None), actions=actions)
    rig = add_eyeballs(rig, eyeballs, np.random.default_rng(settings.seed), pictures.eyes)
    hair = None if given is None else given.with_vertices(mesh.vertices).hair
    hair = None if hair is None else sink_rim(hair, mesh, deltas)
    laugh = None if given is None or np.array_equal(given.vertices, mesh.vertices) else given.vertices
    teeth = None if given is None else given.teeth
    dress = partial(face_parts, template=templates.mesh, choice=settings.head, given=laugh)
    rig = add_parts(rig, dress(Face(mesh, hair=hair, teeth=teeth), expressions=templates.expressions, deltas=deltas))
    return RigResult(rig, measures, eyeballs, fine, dress)
