"""A rig from a neutral face: expressions, contacts, eyes, pictures, any resolution."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.methods.rig.add_eyeballs import Eyeball, add_eyeballs, fit_eyeballs
from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.head_expressions import open_head_expressions
from caricli.methods.rig.measure_rig import RigMeasures, measure_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Mesh, Pictures, Rig
from caricli.template.fine_mesh import FineMesh, fine_mesh


@dataclass(frozen=True)
class RigSettings:
    """What a rig is made of.

    levels: how often polygons are split, linearly.
    eyeballs: whether eyes are put into the sockets, where the templates know them.
    seed: of the picture of the eyes, where none is given.
    """

    levels: int = 0
    eyeballs: bool = True
    seed: int = 0


@dataclass(frozen=True, eq=False)
class RigResult:
    """A rig with what was measured on the way.

    rig: Rig.
    measures: RigMeasures of its expressions.
    eyeballs: those that it has.
    fine: FineMesh of the face, whose vertices come first in the rig.
    """

    rig: Rig
    measures: RigMeasures
    eyeballs: list[Eyeball]
    fine: FineMesh

    def shaped(self, vertices: np.ndarray) -> np.ndarray:
        """(W, 3) the vertices of the rig with the face in another shape (V, 3), metres."""
        shape = np.array(self.rig.neutral)
        face = self.fine.shaped(vertices).mesh.vertices
        shape[: len(face)] = face
        return shape


def make_rig(
    mesh: Mesh,
    templates: ExpressionTemplates | None = None,
    settings: RigSettings = RigSettings(),  # noqa: B008 (frozen)
    pictures: Pictures = Pictures(),  # noqa: B008 (frozen)
    deltas: np.ndarray | None = None,
) -> RigResult:
    """Give a neutral face expressions, put eyes into it and split its polygons.

    mesh: Mesh of the face, metres, of the templates' topology. templates: ExpressionTemplates; None for the 52 of ARKit
    on the open head, whose topology the bundled models have. deltas: (K, V, 3) metres, what their expressions do to the
    face; None for deformation transfer, lids and lips meeting as they do on the templates.
    Raises InputError for another topology, NumericsError for triangles without area.
    """
    templates = templates or open_head_expressions()
    templates.require_topology(mesh)
    deltas = transfer_rig(templates, mesh.vertices) if deltas is None else deltas
    annotation = templates.annotation if settings.eyeballs else None
    eyeballs = [] if annotation is None else fit_eyeballs(mesh, annotation, deltas)
    measures = measure_rig(mesh.vertices, deltas, templates, eyeballs)
    fine = fine_mesh(mesh, settings.levels)
    finer = np.stack([fine.weights @ delta for delta in deltas])
    shape = fine.mesh.with_vertices((fine.weights @ mesh.vertices).astype(np.float32))
    rig = Rig(templates.names, shape, finer.astype(np.float32), pictures=replace(pictures, eyes=None))
    rig = add_eyeballs(rig, eyeballs, np.random.default_rng(settings.seed), pictures.eyes)
    return RigResult(rig, measures, eyeballs, fine)
