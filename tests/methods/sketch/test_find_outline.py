import numpy as np
import pytest

from caricli.methods.sketch.find_outline import find_outline

EYES_AND_MOUTH = [np.array(line, float) for line in ([(40, 50), (48, 50)], [(60, 50), (68, 50)], [(45, 80), (62, 80)])]
JAW = np.array([(30.0, 40), (35, 100), (54, 140), (73, 100), (78, 40)])


@pytest.mark.parametrize(
    ("others", "number"),
    [
        ([], 0),
        ([np.array([(20.0, 20), (10, 150), (98, 150), (88, 20)])], 0),  # hair or a cloak around the jaw
        ([np.array([(30.0, 45), (30, 10), (78, 10), (78, 45)])], 0),  # a cap of hair
    ],
)
def test_a_jaw_goes_around_all_features(others, number):
    assert find_outline([JAW, *others], EYES_AND_MOUTH) == number
    assert find_outline([*others, JAW], EYES_AND_MOUTH) == len(others)


@pytest.mark.parametrize(
    "line",
    [
        JAW * [0.5, 1],  # beside the right eye
        JAW - [0, 70],  # over the mouth
        np.array([(30.0, 120), (54, 135), (78, 120)]),  # shoulders, or a second chin
    ],
)
def test_what_leaves_a_feature_out_is_no_outline(line):
    assert find_outline([line], EYES_AND_MOUTH) is None


def test_few_features_tell_of_no_outline():
    assert find_outline([JAW], EYES_AND_MOUTH[:2]) is None
    assert find_outline([], EYES_AND_MOUTH) is None
