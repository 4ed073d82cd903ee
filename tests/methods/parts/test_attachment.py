import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.methods.parts.attachment import attachment_for, open_head_attachment
from caricli.structures import Material, Mesh
from caricli.template.head import load_head
from caricli.template.head_parts import head_parts


@pytest.fixture(scope="module")
def head():
    return load_head()


@pytest.fixture(scope="module")
def template(head):
    return head.template()


def by_name(parts):
    return {part.name: part for part in parts}


def test_on_the_template_parts_are_where_the_template_has_them(head, template):
    parts = open_head_attachment().attach(template)
    assert [part.name for part in parts] == ["teeth_upper", "teeth_lower", "tongue", "lashes"]
    for part, own in zip(parts, head_parts(head), strict=True):
        assert np.abs(part.mesh.vertices - own.mesh.vertices).max() < 1e-9
        assert part.names == () and part.deltas.shape == (0, len(part.mesh.vertices), 3)
        assert part.mesh.uvs is not None


def test_they_go_wherever_the_head_goes(template):
    turn = Rotation.from_rotvec([0.3, -0.4, 1.0]).as_matrix()
    moved = template.with_vertices(1.7 * template.vertices @ turn.T + [0.1, 0.2, 0.3])
    assert moved.parts == ()
    pairs = zip(open_head_attachment().attach(template), attachment_for(template).attach(moved), strict=True)
    for before, after in pairs:
        expected = 1.7 * before.mesh.vertices @ turn.T + [0.1, 0.2, 0.3]
        assert np.abs(after.mesh.vertices - expected).max() < 1e-9


def test_expressions_move_bone_rigidly_and_the_tongue_comes_out(head, template):
    parts = by_name(open_head_attachment().animate(template, head.action_names, head.actions))
    names = list(head.action_names)
    assert not parts["teeth_upper"].deltas.any()
    for name in ("teeth_lower", "tongue"):
        start = parts[name].mesh.vertices
        open_ = start + parts[name].deltas[names.index("jawOpen")]
        lengths = [np.linalg.norm(np.diff(shape[::7], axis=0), axis=1) for shape in (start, open_)]
        assert np.allclose(*lengths) and (open_[:, 1].mean() - start[:, 1].mean()) < -0.01
    tip = parts["tongue"].mesh.vertices[:, 2].argmax()
    assert parts["tongue"].deltas[names.index("tongueOut"), tip, 2] > 0.015
    shut = parts["lashes"].deltas[names.index("eyeBlinkLeft")]
    left = parts["lashes"].mesh.vertices[:, 0] > 0
    assert shut[left, 1].min() < -0.008 and np.abs(shut[~left]).max() < 1e-3


def test_materials_say_what_is_tooth_and_what_gum(head):
    parts = by_name(head_parts(head))
    assert set(parts["teeth_lower"].materials) == {Material.TEETH, Material.GUMS}
    assert set(parts["lashes"].materials) == {Material.LASHES}


def test_another_topology_has_none(template):
    other = type(template)(
        template.vertices, template.polygons[:, ::-1].copy(), annotation=template.annotation
    )  # turned inside out
    assert attachment_for(other) is None
    assert isinstance(template, Mesh)
