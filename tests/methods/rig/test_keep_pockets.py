import numpy as np
import pytest

from caricli.methods.rig.expression_templates import ExpressionTemplates
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.keep_pockets import keep_pockets
from caricli.structures import Mesh


@pytest.fixture(scope="module")
def templates(head, head_template):
    """Three expressions of the mouth."""
    full = head_expressions(head, head_template)
    order = [full.names.index(name) for name in ("jawOpen", "mouthClose", "mouthFunnel")]
    return ExpressionTemplates(tuple(full.names[k] for k in order), full.mesh, full.deltas[order])


def pressed(templates):
    """Displacements whose open jaw presses the skin above the lip in, as far as behind the mouth's cavity."""
    mesh = templates.mesh
    deltas = np.array(templates.deltas)
    nose = mesh.vertices[mesh.annotation.landmarks[33]]
    skin = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.region("inner_mouth"))
    near = np.exp(-(((mesh.vertices[skin] - nose) / 0.012) ** 2).sum(1))
    deltas[0, skin, 2] -= 0.03 * near
    return deltas


def coming_out(templates, shape):
    """Metres by which the pockets of a shape would have to move to be behind the skin."""
    return np.abs(shape - templates.mesh.cavities.withdraw(shape)).max()


def test_expressions_that_bring_nothing_out_stay_as_they_are(templates):
    assert np.array_equal(keep_pockets(templates, templates.neutral, templates.deltas), templates.deltas)


def test_a_cavity_stays_behind_the_skin_that_moves(templates):
    deltas = pressed(templates)
    before = deltas.copy()
    kept = keep_pockets(templates, templates.neutral, deltas)
    assert np.array_equal(deltas, before)
    for shape, usual in ((deltas[0], kept[0]), (deltas[:2].sum(0), kept[:2].sum(0))):
        assert coming_out(templates, templates.neutral + shape) > 0.005
        assert coming_out(templates, templates.neutral + usual) < 1e-9
    skin = np.setdiff1d(np.arange(len(templates.neutral)), templates.mesh.region("inner_mouth"))
    assert np.array_equal(kept[:, skin], deltas[:, skin]) and np.array_equal(kept[2], deltas[2])


def test_the_size_of_the_face_does_not_matter(templates):
    deltas = pressed(templates)
    kept = keep_pockets(templates, templates.neutral, deltas)
    np.testing.assert_allclose(keep_pockets(templates, 4 * templates.neutral, 4 * deltas), 4 * kept, atol=1e-6)


def test_without_names_nothing_is_known_of_pockets(templates):
    mesh = Mesh(templates.mesh.vertices, templates.mesh.polygons)
    bare = ExpressionTemplates(templates.names, mesh, templates.deltas)
    deltas = pressed(templates)
    assert keep_pockets(bare, bare.neutral, deltas) is deltas
