import shutil

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.store.models import bundled_kind, check_topology, load_model, load_morphable, model_name


def test_a_model_is_known_by_its_kind_or_its_path():
    model = load_model(kind="pca")
    assert model.kind == "pca" and load_model(asset_path("pca.safetensors")).model_id == model.model_id
    assert bundled_kind(model.model_id) == "pca" and bundled_kind("0" * 64) is None
    assert model_name(model.model_id) == "the bundled pca model" and "0000" in model_name("0" * 64)


def test_where_it_must_be_morphable_another_is_refused():
    assert load_morphable().kind == "morphable"
    with pytest.raises(InputError, match=r"pca\.safetensors: expected a model of kind morphable, found pca"):
        load_morphable(asset_path("pca.safetensors"))


def test_a_model_of_another_mesh_is_refused(head_template):
    model = load_model(kind="pca")
    check_topology(model.template, head_template, "pca")
    fewer = type(head_template)(head_template.vertices, head_template.polygons[1:], annotation=head_template.annotation)
    with pytest.raises(InputError, match="the model: expected the dataset's topology"):
        check_topology(model.template, fewer, "the model")


@pytest.mark.parametrize("kind", ["pca", "morphable", "deformable"])
def test_what_is_bundled_lies_in_the_picture_as_the_head_does(head_template, kind):
    template = load_model(kind=kind).template
    np.testing.assert_array_equal(template.uvs, head_template.uvs)
    np.testing.assert_array_equal(template.uv_polygons, head_template.uv_polygons)
    assert template.topology_id == head_template.topology_id


@pytest.mark.parametrize("kind", ["pca", "intrinsic", "deformable"])
def test_a_copy_of_a_bundled_model_is_that_model(tmp_path, kind):
    shutil.copy(asset_path(f"{kind}.safetensors"), tmp_path / "copy.safetensors")
    copy, model = load_model(tmp_path / "copy.safetensors"), load_model(kind=kind)
    assert copy.model_id == model.model_id
    np.testing.assert_array_equal(copy.template.uvs, model.template.uvs)
    np.testing.assert_array_equal(copy.template.uv_polygons, model.template.uv_polygons)


def test_a_model_of_ones_own_keeps_the_layout_that_it_was_trained_with(tmp_path):
    stored, about = read_checkpoint(asset_path("pca.safetensors"))
    own = tmp_path / "pca.safetensors"
    write_checkpoint(own, stored | {"model.mean": stored["model.mean"] * np.float32(1.01)}, about)
    template = load_model(own).template
    np.testing.assert_array_equal(template.uvs, stored["template.uvs"])
    np.testing.assert_array_equal(template.uv_polygons, stored["template.uv_polygons"])
    assert load_model(own).model_id != load_model(kind="pca").model_id
