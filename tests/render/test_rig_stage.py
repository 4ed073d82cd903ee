from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.backdrop import PAPER, backdrop, on_backdrop
from caricli.render.rig_stage import RigStage
from caricli.render.shade import shade
from caricli.structures import Material, Mesh, Pictures, Rig


@pytest.fixture(scope="module")
def rig(sphere):
    """A ball of skin with a smaller ball in front of it, an eye, painted red on its left and blue on its right."""
    vertices, faces = sphere
    points = np.concatenate([0.1 * vertices, 0.03 * vertices + [0, 0, 0.11]]).astype(np.float32)
    both = np.concatenate([faces, faces + len(vertices)])
    uvs = np.stack([0.5 + 0.5 * points[:, 0] / 0.03, 0.5 + 0.5 * points[:, 1] / 0.03], 1)
    image = np.zeros((16, 16, 3), np.uint8)
    image[:, :8], image[:, 8:] = (220, 20, 20), (20, 20, 220)
    materials = np.repeat([Material.SKIN, Material.EYE], len(faces)).astype(np.int32)
    deltas = np.zeros((1, *points.shape), np.float32)
    return Rig(("still",), Mesh(points, both, uvs, both), deltas, materials, Pictures(eyes=image))


def test_eyes_have_their_picture_and_skin_its_own_colour(rig):
    picture = RigStage(rig, "front", 96).picture(rig.neutral).astype(int)
    assert picture.shape == (96, 96, 3) and (picture[0, 0] == PAPER).all()
    left, right, skin = picture[48, 42], picture[48, 53], picture[48, 25]
    assert left[0] > left[2] + 80 and right[2] > right[0] + 80
    assert skin[0] > skin[1] > skin[2] > 30


def test_a_picture_has_its_top_row_at_the_top(rig):
    image = np.zeros((16, 16, 3), np.uint8)
    image[:8], image[8:] = (220, 20, 20), (20, 20, 220)
    picture = RigStage(replace(rig, pictures=Pictures(eyes=image)), "front", 96).picture(rig.neutral).astype(int)
    assert picture[42, 48, 0] > picture[42, 48, 2] + 80 and picture[54, 48, 2] > picture[54, 48, 0] + 80


def test_the_camera_does_not_follow_the_frame(rig):
    moved = rig.neutral + [0.02, 0, 0]
    before, after = (RigStage(rig, "front", 96).picture(v).astype(int) for v in (rig.neutral, moved))
    shift = 0.02 * 0.82 * 96 / np.ptp(rig.neutral[:, :2], axis=0).max()
    drawn = [(picture != backdrop(96, 96)).any(2).any(0).nonzero()[0] for picture in (before, after)]
    assert abs((drawn[1][0] - drawn[0][0]) - shift) <= 1.5


def test_views_turn_the_head(rig):
    profile = RigStage(rig, "profile", 96).picture(rig.neutral)
    drawn = (profile != backdrop(96, 96)).any(2).any(0).nonzero()[0]
    # The eye sticks out to the left of the picture.
    assert 48 - drawn[0] > drawn[-1] - 47 - 1 and not np.array_equal(
        profile, RigStage(rig, "front", 96).picture(rig.neutral)
    )


def test_rigs_without_materials_or_pictures_are_drawn_plainly(rig):
    flat = Mesh(rig.neutral, rig.mesh.polygons)
    for bare in (
        replace(rig, materials=None, mesh=flat, pictures=Pictures()),
        replace(rig, mesh=flat),
        replace(rig, pictures=Pictures(rig.pictures.skin)),
    ):
        picture = RigStage(bare, "front", 64).picture(bare.neutral).astype(int)
        colour = picture[32, 32]
        assert colour.min() > 60 and (colour[0] >= colour[2]).all()


def test_the_rig_and_the_vertices_stay_as_they_are(rig):
    vertices = rig.neutral.copy()
    RigStage(rig, "front", 32).picture(vertices)
    np.testing.assert_array_equal(vertices, rig.neutral)


