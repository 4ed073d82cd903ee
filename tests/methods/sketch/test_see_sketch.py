from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_angles, head_rotation
from caricli.methods.sketch.draw_sketch import draw_sketch
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.store.sketch_networks import load_sketch_pair
from caricli.structures import Camera
from caricli.structures.sketch import Sketch
from caricli.template.feature_curves import feature_curves


@pytest.fixture(scope="module")
def pair():
    """The bundled network, and the model whose latents it tells."""
    return load_sketch_pair()


@pytest.fixture(scope="module")
def sketch(pair):
    """A crooked face that looks aside; of its curves one is not drawn."""
    _, basis = pair
    face = basis.decode(2 * np.random.default_rng(6).normal(size=len(basis.prior.mean)))
    camera = Camera(900.0, head_rotation(np.array([0.05, 0.3, 0.08])), np.array([128.0, 128.0]))
    whole = draw_sketch(face, feature_curves(basis.template.annotation), camera)
    return whole.with_strokes(stroke for stroke in whole.strokes if stroke.curve != "brow_left")


def mirrored(sketch: Sketch) -> Sketch:
    """A sketch in a mirror, with the names of what is on the other side."""
    names = {"left": "right", "right": "left"}

    def turned(stroke):
        words = (stroke.curve or "").split("_")
        points = stroke.points * [-1, 1] + [sketch.size[0] - 1, 0]
        return replace(stroke.moved(points), curve="_".join(names.get(word, word) for word in words) or None)

    return sketch.with_strokes(map(turned, sketch.strokes))


def test_the_face_of_a_sketch_in_a_mirror_is_its_mirror_image(pair, sketch):
    network, basis = pair
    own, other = (see_sketch(each, network, basis) for each in (sketch, mirrored(sketch)))
    turned = own.vertices[basis.template.annotation.mirror] * [-1, 1, 1]
    height = basis.template.height
    away = [np.linalg.norm(vertices - turned, axis=1).mean() / height for vertices in (other.vertices, own.vertices)]
    # Pixels of a line and of its mirror image differ a little; one look differs by 0.018.
    assert away[0] < 0.0025
    assert away[1] > 0.005, "a face that is the same on both sides shows nothing"
    angles = [head_angles(face.require_camera().rotation) for face in (own, other)]
    np.testing.assert_allclose(angles[1], angles[0] * [1, -1, -1], atol=0.01)


def test_points_of_lines_in_two_mirrors_are_as_they_were(pair, sketch):
    network, _ = pair
    _, points, _ = network.look(sketch)
    once = network.mirrored(points[None])
    assert np.isnan(once[0, network.curves.index("brow_right")]).all()
    assert np.isfinite(once[0, network.curves.index("brow_left")]).all()
    np.testing.assert_array_equal(network.mirrored(once)[0], points)
