import pytest

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.store.landmark_maps import landmark_map_path, load_landmark_map


def test_the_bundled_map_is_taken_where_none_is_given(tmp_path):
    assert landmark_map_path() == asset_path("landmark_map.safetensors")
    assert landmark_map_path(tmp_path) == tmp_path
    assert load_landmark_map().to_normal.shape == (136, 136)


def test_a_model_is_no_map():
    with pytest.raises(InputError, match="pca.safetensors: expected a map of schema"):
        load_landmark_map(asset_path("pca.safetensors"))
