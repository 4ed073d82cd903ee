import numpy as np

from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.texture.picture_view import PictureView, Sight, SurfacePoints
from caricli.methods.texture.settings import TextureSettings


def seen_share(head, camera, side):
    """(F,) how far the middles of a head's triangles are seen in a picture so many pixels wide and high."""
    whole = np.ones((side, side), bool)
    view = PictureView(head, Sight(camera, np.full((side, side, 3), 90, np.uint8), whole), TextureSettings())
    middles = head.vertices[head.faces].mean(1)
    return view.look(SurfacePoints(middles, triangle_normals(head.vertices, head.faces), np.zeros(len(middles)))).seen


def test_a_face_of_few_pixels_is_seen_as_a_large_one_is(pictured):
    large = seen_share(pictured.head, pictured.face.camera.zoomed(4), 960)
    small = seen_share(pictured.head, pictured.face.camera.zoomed(0.2), 48)
    face = pictured.head.mask("face")[pictured.head.faces].all(1) & (large > 0.5)
    assert face.sum() > 1000
    assert (small[face] > 0).mean() > 0.995
