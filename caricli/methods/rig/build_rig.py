"""A rig from a neutral face: expressions, eyes, pictures, any resolution."""

import numpy as np

from caricli.geometry.similarity import similarity
from caricli.methods.rig.add_eyeballs import add_eyeballs, fit_eyeballs
from caricli.methods.rig.measure_rig import measure_rig
from caricli.structures import Rig
from caricli.template.fine_mesh import fine_mesh


def build_rig(mesh, templates, deltas, generator, levels=0, eyeballs=True, texture=None, eyes=None):
    """Give a face its expressions, put eyes into it and split its polygons.

    mesh: Template in the shape of the neutral face; its annotation may be None, then there are no eyes. templates:
    ExpressionTemplates of the same faces. deltas: (K, V, 3), what those do to this face. generator: numpy Generator, of
    the picture of the eyes. levels: how often polygons are split, linearly. texture, eyes: (H, W, 3) uint8, pictures of
    skin and eyes, or None.
    Returns Rig, RigMeasures and a list of Eyeball. Raises NumericsError for triangles without area.
    """
    neutral = mesh.vertices
    balls = fit_eyeballs(neutral, deltas, mesh) if eyeballs and mesh.annotation is not None else []
    scale = similarity(templates.neutral, neutral)[0]
    measures = measure_rig(deltas, neutral, templates, mesh.annotation, scale, balls)
    fine = fine_mesh(mesh, levels)
    finer = np.stack([fine.weights @ delta for delta in deltas])
    shaped = fine.mesh.with_vertices((fine.weights @ neutral).astype(np.float32))
    rig = Rig(templates.names, shaped, finer.astype(np.float32), texture=texture)
    return add_eyeballs(rig, balls, generator, eyes), measures, balls
