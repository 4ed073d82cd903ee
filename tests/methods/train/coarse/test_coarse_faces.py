import numpy as np
import pytest

from caricli.data.picture_set import read_picture_set
from caricli.errors import InputError
from caricli.methods.evaluate.reconstruct_portrait import shape_error
from caricli.methods.train.coarse.coarse_faces import CoarseWindowSettings, JoinedFaces, TrueFaces, WindowDrawer
from caricli.store.models import load_morphable
from tests.posed_pictures import small_dataset, write_posed_set


@pytest.fixture(scope="module")
def model():
    return load_morphable()


@pytest.fixture(scope="module")
def dataset(model, people):
    return small_dataset(model.template, people[:5])


@pytest.fixture(scope="module")
def faces(model, dataset, tmp_path_factory):
    """Of pictures without perspective, whose landmarks are exactly where a camera of ours has them."""
    folder = write_posed_set(tmp_path_factory.mktemp("posed") / "set", dataset, 72, 4, perspective=0.0)
    return TrueFaces(read_picture_set(folder), dataset, model, "train")


def gaps(truth, landmarks):
    """Pixels between the landmarks of a TrueFace and of a picture, before the best camera of its rotation."""
    flat = (truth.vertices @ truth.rotation.T)[truth.anchors, :2]
    own = flat - flat.mean(0)
    marks = landmarks - landmarks.mean(0)
    scale = (own * marks).sum() / (own**2).sum()
    assert scale > 0 and np.linalg.det(truth.rotation) > 0.99
    return np.linalg.norm(scale * own - marks, axis=1)


def test_the_truth_is_where_the_picture_shows_it(model, dataset, faces):
    face = faces.study(0)
    assert gaps(face.truth, face.picture.landmarks[0]).max() < 0.2
    middle = face.truth.vertices.mean(0) - model.mean.mean(0)
    assert np.abs(middle).max() < 0.02 and face.truth.albedo.shape == face.truth.vertices.shape


@pytest.mark.parametrize("bent", [0.0, 1.0])
def test_it_stays_so_in_windows_that_are_turned_stretched_bent_and_mirrored(model, faces, bent):
    drawer = WindowDrawer(model, 64, CoarseWindowSettings(stretch=0.1, bent=bent))
    generator = np.random.default_rng(0)
    face = faces.study(1)
    windows = [drawer.draw(face, True, generator) for _ in range(12)]
    for window in windows:
        assert gaps(window.truth, window.picture.landmarks[0]).max() < 0.4
    changes = [shape_error(w.truth.vertices, face.truth.vertices, model.template) for w in windows]
    assert 0.3 < np.mean(changes) < 6  # percent of the head's height: other people, not monsters


def test_windows_that_are_only_turned_and_mirrored_show_the_same_person(model, faces):
    drawer = WindowDrawer(model, 64, CoarseWindowSettings(stretch=0.0, bent=0.0))
    face = faces.study(2)
    mirror = model.template.annotation.mirror
    twin = face.truth.vertices[mirror] * [-1, 1, 1]
    generator = np.random.default_rng(1)
    windows = [drawer.draw(face, number % 2 == 0, generator).truth.vertices for number in range(8)]
    errors = np.array([[shape_error(own, true, model.template) for true in (face.truth.vertices, twin)]
                       for own in windows])  # fmt: skip
    assert errors.min(1).max() < 0.02 and (errors.argmin(1) == 0).any() and (errors.argmin(1) == 1).any()


def test_a_plain_window_has_the_colours_of_the_picture(model, faces):
    drawer = WindowDrawer(model, 64, CoarseWindowSettings(disguised=1.0))
    face = faces.study(0)
    plain, disguised = (drawer.draw(face, plain, np.random.default_rng(3)) for plain in (True, False))
    np.testing.assert_array_equal(plain.picture.landmarks, disguised.picture.landmarks)
    assert plain.plain and not disguised.plain
    assert np.abs(plain.picture.pixels - disguised.picture.pixels).mean() > 0.01


def test_joined_faces_are_numbered_on_from_one_source_to_the_next(faces):
    joined = JoinedFaces([faces, faces])
    count = len(faces.faces)
    assert len(joined.faces) == 2 * count and len(joined.shapes()) == 2 * len(faces.shapes())
    for number, own in ((1, 1), (count + 2, 2)):
        np.testing.assert_array_equal(joined.study(number).truth.vertices, faces.study(own).truth.vertices)


def test_pictures_of_another_topology_are_refused(model, dataset, faces):
    pictures = faces.split.pictures
    other = type(pictures)(pictures.folder, pictures.manifest | {"topology_id": "?"}, *_rest(pictures))
    with pytest.raises(InputError, match="of one topology"):
        TrueFaces(other, dataset, model, "train")


def _rest(pictures):
    return pictures.count, pictures.media, pictures.truth
