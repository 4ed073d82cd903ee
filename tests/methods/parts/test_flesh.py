import numpy as np
import pytest

from caricli.methods.parts.flesh import Flesh, Hide
from caricli.template.head import load_head


@pytest.fixture(scope="module")
def balls(ball):
    """A ball whose top was cut off, closed over the cut and towards its middle."""
    vertices, faces = np.asarray(ball[0], float), np.asarray(ball[1])
    radius = np.linalg.norm(vertices, axis=1).mean()
    cut = faces[(vertices[faces][..., 1] < 0.6 * radius).all(1)]
    hide = Hide(cut)
    return radius, Flesh(hide, vertices[hide.ids]), Flesh(hide, vertices[hide.ids], np.zeros(3))


def ring(radius, height=0.0):
    turns = np.linspace(0, 2 * np.pi, 17)
    return np.column_stack([radius * np.cos(turns), np.full(17, height), radius * np.sin(turns)])


def test_room_is_the_distance_from_the_skin_and_the_way_out_of_the_flesh(balls):
    radius, flesh, _ = balls
    for share in (0.8, 1.2):
        distance, ways = flesh.room(ring(share * radius))
        np.testing.assert_allclose(distance, (share - 1) * radius, atol=0.02 * radius)
        outward = ring(1.0)
        assert ((ways * outward).sum(1) > 0.95).all()


def test_what_it_is_closed_to_says_what_is_in_it(balls):
    radius, over, towards = balls
    top = np.array([[0.0, 0.4 * radius, 0.0]])
    assert over.room(top)[0] < 0 < towards.room(top)[0]


def test_ways_out_are_those_of_what_is_deep_enough(balls):
    radius, flesh, _ = balls
    points = np.concatenate([ring(0.9 * radius), ring(0.99 * radius), ring(1.1 * radius)])
    ways = flesh.ways_out(points, np.full(len(points), 0.05 * radius))
    assert not ways[17:].any()
    np.testing.assert_allclose(np.linalg.norm(points[:17] + ways[:17], axis=1), radius, atol=0.02 * radius)


def test_a_fold_that_covers_what_is_before_another_is_found_where_it_may_be(ball):
    vertices, faces = np.asarray(ball[0], float), np.asarray(ball[1])
    radius = np.linalg.norm(vertices, axis=1).mean()
    skin = np.concatenate([vertices, 1.5 * vertices])
    hide = Hide(np.concatenate([faces, faces + len(vertices)]))
    points = ring(1.1 * radius)
    none = np.zeros(len(points))
    assert not Flesh(hide, skin, np.zeros(3)).ways_out(points, none).any()
    for reach, found in (((0.0, 0.2), True), ((0.05, 0.2), True), ((0.15, 0.2), False), ((0.0, 0.05), False)):
        doubt = (reach[0] * radius, reach[1] * radius)
        assert Flesh(hide, skin, np.zeros(3), doubt).ways_out(points, none).any(1).all() == found


def test_skin_around_deep_eyes_closed_behind_encloses_what_all_of_it_does():
    template = load_head().template()
    usual = np.asarray(template.vertices, float)
    eye = usual[template.region("eyes_left")].mean(0)
    deep = usual - 0.03 * np.exp(-0.5 * (((usual - eye) / [0.03, 0.02, 0.03]) ** 2).sum(1))[:, None] * [0, 0, 1]
    around = np.linalg.norm((usual - eye)[:, :2], axis=1) < 0.05
    hide = Hide(template.faces[(around & (usual[:, 2] > eye[2] - 0.05))[template.faces].all(1)])
    skin = deep[hide.ids]
    near = deep[np.linalg.norm(usual - eye, axis=1) < 0.02]
    points = np.concatenate([near + [0, 0, z] for z in (0.006, 0.003, -0.003, -0.006)])
    truth = Flesh(Hide(template.faces), deep).holds(points)
    assert 0.2 < truth.mean() < 0.8
    np.testing.assert_array_equal(Flesh(hide, skin, hide.behind(skin, 1.0)).holds(points), truth)
    assert (Flesh(hide, skin, deep.mean(0)).holds(points) != truth).any()


def test_points_beside_a_sharp_corner_or_edge_are_ahead_of_whichever_face_is_told():
    base = np.array([[-0.1, 0, -0.1], [0.1, 0, -0.1], [0.1, 0, 0.1], [-0.1, 0, 0.1]])
    faces = np.array([[1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]])
    spire = Flesh(Hide(faces), np.concatenate([base, [[0, 1, 0]]]))
    told = np.arange(4)
    for at, beside in ((spire.skin[4], told), ((spire.skin[0] + spire.skin[4]) / 2, told[[0, 3]])):
        nearest = np.tile(at, (len(beside), 1))
        for normal in spire.face_normals[beside]:
            assert (spire.ahead(nearest + 1e-3 * normal, beside, nearest) > 0).all()
            assert (spire.ahead(nearest - 1e-3 * normal, beside, nearest) < 0).all()