def test_unknown_views_and_other_meshes_are_refused(rig):
    with pytest.raises(InputError, match="no view is called 'back'"):
        RigStage(rig, "back", 32).picture(rig.neutral)
    with pytest.raises(InputError, match="needs vertices of shape"):
        RigStage(rig, "front", 32).picture(rig.neutral[:-1])


def test_what_comes_out_of_hiding_is_drawn_as_if_it_had_never_hidden(sphere):
    vertices, faces = sphere
    count = len(vertices)
    points = np.concatenate([0.1 * vertices, 0.04 * vertices]).astype(np.float32)
    deltas = np.zeros((1, *points.shape), np.float32)
    deltas[0, count:] = [0, 0, 0.2]
    hidden = Rig(("out",), Mesh(points, np.concatenate([faces, faces + count])), deltas)
    shape = hidden.shape("out")
    picture = RigStage(hidden, "front", 96).picture(shape).astype(int)
    assert (
        np.abs(
            picture[42:55, 42:55]
            - RigStage(replace(hidden, mesh=hidden.mesh.with_vertices(shape)), "front", 96)
            .picture(shape)
            .astype(int)[42:55, 42:55]
        ).max()
        <= 2
    )
    assert picture[48, 48].min() > 40


def test_what_is_in_a_fold_at_rest_is_not_in_its_shade_when_it_comes_out():
    x, y = np.meshgrid(np.linspace(-1, 1, 61), np.linspace(-1, 1, 61))
    fold = np.stack([x, y, -0.3 * np.exp(-40 * y**2)], -1).reshape(-1, 3).astype(np.float32)
    k = np.arange(61 * 61).reshape(61, 61)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
    deltas = np.zeros((1, *fold.shape), np.float32)
    deltas[0, :, 2] = -fold[:, 2]
    rig = Rig(("flat",), Mesh(fold, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])), deltas)
    folded, flat = (RigStage(rig, "front", 96).picture(rig.neutral + w * deltas[0]).astype(int) for w in (0, 1))
    assert folded[40:56, 48].min() < flat[30, 48].min() - 40
    assert np.abs(flat[30:66, 48] - flat[30, 48]).max() < 25


def test_what_stays_in_the_dark_does_not_look_around_again(rig, monkeypatch):
    """The ball is dark around the smaller one in front of it, wherever both are."""
    looked = []

    def sky_visibility(vertices, faces, normals, ids, directions):
        looked.append(len(ids))
        return np.ones((len(ids), len(directions)), np.float32)

    stage = RigStage(rig, "front", 96)
    assert (stage.hidden & stage.shown).any()
    monkeypatch.setattr("caricli.render.shade.sky_visibility", sky_visibility)
    stage.picture(rig.neutral)
    stage.picture(rig.neutral + [0.02, 0, 0])
    assert looked[0] == 0 < looked[1]


def test_many_frames_are_those_that_come_one_by_one_though_each_is_overwritten(rig):
    stage = RigStage(rig, "front", 48)
    shapes = [rig.neutral + [0.01 * k, 0, 0] for k in range(6)]

    def frames():
        buffer = np.empty_like(shapes[0])
        for shape in shapes:
            buffer[:] = shape
            yield buffer

    for picture, shape in zip(stage.pictures(frames()), shapes, strict=True):
        np.testing.assert_array_equal(picture, stage.picture(shape))


def _drawn_by(stage, shape):
    """A frame as `shade` draws it by itself, that looks around anew."""
    look = replace(stage.look, visibility=None, key=None, rotation=None)
    points = stage.scale * shape @ stage.rotation.T + stage.shift
    return on_backdrop(shade(points, stage.rig.faces, stage.size, stage.size, look)).astype(int)


