import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.models import load_model


@pytest.fixture(scope="module")
def picture():
    """The template's landmarks as a frontal picture shows them."""
    template = load_model(kind="pca").template
    return 1000 * template.vertices[template.annotation.landmarks[:68], :2] * [1, -1] + 500


WRONG = {
    "mirrored": lambda p: p * [-1, 1] + [1000, 0],
    "y up": lambda p: p * [1, -1] + [0, 1000],
    "x and y swapped": lambda p: p[:, ::-1],
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("method", ["intrinsic", "latent"])
def test_a_face_from_behind_is_refused(picture, name, method):
    model = load_model(kind="intrinsic" if method == "intrinsic" else "pca")
    with pytest.raises(InputError, match="from behind"):
        fit_landmarks(WRONG[name](picture), model, method)


@pytest.mark.parametrize("degrees", [-90, 90, 180])
def test_a_turned_picture_is_no_mistake(picture, degrees):
    turn = np.deg2rad(degrees)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    assert fit_landmarks((picture - 500) @ rotation.T + 500, load_model(kind="pca"), "latent").nme < 1.5
