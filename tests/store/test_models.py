import pytest

from caricli.errors import InputError
from caricli.io.bundled import asset_path
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
    with pytest.raises(InputError, match="the model: its topology"):
        check_topology(model.template, fewer, "the model")