@pytest.mark.parametrize("view", ["three-quarter", "profile-right"])
def test_light_comes_from_where_it_does_in_every_picture_of_any_view(rig, view):
    stage = RigStage(rig, view, 96)
    apart = np.abs(stage.picture(rig.neutral).astype(int) - _drawn_by(stage, rig.neutral))
    assert apart.mean() < 0.2 and np.percentile(apart, 99.5) <= 8


@pytest.mark.parametrize(("view", "way"), [("three-quarter", -1), ("three-quarter-right", 1)])
def test_a_view_shows_the_face_on_the_side_that_it_is_called_after(rig, view, way):
    picture = RigStage(rig, view, 96).picture(rig.neutral).astype(int)
    painted = np.ptp(picture, axis=2) > 120
    assert way * (np.nonzero(painted)[1].mean() - 47.5) > 10


@pytest.mark.parametrize("axis", [0, 1])
def test_all_of_a_long_rig_is_in_the_picture(rig, axis):
    factors = np.where(np.arange(3) == axis, 2.0, 1.0)
    longer = replace(rig, mesh=rig.mesh.with_vertices((rig.neutral * factors).astype(np.float32)))
    drawn = (RigStage(longer, "front", 96).picture(longer.neutral) != backdrop(96, 96)).any(2)
    extents = [np.ptp(places) + 1 for places in np.nonzero(drawn)][::-1]
    assert extents[axis] == pytest.approx(0.82 * 96, abs=2) and extents[1 - axis] == pytest.approx(0.41 * 96, abs=2)
    assert np.abs(np.argwhere(drawn).mean(0) - 47.5).max() < 1


def _with_skin(rig, image):
    return replace(rig, pictures=Pictures(image, rig.pictures.eyes))


def test_frames_have_their_own_skin_where_they_are_given_one(rig):
    colours = np.array([(220, 20, 20), (20, 200, 20), (20, 20, 220)], np.uint8)
    red, green, blue = (np.tile(colour, (16, 16, 1)) for colour in colours)
    stage = RigStage(_with_skin(rig, red), "front", 96)
    assert stage.picture(rig.neutral)[48, 25].argmax() == 0
    assert stage.picture(rig.neutral, green)[48, 25].argmax() == 1
    painted = stage.pictures([rig.neutral] * 3, [red, green, blue].__getitem__)
    assert [picture[48, 25].argmax() for picture in painted] == [0, 1, 2]


def test_materials_without_a_picture_are_as_plain_as_their_finish(rig):
    cloth = replace(rig, materials=np.full_like(rig.materials, Material.CLOTH), pictures=Pictures())
    skin, blue = (RigStage(each, "front", 48).picture(rig.neutral)[24, 12].astype(int) for each in (rig, cloth))
    assert skin[0] > skin[2] + 20 and blue[2] > blue[0] + 10


def test_hair_is_shaded_as_it_is_combed(rig, monkeypatch):
    def combed(mesh, materials):
        return SimpleNamespace(normals=lambda own: np.tile([0, 0, 1.0], (len(own), 1)), shine=np.ones(len(rig.neutral)))

    usual = RigStage(rig, "front", 96).picture(rig.neutral)[30:66, 14:34].mean(2)
    monkeypatch.setattr("caricli.render.rig_stage.combed_hair", combed)
    stage = RigStage(rig, "front", 96)
    assert stage.look.hair is not None
    assert stage.picture(rig.neutral)[30:66, 14:34].mean(2).std() < 0.9 * usual.std()


def test_vertices_without_triangles_change_no_picture(rig):
    mesh = rig.mesh
    stray = np.vstack([mesh.vertices, [[5, 5, 5]]]).astype(np.float32)
    more = Rig(
        rig.names,
        Mesh(stray, mesh.faces, mesh.uvs, mesh.uv_faces),
        np.zeros((1, *stray.shape), np.float32),
        rig.materials,
        rig.pictures,
    )
    picture = RigStage(rig, "front", 64).picture(rig.neutral)
    np.testing.assert_array_equal(RigStage(more, "front", 64).picture(more.neutral), picture)
