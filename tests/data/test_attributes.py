from dataclasses import replace

import numpy as np
import pytest

from caricli.data.attributes import QUANTILE, binary_labels, measure_attributes
from caricli.data.dataset import read_dataset
from caricli.template.annotation import parse_annotation

NOSE, EYES, MOUTH = range(27, 36), (range(36, 42), range(42, 48)), range(48, 68)
# What issue and paper name; all of them must be measured.
NAMES = """BigNose SmallNose WideNose HookNose BigMouth ThickLips BigEye SmallEye LargeForehead SquareJaw HighCheekbones
RoundFace DoubleChin Smile ArchedEyebrows Women Youth Old Caricature""".split()


def scaled(p, ids, factors, pivot=None):
    ids = list(ids)
    pivot = p[ids].mean(0) if pivot is None else pivot
    p[ids] = pivot + (p[ids] - pivot) * factors


def eyes(p, factors):
    for eye in EYES:
        scaled(p, eye, factors)


def apart(p, metres):
    p[list(range(36, 42))] -= [metres, 0, 0]
    p[list(range(42, 48))] += [metres, 0, 0]


def lips(p, metres):
    p[49:54, 1] += metres
    p[55:60, 1] -= metres


def shifted(p, ids, x=0.0, y=0.0, z=0.0):
    p[list(ids)] += [x, y, z]


MOVES = [
    (lambda p: scaled(p, NOSE, 1.4, p[27].copy()), ["BigNose", "WideNose", "LongNose"], ["SmallNose"]),
    (lambda p: scaled(p, range(31, 36), [1.5, 1, 1]), ["WideNose", "BigNose"], ["SmallNose"]),
    (lambda p: shifted(p, [30], y=-0.006), ["HookNose"], []),
    (lambda p: shifted(p, [28, 29], z=0.005), ["HookNose"], []),
    (lambda p: scaled(p, MOUTH, [1.4, 1, 1]), ["BigMouth"], ["SmallMouth"]),
    (lambda p: lips(p, 0.006), ["ThickLips"], ["ThinLips"]),
    (lambda p: shifted(p, [48, 54], y=0.008), ["Smile"], ["Frown"]),
    (lambda p: shifted(p, range(55, 60), y=-0.02) or shifted(p, range(65, 68), y=-0.02), ["MouthOpen"], []),
    (lambda p: eyes(p, 1.4), ["BigEye"], ["SmallEye"]),
    (lambda p: eyes(p, [1, 0.5, 1]), ["SmallEye", "NarrowEye"], ["BigEye"]),
    (lambda p: apart(p, 0.01), ["WideSetEyes"], []),
    (lambda p: shifted(p, range(68, 71), y=0.03), ["LargeForehead"], ["SmallForehead"]),
    (lambda p: shifted(p, range(17, 27), y=0.01), ["RaisedEyebrows", "SmallForehead"], ["LargeForehead"]),
    (lambda p: shifted(p, [19, 24], y=0.006), ["ArchedEyebrows"], []),
    (lambda p: scaled(p, range(3, 14), [1.3, 1, 1]), ["SquareJaw"], ["HighCheekbones"]),
    (lambda p: scaled(p, range(6, 11), [0.5, 1, 1]), ["PointedChin"], ["SquareJaw"]),
    (lambda p: shifted(p, range(5, 12), y=-0.03), ["LongChin", "LongFace"], ["RoundFace"]),
    (lambda p: scaled(p, range(0, 17), [1.3, 1, 1]), ["RoundFace"], ["LongFace"]),
    (lambda p: scaled(p, [77, 78], [1.3, 1, 1]), ["HighCheekbones"], []),
    (lambda p: scaled(p, range(71, 77), [1, 1.5, 1]), ["BigEar"], []),
    (lambda p: shifted(p, [75], x=0.02) or shifted(p, [72], x=-0.02), ["ProtrudingEars"], []),
]


