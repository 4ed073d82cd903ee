import numpy as np
import pytest

from caricli.data.picture_set import read_picture_set
from caricli.errors import InputError
from caricli.methods.pictures.sitter_shapes import sitter_shapes
from tests.posed_pictures import small_dataset, write_posed_set


@pytest.fixture(scope="module")
def dataset(head_template, people):
    return small_dataset(head_template, people[:5])


@pytest.fixture(scope="module")
def pictures(dataset, tmp_path_factory):
    return read_picture_set(write_posed_set(tmp_path_factory.mktemp("posed") / "set", dataset, 30, 4))


def test_who_sat_is_drawn_again_with_all_that_they_did(dataset, pictures):
    shapes = sitter_shapes(pictures, dataset)
    truth = pictures.truth
    moved = [
        np.abs(shapes.vertices[p] - dataset.vertices[truth["person"][k]]).max() for k, p in enumerate(shapes.places)
    ]
    assert len(shapes.vertices) == len(shapes.appearances)
    assert max(moved) > 1e-3 and min(moved) < 1e-6  # metres: some grin, some do nothing


def test_pictures_of_other_people_are_refused(dataset, pictures, head_template, people):
    with pytest.raises(InputError, match="landmarks that are not where its faces have them"):
        sitter_shapes(pictures, small_dataset(head_template, people[5:10]))
    with pytest.raises(InputError, match="one of others"):
        sitter_shapes(pictures, small_dataset(head_template, people[:4]))


@pytest.mark.parametrize("entry", ["settings", "sitter"])
def test_pictures_without_a_recipe_are_refused(dataset, pictures, entry):
    manifest = {name: value for name, value in pictures.manifest.items() if name != entry}
    bare = type(pictures)(pictures.folder, manifest, pictures.count, pictures.media, pictures.truth)
    with pytest.raises(InputError, match="expected pictures with"):
        sitter_shapes(bare, dataset)
