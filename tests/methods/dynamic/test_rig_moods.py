from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid, face_texels
from caricli.methods.dynamic.dress_texture import ChangedTexture
from caricli.methods.dynamic.rig_moods import MoodPainter, expression_codes
from caricli.models.texture.config import TextureSize
from caricli.models.texture.model import TextureModel
from caricli.models.texture.networks import TextureNetwork
from caricli.structures import Camera, Depiction, Mesh, Pictures, Rig
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.texture_change import TextureChange
from caricli.template.chart import face_chart

SIDE = 32
NAMES = ("jawOpen", "browInnerUp")
CAMERA = Camera(1400.0, np.diag([1.0, -1, -1]), np.array([200.0, 400.0]))


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), SIDE)


@pytest.fixture(scope="module")
def picture():
    return np.random.default_rng(0).integers(60, 200, (256, 256, 3), np.uint8)


@pytest.fixture(scope="module")
def rig(head, head_template):
    deltas = [head.evaluate(actions={name: 1}) - head_template.vertices for name in NAMES]
    return Rig(NAMES, head_template.with_vertices(head_template.vertices), np.array(deltas, np.float32))


def model(topology_id, offset=0.0):
    """A network that adds an offset everywhere."""
    network = TextureNetwork(TextureSize(4, 4), torch.Generator().manual_seed(0))
    network.colour.last.bias.data[3 * 4 :] = offset
    network.where.last.bias.data[:] = 20.0
    return TextureModel(network, SIDE, topology_id)


def worn(head, rig, picture, **actions):
    """The rig with a picture that shows actions."""
    depiction = Depiction(CAMERA, head.evaluate(actions=actions).astype(np.float32))
    return replace(rig, pictures=Pictures(skin=picture), depiction=depiction)


def painter(head, template, rig, picture, **actions):
    return MoodPainter(worn(head, rig, picture, **actions), template, model(template.topology_id, 0.2))


def test_a_change_stays_on_the_face_and_fades_at_its_border(head_template, grid, picture):
    change = TextureChange(np.zeros((SIDE, SIDE, 3)), np.full((SIDE, SIDE, 3), 0.2))
    painted = ChangedTexture(picture, head_template, grid).paint(change)
    moved = painted.astype(int) - picture
    face = face_texels(head_template, grid, 256)
    assert (moved[~face] == 0).all() and (moved >= 0).all() and moved.max() == 51
    assert (moved[face] == 51).mean() > 0.6 and (moved[face] < 25).any()


def test_fine_strokes_stay_where_colours_change_slowly(head_template, grid, picture):
    change = TextureChange(np.full((SIDE, SIDE, 3), -0.25), np.zeros((SIDE, SIDE, 3)))
    painted = ChangedTexture(picture, head_template, grid).paint(change)
    face = face_texels(head_template, grid, 256)
    inside = (painted == np.rint(0.75 * picture)).all(-1) & face
    assert inside.sum() > 0.5 * face.sum()


def test_a_face_that_lies_beside_its_picture_is_refused(head_template, grid, picture):
    beside = replace(head_template, uvs=head_template.uvs + [1, 0])
    with pytest.raises(InputError, match="UVs that lay the face in its picture, found none"):
        ChangedTexture(picture, beside, grid)


def test_what_the_picture_shows_is_told_by_the_expressions(head, head_template, rig, picture):
    own = painter(head, head_template, rig, picture, jawOpen=0.5)
    code = dict(zip(ARKIT_NAMES, own.code, strict=True))
    assert code["jawOpen"] == pytest.approx(0.5, abs=0.05) and code["browInnerUp"] < 0.05
    assert not painter(head, head_template, rig, picture).code.any()


def test_of_a_rig_without_expressions_none_is_told(head, head_template, rig, picture):
    bare = replace(rig, names=(), deltas=rig.deltas[:0], actions=np.zeros((0, len(ARKIT_NAMES)), np.float32))
    own = painter(head, head_template, bare, picture, jawOpen=1)
    assert not own.code.any() and own.paint(np.zeros(0)).shape == picture.shape


def test_moods_are_pictures_of_the_skin(head, head_template, rig, picture):
    moods = painter(head, head_template, rig, picture).moods({"shout": {"jawOpen": 0.8, "browInnerUp": 0.3}})
    assert [mood.name for mood in moods] == ["shout"]
    assert moods[0].skin.shape == picture.shape and (moods[0].skin != picture).any()


def test_a_bare_face_and_a_network_of_another_mesh_are_refused(head, head_template, rig, picture):
    own = model(head_template.topology_id)
    with pytest.raises(InputError, match="a picture on its skin"):
        MoodPainter(rig, head_template, own)
    with pytest.raises(InputError, match="of the face's mesh"):
        MoodPainter(worn(head, rig, picture), head_template, model("0" * 64))


def test_a_rig_of_other_vertices_or_of_expressions_that_nobody_knows_is_refused(head, head_template, rig, picture):
    own = model(head_template.topology_id)
    painted = worn(head, rig, picture)
    turned = Mesh(rig.neutral, rig.mesh.polygons[::-1], rig.mesh.uvs, rig.mesh.uv_polygons[::-1])
    with pytest.raises(InputError, match="the head's own skin, 4200 vertices"):
        MoodPainter(replace(painted, mesh=turned), head_template, own)
    with pytest.raises(InputError, match="says of none what it is \\(grin, wink\\)"):
        MoodPainter(replace(painted, names=("grin", "wink")), head_template, own)


def test_expressions_are_what_the_rig_says_or_what_their_names_say(rig):
    assert expression_codes(rig)[0].tolist() == [float(name == "jawOpen") for name in ARKIT_NAMES]
    named = expression_codes(replace(rig, names=("smile", "blendShape1.browInnerUp")))
    assert named[0, ARKIT_NAMES.index("mouthSmileLeft")] > 0.3 and named[1].sum() == 1
    told = np.zeros((2, 52), np.float32)
    assert expression_codes(replace(rig, names=("grin", "wink"), actions=told)) is told


def test_the_picture_lies_on_the_uvs_of_the_rig(head, head_template, rig, picture):
    aside = Mesh(rig.neutral, rig.mesh.polygons, 0.5 * rig.mesh.uvs, rig.mesh.uv_polygons)
    small = np.full((512, 512, 3), 90, np.uint8)
    own = model(head_template.topology_id, 0.2)
    painted = MoodPainter(replace(worn(head, rig, small), mesh=aside), head_template, own).paint(np.zeros(2))
    usual = MoodPainter(worn(head, rig, small[::2, ::2]), head_template, own).paint(np.zeros(2))
    # The lower left quarter of the picture.
    assert (painted[:256] == 90).all() and (painted[:, 256:] == 90).all()
    assert np.abs(painted[256:, :256].astype(int) - usual).mean() < 2 and (usual != 90).any()


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        ({}, []),
        ({"jawOpen": 0.7}, ["mouth open"]),
        ({"eyeBlinkLeft": 1, "eyeBlinkRight": 1}, ["eye shut"]),
    ],
)
def test_what_a_picture_does_not_tell_is_said(head, head_template, rig, picture, actions, words):
    notes = painter(head, head_template, rig, picture, **actions).unknown()
    assert len(notes) == len(words) and all(word in note for word, note in zip(words, notes, strict=True))


def test_a_rig_without_a_camera_is_taken_as_calm(head, head_template, rig, picture):
    own = MoodPainter(replace(worn(head, rig, picture, jawOpen=1), depiction=None), head_template,
                      model(head_template.topology_id))  # fmt: skip
    assert not own.code.any() and "does not say what its picture shows" in own.unknown()[0]
