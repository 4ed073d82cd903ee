import numpy as np
import pytest

from caricli.structures.mesh import topology_id
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template


@pytest.fixture(scope="module")
def template(ball):
    vertices, faces = ball
    regions = {"nose": [1, 2, 3], "mouth": [3, 4]}
    annotation = parse_annotation({"ibug68": list(range(68)), "regions": regions}, len(vertices), "ball")
    return Template(vertices, faces, annotation=annotation)


def test_height_is_the_extent_along_y(template):
    assert template.height == pytest.approx(np.ptp(template.vertices[:, 1]))
    assert template.with_vertices(template.vertices * [1, 3, 1]).height == pytest.approx(3 * template.height)


def test_regions_by_name_and_everything_for_an_unknown_one(template):
    assert template.region("nose").tolist() == [1, 2, 3]
    assert np.array_equal(template.region("ears"), np.arange(len(template.vertices)))


def test_a_mask_joins_the_regions_that_there_are(template):
    assert np.flatnonzero(template.mask("nose", "mouth", "ears")).tolist() == [1, 2, 3, 4]
    assert not template.mask("ears").any() and not template.mask().any()


def test_the_topology_is_named_by_its_faces(template):
    assert template.topology_id == topology_id(template.faces)
    assert template.with_vertices(2 * template.vertices).topology_id == template.topology_id


def test_gradients_are_made_once_for_each_shape(template):
    other = template.with_vertices(template.vertices * [1, 2, 1])
    assert template.gradients is template.gradients
    assert np.array_equal(other.gradients.template, other.vertices)
    assert np.array_equal(template.gradients.template, template.vertices)


def test_a_mesh_without_cavities_has_nothing_to_tuck(template):
    shape = 2 * template.vertices
    assert np.array_equal(template.cavities.tuck(shape), shape)
