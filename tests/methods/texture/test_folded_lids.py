from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.rig.head_expressions import BLINKS, open_head_expressions
from caricli.methods.texture.fill_unseen import vertex_areas
from caricli.methods.texture.folded_lids import folded_lids
from caricli.methods.texture.picture_view import Sight
from caricli.methods.texture.settings import TextureSettings
from caricli.methods.texture.texture_face import texture_face
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Camera

SIZE = 512


@pytest.fixture
def open_head(head, head_template):
    return head_template.with_vertices(head.evaluate())


def test_it_is_between_crease_and_edge_of_upper_lids(open_head):
    folded = folded_lids(open_head)
    assert folded.min() == 0 and folded.max() == 1 and 50 < (folded > 0).sum() < 400
    marks = open_head.vertices[open_head.annotation.landmarks]
    lids = open_head.vertices[folded > 0.5]
    assert (lids[:, 1] > marks[[40, 41, 46, 47], 1].max()).all()
    assert (lids[:, 1] < marks[17:27, 1].max()).all()
    sockets = open_head.mask("eye_socket_left", "eye_socket_right")
    assert not folded[sockets].any() and not folded[open_head.annotation.curves["eye_upper_left"]].any()


def test_skin_that_a_blink_draws_out_of_a_fold_is_folded(open_head):
    actions = open_head_expressions()
    blink = actions.deltas[[actions.names.index(name) for name in BLINKS]].sum(0)
    grown = vertex_areas(actions.mesh.with_vertices(actions.neutral + blink)) / vertex_areas(actions.mesh) > 1.7
    folded = folded_lids(open_head)[grown]
    # The rest is at the edges of lids.
    assert len(folded) > 20 and np.isin(folded, [0, 1]).all() and folded.mean() > 0.85


def test_lids_of_closed_eyes_are_seen(head, open_head):
    closed, half = (
        open_head.with_vertices(head.evaluate(actions={"eyeBlinkLeft": weight, "eyeBlinkRight": weight}))
        for weight in (0.8, 0.5)
    )
    most, some, none = (folded_lids(each).max() for each in (open_head, half, closed))
    assert most == 1 and none < 0.3 and none < some


def test_of_another_topology_nothing_is_known(open_head):
    other = replace(open_head, polygons=open_head.polygons[:-1], uv_polygons=open_head.uv_polygons[:-1])
    np.testing.assert_array_equal(folded_lids(other), np.zeros(len(other.vertices)))


def test_a_drawn_crease_is_no_paint_of_the_lid(open_head):
    camera = Camera(2000.0, np.diag([1.0, -1, -1]), np.array([300.0, 500.0]))
    folded = folded_lids(open_head)
    raster = rasterise(camera.place(open_head.vertices), open_head.faces, 600, 900)
    shown = raster.face >= 0
    image = np.where(shown[..., None], (210, 160, 130), (90, 110, 130)).astype(np.uint8)
    image[shown & (folded[open_head.faces].mean(1) > 0.5)[raster.face]] = (40, 20, 20)
    sight = Sight(camera, image, shown)
    texture = texture_face(open_head, sight, SIZE, TextureSettings(keep_light=True))
    u, v = open_head.uvs[open_head.uv_faces[(folded[open_head.faces] > 0.9).all(1)]].mean(1).T
    colours = texture.image[((1 - v) * SIZE).astype(int), (u * SIZE).astype(int)]
    assert len(colours) > 20 and colours.min(0)[0] > 100 and colours.mean(0)[0] > 150
