import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.models.checkpoint import model_from_checkpoint, model_to_checkpoint
from caricli.models.model_id import model_id
from caricli.structures import SeenPeople

RECIPE = {"command": "train", "count": 40}


def rebuilt(model, path):
    tensors, metadata = model_to_checkpoint(model, RECIPE)
    write_checkpoint(path, tensors, metadata)
    return model_from_checkpoint(*read_checkpoint(path), path.name)


def test_a_model_rebuilds_itself_from_its_file(model, tmp_path):
    loaded = rebuilt(model, tmp_path / "model.safetensors")
    assert type(loaded) is type(model)
    template, expected = loaded.template, model.template
    assert np.abs(template.vertices - expected.vertices).max() < 1e-7
    for name in ("faces", "polygons", "uv_polygons"):
        assert np.array_equal(getattr(template, name), getattr(expected, name))
    assert np.allclose(template.uvs, expected.uvs, atol=1e-6)
    assert template.topology_id == expected.topology_id
    assert template.annotation.source == expected.annotation.source
    latents = model.prior.sample(np.random.default_rng(0), 3)
    # Half precision of the basis: a thousandth of what the basis moves.
    moved = np.linalg.norm(model.decode(latents) - model.decode(0 * latents), axis=-1).mean()
    assert np.linalg.norm(loaded.decode(latents) - model.decode(latents), axis=-1).mean() < 2e-3 * moved
    assert np.allclose(loaded.encode(model.decode(latents)), model.encode(model.decode(latents)), atol=5e-3)


def test_the_id_is_the_same_in_memory_and_in_every_file(ball_model, tmp_path):
    once = rebuilt(ball_model, tmp_path / "once.safetensors")
    twice = rebuilt(once, tmp_path / "twice.safetensors")
    assert len(ball_model.model_id) == 64
    assert once.model_id == twice.model_id == ball_model.model_id
    assert all(np.array_equal(value, twice.tensors()[name]) for name, value in once.tensors().items())


def test_the_id_tells_weights_names_and_kinds_apart(ball_model):
    tensors = ball_model.tensors()
    name, value = next(iter(tensors.items()))
    changed = tensors | {name: value + np.float32(1e-3)}
    renamed = {name + "x": value for name, value in tensors.items()}
    ids = {model_id(kind, t) for kind in ("pca", "intrinsic") for t in (tensors, changed, renamed)}
    assert len(ids) == 6


def test_the_recipe_travels_along(ball_model, tmp_path):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    write_checkpoint(tmp_path / "model.safetensors", tensors, metadata)
    assert read_checkpoint(tmp_path / "model.safetensors")[1]["recipe"] == RECIPE


def test_a_template_without_uvs_stays_without(ball_model, tmp_path):
    template = rebuilt(ball_model, tmp_path / "model.safetensors").template
    assert template.uvs is None and template.uv_polygons is None


@pytest.mark.parametrize(
    "change",
    [
        {"schema": "caricli.model/2"},
        {"schema": None},
        {"kind": "siren"},
        {"kind": None},
        {"kind": ["pca"]},
        {"annotation": None},
        {"annotation": {"ibug68": list(range(67))}},
        {"annotation": {"ibug68": [300] * 68}},
        {"annotation": [1, 2]},
    ],
    ids=str,
)
def test_foreign_metadata_is_refused(ball_model, change):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    with pytest.raises(InputError, match="^m.safetensors: ") as refusal:
        model_from_checkpoint(tensors, metadata | change, "m.safetensors")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("key", ["schema", "kind", "annotation"])
def test_missing_metadata_is_refused(ball_model, key):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    del metadata[key]
    with pytest.raises(InputError, match="^m.safetensors: "):
        model_from_checkpoint(tensors, metadata, "m.safetensors")


@pytest.mark.parametrize("name", ["model.extra", "junk"])
def test_a_tensor_that_no_such_model_has_is_refused(name, ball_model):
    tensors, metadata = model_to_checkpoint(ball_model, {})
    with pytest.raises(InputError, match=f"not a valid model: with {name}, which is of no {ball_model.kind} model"):
        model_from_checkpoint(tensors | {name: np.zeros((3, 3), np.float32)}, metadata, "a")


