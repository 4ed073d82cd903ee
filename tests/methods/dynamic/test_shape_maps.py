import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.methods.dynamic.chart_pictures import ChartGrid
from caricli.methods.dynamic.shape_maps import BENT, CHANNELS, PART, PersonShapes, pair_attention, pair_maps
from caricli.template.chart import face_chart


def shape_maps(grid, neutral, source, target):
    person = PersonShapes(grid, neutral)
    return pair_maps(grid, person.fields(source), person.fields(target))


def displacement_attention(grid, neutral, source, target):
    person = PersonShapes(grid, neutral)
    return pair_attention(grid, person.fields(source), person.fields(target))


@pytest.fixture(scope="module")
def grid(head_template):
    return ChartGrid(face_chart(head_template), 96)


@pytest.fixture(scope="module")
def smile(head):
    return head.evaluate(actions={"mouthSmileLeft": 1, "mouthSmileRight": 1, "cheekSquintLeft": 1})


@pytest.fixture(scope="module")
def shout(head):
    return head.evaluate(actions={"jawOpen": 1, "browInnerUp": 1})


@pytest.fixture(scope="module")
def maps(grid, head_template, smile, shout):
    """By the names of their channels."""
    return named(shape_maps(grid, head_template.vertices, smile, shout))


def named(maps):
    return dict(zip(CHANNELS, np.moveaxis(maps, -1, 0), strict=True))


def moved(vertices, seed):
    generator = np.random.default_rng(seed)
    return vertices @ Rotation.random(random_state=seed).as_matrix().T + generator.normal(size=3)


def test_turning_and_moving_the_shapes_changes_nothing(grid, head_template, smile, shout, maps):
    shapes = [moved(shape, seed) for seed, shape in enumerate((head_template.vertices, smile, shout))]
    for name, channel in named(shape_maps(grid, *shapes)).items():
        # A ray that just passes an edge may hit it after a turn.
        np.testing.assert_allclose(channel, maps[name], atol=0.15 if "openness" in name else 2e-4, err_msg=name)


def test_a_larger_person_has_the_same_maps(grid, head_template, smile, shout, maps):
    other = named(shape_maps(grid, 3 * head_template.vertices, 3 * smile, 3 * shout))
    np.testing.assert_allclose(other["displacement_y"], maps["displacement_y"], atol=1e-4)
    np.testing.assert_allclose(other["target_curvature"], maps["target_curvature"], atol=1e-4)


def test_all_is_about_one_and_nothing_where_nothing_is_covered(grid, maps):
    for name, channel in maps.items():
        assert np.abs(channel).max() < 1.3, name
        assert not channel[~grid.covered].any(), name
    assert all(maps[f"{side}_{kind}"].std() > 0.003 for side in ("source", "target") for kind in ("area", "gap"))


def test_a_person_at_rest(grid, head_template):
    rest = named(shape_maps(grid, *3 * [head_template.vertices]))
    for name in ("displacement_x", "displacement_y", "source_curvature", "target_area"):
        assert np.abs(rest[name]).max() < 1e-5, name


def test_source_and_target_change_places(grid, head_template, smile, shout, maps):
    other = named(shape_maps(grid, head_template.vertices, shout, smile))
    np.testing.assert_allclose(other["displacement_z"], -maps["displacement_z"], atol=1e-6)
    np.testing.assert_array_equal(other["target_openness"], maps["source_openness"])


def test_displacements_are_those_of_the_vertices(grid, head_template, smile, shout, maps):
    width = PersonShapes(grid, head_template.vertices).width
    length = np.sqrt(sum(maps[f"displacement_{axis}"] ** 2 for axis in "xyz"))
    np.testing.assert_allclose(width, np.ptp(head_template.vertices[grid.chart.vertices][:, 0]), rtol=0.01)
    # The shapes are in one place already, so that laying one on the other leaves them there, nearly.
    expected = grid.bake((shout - smile) / width / PART)
    assert np.abs(length - np.linalg.norm(expected, axis=-1)).max() < 0.05


def test_the_gap_opens_with_the_jaw_and_only_between_the_lips(grid, maps):
    assert maps["target_gap"][grid.mouth].max() > 4 * maps["source_gap"][grid.mouth].max()
    assert not maps["target_gap"][~grid.mouth].any()


def test_curvature_of_a_ball_is_one_over_its_radius(grid, head_template):
    x, y = (grid.chart.uvs - 0.5).T
    flat = np.zeros_like(head_template.vertices)
    flat[grid.chart.vertices, :2] = grid.chart.uvs
    ball = flat.copy()
    ball[grid.chart.vertices, 2] = np.sqrt(1.5**2 - x**2 - y**2)
    person = PersonShapes(grid, flat)
    edge = np.isin(np.arange(len(x)), np.unique(grid.chart.faces[grid.chart.membrane])) | (np.hypot(x, y) > 0.4)
    expected = np.tanh(person.width / 1.5 / BENT)
    bent = person.fields(ball).values[~edge, 3]
    np.testing.assert_allclose(np.median(bent), expected, rtol=0.05)
    assert np.quantile(bent, 0.02) > 0


def test_attention_is_where_the_face_moves(grid, head_template, smile, shout):
    neutral = head_template.vertices
    attention = displacement_attention(grid, neutral, neutral, shout)
    assert attention.dtype == np.float32 and attention.min() == 0 and attention.max() <= 1
    assert attention[grid.mouth].min() > 0.5
    nose = np.linalg.norm(grid.bake(neutral) - neutral[head_template.annotation.landmarks[30]], axis=-1) < 0.01
    assert attention[nose].max() < 0.3
    assert displacement_attention(grid, neutral, smile, smile).max() < 1e-6


def test_shapes_of_another_mesh(grid, head_template):
    with pytest.raises(InputError, match="of the mesh that the chart was made of"):
        shape_maps(grid, head_template.vertices[:100], head_template.vertices, head_template.vertices)
