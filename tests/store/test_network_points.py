import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.face import write_face
from caricli.methods.train.deformable.train_deformable import touching_vertices
from caricli.store.network_points import load_network_points
from caricli.structures import Face, Mesh
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template


@pytest.fixture(scope="module")
def template(ball):
    vertices, faces = ball
    return Template(vertices, faces, annotation=parse_annotation({"ibug68": list(range(68))}, len(vertices), "ball"))


def test_the_open_head_is_deformed_with_its_lips_apart(head, head_template):
    points = load_network_points(head_template)
    np.testing.assert_array_equal(points, head.open_mouth_template().vertices)
    assert touching_vertices(points) == 0


def test_another_template_is_deformed_itself_or_as_a_file_says(template, head_template, tmp_path):
    np.testing.assert_array_equal(load_network_points(template), template.vertices)
    wide = template.vertices * [2, 1, 1]
    write_face(tmp_path / "wide.npz", Face(Mesh(wide, template.faces)))
    np.testing.assert_allclose(load_network_points(template, tmp_path / "wide.npz"), wide, rtol=1e-6)
    with pytest.raises(
        InputError, match=r"wide\.npz: expected the dataset's topology \(4200 vertices\), found another"
    ):
        load_network_points(head_template, tmp_path / "wide.npz")


@pytest.mark.parametrize(("scale", "right"), [(0.6, True), (1.9, True), (0.4, False), (2.1, False), (100, False)])
def test_a_template_in_another_unit_is_refused(template, tmp_path, scale, right):
    write_face(tmp_path / "own.npz", Face(Mesh(scale * template.vertices, template.faces)))
    if right:
        assert len(load_network_points(template, tmp_path / "own.npz")) == len(template.vertices)
    else:
        with pytest.raises(InputError, match=r"own\.npz: expected metres, about the [0-9.]+ that the dataset's"):
            load_network_points(template, tmp_path / "own.npz")


def test_vertices_in_one_place_are_counted(template):
    points = template.vertices.copy()
    points[5] = points[9]
    assert touching_vertices(points) == 2 and touching_vertices(template.vertices) == 0
