import pytest

from caricli.structures.arkit import ARKIT_NAMES, arkit_name, is_half


@pytest.mark.parametrize(
    ("name", "arkit"),
    [
        ("jawOpen", "jawOpen"),
        ("JawOpen", "jawOpen"),
        ("eyeBlink_L", "eyeBlinkLeft"),
        ("blendShape1.mouthSmile_R", "mouthSmileRight"),
        ("browInnerUp_L", "browInnerUp"),
        ("cheekPuff_R", "cheekPuff"),
        ("mouthLeft", "mouthLeft"),
        ("jawLeft", "jawLeft"),
        ("smile", None),
        ("jaw_L", "jawLeft"),
        ("nose_L", None),
        ("", None),
    ],
)
def test_names_that_mean_an_action(name, arkit):
    assert arkit_name(name) == arkit


def test_halves_are_those_of_whole_actions():
    assert [name for name in ARKIT_NAMES if is_half(name)] == []
    assert is_half("browInnerUp_L") and is_half("cheekPuffRight") and not is_half("eyeBlink_L") and not is_half("x_L")