def test_a_missing_tensor_is_refused(ball_model):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    for name in tensors:
        others = {other: value for other, value in tensors.items() if other != name}
        with pytest.raises(InputError, match="^m.safetensors: not a valid model"):
            model_from_checkpoint(others, metadata, "m.safetensors")


def nan_in(array):
    array = np.array(array)
    array.flat[3] = np.nan
    return array


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("model.mean", lambda a: a[:-1]),
        ("model.mean", lambda a: a[:, :2]),
        ("model.mean", nan_in),
        ("model.basis", lambda a: a[:, :-1]),
        ("model.basis", lambda a: a[..., :-1]),
        ("model.basis", lambda a: a[0]),
        ("model.basis", lambda a: a.astype(np.float32) * np.inf),
        ("template.vertices", lambda a: a[:-1]),
        ("template.vertices", lambda a: a[:, :2]),
        ("template.vertices", lambda a: a.ravel()),
        ("template.faces", lambda a: a + 1),
        ("template.faces", lambda a: a - 1),
        ("template.faces", lambda a: a[:, :2]),
        ("template.faces", lambda a: a[:0]),
        ("template.faces", lambda a: a.astype(np.float32)),
        ("template.polygons", lambda a: a + 1),
        ("template.polygons", lambda a: a - 2),
        ("template.polygons", lambda a: a.ravel()),
    ],
)
def test_a_damaged_tensor_is_refused(ball_components, name, damage):
    tensors, metadata = model_to_checkpoint(ball_components, RECIPE)
    tensors[name] = damage(tensors[name])
    with pytest.raises(InputError, match="^m.safetensors: "):
        model_from_checkpoint(tensors, metadata, "m.safetensors")


@pytest.mark.parametrize(
    "change",
    [
        {"template.uvs": None},
        {"template.uv_polygons": None},
        {"template.uvs": np.zeros((2, 2), np.float32)},
        {"template.uvs": np.zeros((20000, 3), np.float32)},
        {"template.uv_polygons": np.zeros((5, 4), np.int32)},
        {"template.uv_polygons": np.full((4178, 4), -2, np.int32)},
    ],
    ids=["no uvs", "no uv polygons", "too few uvs", "uvs of three", "other polygons", "below -1"],
)
def test_uvs_that_do_not_fit_are_refused(pca, change):
    tensors, metadata = model_to_checkpoint(pca, RECIPE)
    tensors = {name: value for name, value in (tensors | change).items() if value is not None}
    with pytest.raises(InputError, match="its template is not a mesh"):
        model_from_checkpoint(tensors, metadata, "m.safetensors")


def test_directions_that_say_the_same_are_refused(ball_model):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    basis = tensors["model.basis"]
    for twice in (np.concatenate([basis[:1], basis[:-1]]), 0 * basis):
        with pytest.raises(InputError, match="^m.safetensors: not a valid model: [0-9]+ directions that are not indep"):
            model_from_checkpoint(tensors | {"model.basis": twice}, metadata, "m.safetensors")
    with pytest.raises(InputError, match="^m.safetensors: model.basis: expected finite numbers of at most"):
        model_from_checkpoint(tensors | {"model.basis": np.full(1, 1e300)}, metadata, "m.safetensors")


def test_models_share_a_template_that_is_the_same_in_everything(ball_model, tmp_path):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    first, same = (model_from_checkpoint(tensors, metadata, "m") for _ in range(2))
    assert first.template is same.template
    other = {**metadata["annotation"], "regions": {"face": list(range(10))}}
    third = model_from_checkpoint(tensors, metadata | {"annotation": other}, "m")
    assert third.template.mask("face").sum() == 10 < first.template.mask("face").sum()
    moved = tensors | {"template.vertices": 2 * tensors["template.vertices"]}
    assert model_from_checkpoint(moved, metadata, "m").template.height == pytest.approx(2 * first.template.height)


def test_whom_a_model_was_trained_with_comes_from_its_recipe(ball_model):
    tensors, metadata = model_to_checkpoint(ball_model, RECIPE)
    assert model_from_checkpoint(tensors, metadata, "m").seen is None
    people = SeenPeople(frozenset({"aa", "bb"}), frozenset({"cc"}))
    recipe = RECIPE | people.as_recipe()
    assert model_from_checkpoint(tensors, metadata | {"recipe": recipe}, "m").seen == people
