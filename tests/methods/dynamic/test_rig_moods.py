import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid, face_texels
from caricli.methods.dynamic.dress_texture import ChangedTexture
from caricli.methods.dynamic.rig_moods import MoodPainter
from caricli.models.texture.config import TextureSize
from caricli.models.texture.model import TextureModel
from caricli.models.texture.networks import TextureNetwork
from caricli.structures import Face, Pictures, Rig
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.texture_change import TextureChange
from caricli.template.chart import face_chart

SIDE = 32
NAMES = ("jawOpen", "browInnerUp")
ACTIONS = {name: {name: 1.0} for name in NAMES}


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


def worn(head, template, picture, **actions):
    mesh = template.with_vertices(head.evaluate(actions=actions))
    return Face(mesh, pictures=Pictures(skin=picture))


def painter(head, template, rig, picture, **actions):
    own = model(template.topology_id, 0.2)
    return MoodPainter(rig, worn(head, template, picture, **actions), ACTIONS, template, own)


def test_a_change_stays_on_the_face_and_fades_at_its_border(head_template, grid, picture):
    change = TextureChange(np.ones((SIDE, SIDE)), np.zeros((SIDE, SIDE, 3)), np.full((SIDE, SIDE, 3), 0.2))
    painted = ChangedTexture(picture, head_template, grid).paint(change)
    moved = painted.astype(int) - picture
    face = face_texels(head_template, grid, 256)
    assert (moved[~face] == 0).all() and (moved >= 0).all() and moved.max() == 51
    assert (moved[face] == 51).mean() > 0.6 and (moved[face] < 25).any()


def test_fine_strokes_stay_where_colours_change_slowly(head_template, grid, picture):
    change = TextureChange(np.full((SIDE, SIDE), 0.5), np.full((SIDE, SIDE, 3), -0.5), np.zeros((SIDE, SIDE, 3)))
    painted = ChangedTexture(picture, head_template, grid).paint(change)
    face = face_texels(head_template, grid, 256)
    inside = (painted == np.rint(0.75 * picture)).all(-1) & face
    assert inside.sum() > 0.5 * face.sum()


def test_what_the_picture_shows_is_told_by_the_expressions(head, head_template, rig, picture):
    own = painter(head, head_template, rig, picture, jawOpen=0.5)
    code = dict(zip(ARKIT_NAMES, own.code, strict=True))
    assert code["jawOpen"] == pytest.approx(0.5, abs=0.05) and code["browInnerUp"] < 0.05
    assert not painter(head, head_template, rig, picture).code.any()


def test_moods_are_pictures_of_the_skin(head, head_template, rig, picture):
    moods = painter(head, head_template, rig, picture).moods({"shout": {"jawOpen": 0.8, "browInnerUp": 0.3}})
    assert [mood.name for mood in moods] == ["shout"]
    assert moods[0].skin.shape == picture.shape and (moods[0].skin != picture).any()


def test_a_bare_face_and_a_network_of_another_mesh_are_refused(head, head_template, rig, picture):
    own = model(head_template.topology_id)
    with pytest.raises(InputError, match="a picture on its skin"):
        MoodPainter(rig, Face(head_template), ACTIONS, head_template, own)
    with pytest.raises(InputError, match="of the face's mesh"):
        MoodPainter(rig, worn(head, head_template, picture), ACTIONS, head_template, model("0" * 64))