@pytest.mark.parametrize("move", range(len(MOVES)))
def test_a_move_of_landmarks_changes_the_right_measures(head_template, move):
    change, more, less = MOVES[move]
    before = measure_attributes(head_template.vertices, head_template)
    vertices = head_template.vertices.copy()
    points = vertices[head_template.annotation.landmarks]
    change(points)
    vertices[head_template.annotation.landmarks] = points
    after = measure_attributes(vertices, head_template)
    for name in more:
        assert after[name] > before[name] + 1e-4, name
    for name in less:
        assert after[name] < before[name] - 1e-4, name


def test_flesh_below_the_chin_makes_a_double_chin(head_template):
    under = [path[0] for path in head_template.annotation.jaw_paths[7:10]]
    vertices = head_template.vertices.copy()
    vertices[under, 1] -= 0.02
    before, after = (measure_attributes(v, head_template)["DoubleChin"] for v in (head_template.vertices, vertices))
    assert after > before + 0.05


def test_without_paths_below_the_chin_a_double_chin_is_not_measured(head_template):
    source = {name: value for name, value in head_template.annotation.source.items() if name != "jaw_paths"}
    annotation = parse_annotation(source, len(head_template.vertices), "no paths")
    bare = measure_attributes(head_template.vertices, replace(head_template, annotation=annotation))
    whole = measure_attributes(head_template.vertices, head_template)
    assert set(whole) - set(bare) == {"DoubleChin"} and all(bare[name] == whole[name] for name in bare)


def test_every_named_attribute_is_there_and_what_is_not_known_is_absent(head_template):
    measures = measure_attributes(head_template.vertices, head_template, 0.9, 0.2, True)
    assert set(NAMES) <= set(measures) and len(measures) >= 20
    assert np.isfinite(list(measures.values())).all()
    assert (measures["Women"], measures["Old"], measures["Youth"], measures["Caricature"]) == (0.9, 0.2, -0.2, 1.0)
    bare = measure_attributes(head_template.vertices, head_template)
    assert set(measures) - set(bare) == {"Women", "Old", "Youth", "Caricature"}
    assert all(bare[name] == measures[name] for name in bare)


def test_measures_do_not_depend_on_size_or_place(head_template):
    bare = measure_attributes(head_template.vertices, head_template)
    moved = measure_attributes(2.5 * head_template.vertices + [0.1, -3.0, 2.0], head_template)
    np.testing.assert_allclose(list(moved.values()), list(bare.values()), atol=1e-9)


def test_labels_are_above_the_quantile_of_the_training_meshes():
    measures = np.column_stack([np.arange(40.0), np.linspace(0, 1, 40), np.r_[np.zeros(30), np.ones(10)]])
    training = np.arange(40) < 20
    labels, thresholds = binary_labels(measures, ["BigNose", "Women", "Caricature"], training)
    assert labels.dtype == bool
    np.testing.assert_allclose(thresholds, [19 * QUANTILE, 0.5, 0.5])
    np.testing.assert_array_equal(labels[:, 0], measures[:, 0] > 19 * QUANTILE)
    assert labels[training, 0].sum() == 5
    np.testing.assert_array_equal(labels[:, 1], measures[:, 1] > 0.5)
    np.testing.assert_array_equal(labels[:, 2], measures[:, 2] == 1)


def test_labels_of_a_dataset_follow_from_its_measures(built):
    data = read_dataset(built[0])
    assert set(NAMES) <= set(data.attributes)
    thresholds = np.array([data.manifest["thresholds"][name] for name in data.attributes])
    # Measures are stored in single precision: equality at the threshold may be lost.
    clear = np.abs(data.measures - thresholds) > 1e-6
    np.testing.assert_array_equal(data.labels[clear], (data.measures > thresholds)[clear])
    assert clear.mean() > 0.9
    row = measure_attributes(data.vertices[0].astype(float), data.template)
    stored = dict(zip(data.attributes, data.measures[0], strict=True))
    np.testing.assert_allclose([stored[name] for name in row], list(row.values()), atol=1e-4)
