import numpy as np

from caricli.render.sheets.expression_row import expression_row
from caricli.structures import Rig


def test_expressions_that_a_rig_does_not_have_are_the_neutral_face(head_template):
    mesh = head_template.with_vertices(head_template.vertices.astype(np.float32))
    deltas = np.zeros((1, *mesh.vertices.shape), np.float32)
    deltas[0, :, 1] = np.where(mesh.vertices[:, 1] < np.median(mesh.vertices[:, 1]), -0.02, 0)
    rig = Rig(("long",), mesh, deltas)
    given, long, missing = expression_row(rig, rig.neutral, ("long", "missing"), 48)
    assert given.shape == (48, 48, 3)
    assert np.array_equal(given, missing) and not np.array_equal(given, long)
