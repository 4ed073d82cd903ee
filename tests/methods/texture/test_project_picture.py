import numpy as np

from caricli.methods.texture.project_picture import project_picture
from caricli.render.pixels.sample_texture import sample_texture


def test_every_vertex_has_the_pixel_where_it_is_seen(pictured):
    head = project_picture(pictured.head, pictured.face.camera, pictured.image)
    np.testing.assert_array_equal(head.uv_polygons, head.polygons)
    np.testing.assert_array_equal(head.vertices, pictured.head.vertices)
    assert head.annotation is pictured.head.annotation
    # A picture whose colours are its coordinates; between pixels samples are rounded.
    height, width = pictured.image.shape[:2]
    rows, columns = np.indices((height, width))
    places = np.stack([columns, rows, 0 * rows], axis=-1).astype(np.uint8)
    pixels = pictured.face.camera.project(pictured.head.vertices)
    inside = ((pixels > 0) & (pixels < [width - 1, height - 1])).all(1)
    assert inside.mean() > 0.9
    np.testing.assert_allclose(sample_texture(places, head.uvs)[inside, :2], pixels[inside], atol=0.501)


def test_the_head_it_is_made_of_stays_as_it_is(pictured):
    before = pictured.head.uvs.copy()
    project_picture(pictured.head, pictured.face.camera, pictured.image)
    np.testing.assert_array_equal(pictured.head.uvs, before)
