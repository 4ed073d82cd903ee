import numpy as np
import pytest

from caricli.errors import InputError
from caricli.structures.mesh import triangle_fans
from caricli.template.annotation import parse_annotation
from caricli.template.fine_mesh import fine_mesh
from caricli.template.template import Template


def test_level_0_is_the_templates_own_mesh(head_template):
    fine = fine_mesh(head_template, 0)
    assert (fine.weights @ head_template.vertices == head_template.vertices).all()
    for name in ("faces", "polygons", "uvs", "uv_polygons"):
        assert np.array_equal(getattr(fine.mesh, name), getattr(head_template, name)), name


def test_a_finer_head_has_uvs_at_every_corner(head_template):
    fine = fine_mesh(head_template, 1)
    assert np.array_equal(fine.mesh.faces, triangle_fans(fine.mesh.polygons)) and len(fine.mesh.polygons) == 4 * 4178
    assert fine.mesh.uv_polygons.shape == fine.mesh.polygons.shape and fine.mesh.uv_polygons.max() < len(fine.mesh.uvs)
    # Quads come four for each of the template's, the first corner of each at one of its corners.
    corners = fine.mesh.polygons[:, 0].reshape(-1, 4), fine.mesh.uv_polygons[:, 0].reshape(-1, 4)
    assert np.array_equal(corners[0], head_template.polygons)
    assert np.array_equal(corners[1], head_template.uv_polygons)
    assert np.array_equal(fine.mesh.uvs[: len(head_template.uvs)], head_template.uvs)


def test_what_could_not_be_read_back_is_refused(head_template):
    with pytest.raises(InputError, match="subdivision beyond the memory cap"):
        fine_mesh(head_template, 4)


def test_a_template_without_uvs_stays_without(ball):
    vertices, faces = ball
    annotation = parse_annotation({"ibug68": list(range(68))}, len(vertices), "ball")
    template = Template(vertices, faces, annotation=annotation)
    fine = fine_mesh(template, 2)
    assert fine.mesh.uvs is None and fine.mesh.uv_polygons is None and len(fine.mesh.faces) == 24 * len(faces)


def test_another_shape_keeps_the_split(head_template):
    fine = fine_mesh(head_template, 1)
    wide = head_template.vertices * [2, 1, 1]
    shaped = fine.shaped(wide)
    np.testing.assert_array_equal(shaped.mesh.vertices, fine.weights @ wide)
    assert shaped.weights is fine.weights and shaped.levels == 1
    assert shaped.mesh.topology_id == fine.mesh.topology_id
    np.testing.assert_array_equal(fine.with_vertices(shaped.mesh.vertices).mesh.vertices, shaped.mesh.vertices)
    with pytest.raises(InputError, match="as the mesh has"):
        fine.with_vertices(wide)
    np.testing.assert_array_equal(fine_mesh(head_template, 0).shaped(wide).mesh.vertices, wide)
