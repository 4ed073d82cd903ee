from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from caricli.errors import InputError, OutputError
from caricli.io.checkpoint import read_checkpoint, write_checkpoint
from caricli.io.training_state import read_state, write_state
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import UnitBox
from caricli.models.deformable.networks import HyperSiren
from caricli.store.models import load_model
from caricli.store.training_run import FILES, LOG, MODEL, REPORT, STATE, Beginning, TrainingRun
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

CONFIG = DeformableConfig(
    latent=3, width=8, layers=2, hidden=8, epochs=4, batch=4, points=30, precision="float32", validate_every=2,
    smoothness_weight=0.0,
)  # fmt: skip
RECIPE = {"command": "train deformable", "config": asdict(CONFIG), "inputs": {"dataset.json": "0" * 64}}


@pytest.fixture(scope="module")
def template(ball):
    vertices, faces = ball
    annotation = parse_annotation({"ibug68": list(range(68))}, len(vertices), "ball")
    return Template(vertices, faces, annotation=annotation)


@pytest.fixture
def training(template):
    """A new training of the same shapes with the same seed, whenever it is called."""
    import torch

    scales = 1 + 0.2 * np.random.default_rng(0).normal(size=(8, 1, 3))
    shapes = (template.vertices * scales).astype(np.float32)

    def begin(config=CONFIG):
        meshes = TrainingMeshes(Surface(UnitBox(template.vertices), template.faces), shapes[:6], shapes[6:])
        network = HyperSiren(config.size(), torch.Generator().manual_seed(0))
        return AutoDecoderTraining(network, meshes, config)

    return begin


def test_a_run_that_was_left_goes_on_to_the_same_model(training, template, tmp_path):
    whole = TrainingRun(tmp_path / "whole", RECIPE, Beginning())
    lines = list(whole.follow(training(), template))
    assert [line["epoch"] for line in lines] == [1, 2, 3, 4]
    assert sorted(path.name for path in (tmp_path / "whole").iterdir()) == sorted({*FILES} - {"model.json"})
    assert load_model(tmp_path / "whole" / MODEL).kind == "deformable"
    first = training()
    first.config = replace(CONFIG, checkpoint_seconds=0)
    for line in TrainingRun(tmp_path / "left", RECIPE, Beginning()).follow(first, template):
        if line["epoch"] == 3:
            break
    second = TrainingRun(tmp_path / "left", RECIPE, Beginning(resume=True))
    assert [line["epoch"] for line in second.follow(training(), template)] == [4]
    assert (tmp_path / "left" / MODEL).read_bytes() == (tmp_path / "whole" / MODEL).read_bytes()
    assert len((tmp_path / "left" / LOG).read_text().splitlines()) == 4


def test_other_settings_or_data_are_said(training, template, tmp_path):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    other = RECIPE | {"config": RECIPE["config"] | {"seed": 3}}
    with pytest.raises(InputError, match=r"state\.pt: .*seed 0 there, 3 here"):
        TrainingRun(tmp_path, other, Beginning(resume=True))
    with pytest.raises(InputError, match="other data"):
        TrainingRun(tmp_path, RECIPE | {"inputs": {"dataset.json": "1" * 64}}, Beginning(resume=True))
    # Where the same data lie does not matter.
    TrainingRun(tmp_path, RECIPE | {"inputs": {"elsewhere.json": "0" * 64}}, Beginning(resume=True))


def test_the_same_data_in_another_order_are_others(training, template, tmp_path):
    inputs = {"a/dataset.json": "0" * 64, "b/dataset.json": "1" * 64}
    list(TrainingRun(tmp_path, RECIPE | {"inputs": inputs}, Beginning()).follow(training(), template))
    turned = {"b/dataset.json": "1" * 64, "a/dataset.json": "0" * 64}
    with pytest.raises(InputError, match="the same data in another order"):
        TrainingRun(tmp_path, RECIPE | {"inputs": turned}, Beginning(resume=True))
    moved = {"c/dataset.json": "0" * 64, "a/dataset.json": "1" * 64}
    TrainingRun(tmp_path, RECIPE | {"inputs": moved}, Beginning(resume=True))


def test_a_training_of_another_kind_is_said(training, template, tmp_path):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    other = RECIPE | {"command": "train gesture", "config": {"steps": 3}}
    expected = r"by `caricli train gesture`, found one by `caricli train deformable`; --overwrite begins anew$"
    with pytest.raises(InputError, match=expected):
        TrainingRun(tmp_path, other, Beginning(resume=True))


@pytest.mark.parametrize("damage", [lambda data: b"", lambda data: data[:-100]])
def test_a_state_that_is_damaged_is_refused_with_a_way_out(training, template, tmp_path, damage):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    (tmp_path / STATE).write_bytes(damage((tmp_path / STATE).read_bytes()))
    with pytest.raises(InputError, match=r"state\.pt: expected .*; --overwrite begins anew$"):
        TrainingRun(tmp_path, RECIPE, Beginning(resume=True))


def test_a_model_that_is_not_this_trainings_is_refused(training, template, tmp_path):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    run = TrainingRun(tmp_path, RECIPE, Beginning(resume=True))
    tensors, metadata = read_checkpoint(tmp_path / MODEL)
    other = metadata["recipe"] | {"config": metadata["recipe"]["config"] | {"seed": 5}}
    for recipe, words in (
        (other, r"another \(seed 5 there, 0 here\)"),
        (None, "recipe: expected dict, found NoneType"),
    ):
        write_checkpoint(tmp_path / MODEL, tensors, metadata | {"recipe": recipe})
        refused = pytest.raises(InputError, match=rf"model\.safetensors: .*{words}; --overwrite begins anew$")
        with refused:
            TrainingRun(tmp_path, RECIPE, Beginning(resume=True))
        with refused:
            run.finish(None)
    assert not (tmp_path / REPORT).exists()


@pytest.mark.parametrize("damage", [Path.unlink, lambda path: path.write_bytes(path.read_bytes()[:-100])])
def test_a_model_that_is_missing_or_damaged_is_refused_with_a_way_out(training, template, tmp_path, damage):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    damage(tmp_path / MODEL)
    with pytest.raises(InputError, match=r"model\.safetensors: .*; --overwrite begins anew$"):
        TrainingRun(tmp_path, RECIPE, Beginning(resume=True))


def test_what_is_there_is_kept_unless_it_is_to_be_replaced(training, template, tmp_path):
    (tmp_path / STATE).write_text("mine")
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(OutputError, match="--resume"):
        TrainingRun(tmp_path, RECIPE, Beginning())
    assert (tmp_path / STATE).exists()
    TrainingRun(tmp_path, RECIPE, Beginning(overwrite=True, writes=False))
    assert (tmp_path / STATE).exists()
    (tmp_path / REPORT).write_text("mine")
    run = TrainingRun(tmp_path, RECIPE, Beginning(overwrite=True))
    assert (tmp_path / STATE).read_text() == (tmp_path / REPORT).read_text() == "mine"
    next(run.follow(training(), template))
    assert sorted(path.name for path in tmp_path.iterdir()) == [LOG, "thesis.txt"]
    with pytest.raises(OutputError, match="found a file"):
        TrainingRun(tmp_path / "thesis.txt", RECIPE, Beginning())


def test_a_finished_model_without_its_state_is_kept(tmp_path):
    for left in ((MODEL, REPORT, LOG), (MODEL,), (REPORT,)):
        for name in left:
            (tmp_path / name).write_text("mine")
        with pytest.raises(
            OutputError, match=r"model\.(json|safetensors): expected state\.pt .*; --overwrite begins anew"
        ):
            TrainingRun(tmp_path, RECIPE, Beginning(resume=True))
        assert {path.name for path in tmp_path.iterdir()} == set(left)
        for path in tmp_path.iterdir():
            path.unlink()


def test_a_run_that_was_left_before_its_first_state_begins_anew(training, template, tmp_path):
    whole = TrainingRun(tmp_path / "whole", RECIPE, Beginning())
    list(whole.follow(training(), template))
    left = tmp_path / "left"
    for line in TrainingRun(left, RECIPE, Beginning()).follow(training(), template):
        if line["epoch"] == 2:
            break
    assert sorted(path.name for path in left.iterdir()) == [LOG, MODEL]
    assert len(list(TrainingRun(left, RECIPE, Beginning(resume=True)).follow(training(), template))) == 4
    assert (left / MODEL).read_bytes() == (tmp_path / "whole" / MODEL).read_bytes()


def test_stopped_among_old_files_it_can_be_resumed(training, template, tmp_path):
    """Old files go one after the other; whichever are left, --resume goes on from a state or begins anew."""
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    (tmp_path / REPORT).write_text("{}")
    for name in FILES:
        (tmp_path / name).unlink()
        run = TrainingRun(tmp_path, RECIPE, Beginning(resume=True))
        assert (run.state is None) == (name != REPORT)


def test_an_input_is_no_output(tmp_path):
    (tmp_path / MODEL).write_text("mine")
    for source in (tmp_path / MODEL, tmp_path, tmp_path / "." / "x" / ".."):
        for beginning in (Beginning(overwrite=True, inputs=(None, source)), Beginning(resume=True, inputs=(source,))):
            with pytest.raises(OutputError, match="found one of the inputs"):
                TrainingRun(tmp_path, RECIPE, beginning)
    assert (tmp_path / MODEL).read_text() == "mine"
    TrainingRun(tmp_path, RECIPE, Beginning(overwrite=True, inputs=(tmp_path / "others.safetensors",)))


SEEDS = (CONFIG, replace(CONFIG, seed=1))
ALONE = "expected to be the only training in this folder, found the log of another"


def test_of_two_trainings_that_begin_at_once_the_later_is_refused(training, template, tmp_path):
    first, second = (
        TrainingRun(tmp_path, RECIPE | {"config": asdict(config)}, Beginning()).follow(training(config), template)
        for config in SEEDS
    )
    next(first)
    with pytest.raises(OutputError, match=ALONE):
        next(second)
    assert len(list(first)) == 3


@pytest.mark.parametrize("epochs", [1, 2, 3])
def test_a_training_whose_folder_another_took_is_refused(training, template, tmp_path, epochs):
    recipes = [RECIPE | {"config": asdict(config)} for config in SEEDS]
    first = TrainingRun(tmp_path, recipes[0], Beginning())
    lines = first.follow(training(SEEDS[0]), template)
    for _ in range(epochs):
        next(lines)
    second = TrainingRun(tmp_path, recipes[1], Beginning(overwrite=True))
    list(second.follow(training(SEEDS[1]), template))
    files = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(OutputError, match=ALONE):
        list(lines)
    with pytest.raises(OutputError, match=ALONE):
        first.report({})
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == files


def test_what_a_killed_training_left_goes_when_one_is_done(training, template, tmp_path):
    for place, name in (("half____", STATE), ("done____", ".replaced-0"), ("other___", "face.obj"), ("mine", STATE)):
        (tmp_path / f".caricli-{place}").mkdir()
        (tmp_path / f".caricli-{place}" / name).write_text("half")
    (tmp_path / ".caricli-empty___").mkdir()  # of who has yet to write
    run = TrainingRun(tmp_path, RECIPE, Beginning())
    (tmp_path / ".caricli-later___").mkdir()
    (tmp_path / ".caricli-later___" / STATE).write_text("half")
    list(run.follow(training(), template))
    assert (tmp_path / ".caricli-half____").exists()
    run.report({})
    left = {path.name for path in tmp_path.iterdir()} - {*FILES}
    assert left == {".caricli-mine", ".caricli-other___", ".caricli-empty___", ".caricli-later___"}


def test_a_process_that_does_not_write_leaves_nothing(training, template, tmp_path):
    run = TrainingRun(tmp_path, RECIPE, Beginning(writes=False))
    lines = list(run.follow(training(), template))
    assert len(lines) == 4 and list(tmp_path.iterdir()) == []
    line = lines[0]
    assert 0 < line["train"] < 100 and line["validation"] is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda state: state.pop("latents"), "state.latents: expected a tensor .*, found NoneType"),
        (lambda state: state.update(codes=state["codes"][:0]), "state.codes: expected a tensor"),
        (lambda state: state.update(latents=state["latents"].double()), "of torch.float32, found .* of torch.float64"),
        (lambda state: state["network"].popitem(), "state.network: expected 'first.weight.*found others"),
        (lambda state: state.update(counters=[1, 2]), "state.counters: expected 3 values"),
        (lambda state: state.update(counters=["a", 1.0, 0]), "state.counters.0: expected int, found str"),
        (lambda state: state["optimiser"].update(param_groups=[]), "state.optimiser.param_groups: expected 2 values"),
        (lambda state: state["optimiser"]["state"][0].update(exp_avg=3), "state.optimiser.state.0.exp_avg: expected a"),
        (lambda state: state["code_optimiser"]["state"].popitem(), None),
        (lambda state: state.pop("log"), "a log of its epochs"),
        (lambda state: state.update(log=[]), "a log of its epochs"),
        (lambda state: state["log"][0].update(loss="low"), "a log of its epochs"),
        (lambda state: state.update(seconds=float("nan")), "a log of its epochs"),
    ],
)
def test_a_state_that_is_not_this_trainings_is_refused(training, template, tmp_path, change, words):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    state, recipe = read_state(tmp_path / STATE)
    change(state)
    write_state(tmp_path / STATE, state, recipe)
    if words is None:  # an optimiser that has not begun is one, too
        list(TrainingRun(tmp_path, RECIPE, Beginning(resume=True)).follow(training(), template))
        return
    with pytest.raises(InputError, match=rf"state\.pt: .*{words}.*; --overwrite begins anew$"):
        list(TrainingRun(tmp_path, RECIPE, Beginning(resume=True)).follow(training(), template))


def test_a_recipe_without_settings_is_refused(training, template, tmp_path):
    list(TrainingRun(tmp_path, RECIPE, Beginning()).follow(training(), template))
    state, recipe = read_state(tmp_path / STATE)
    for lacking in ({}, {"config": {}}, {"config": {}, "inputs": {"a": 3}}):
        write_state(tmp_path / STATE, state, lacking)
        with pytest.raises(InputError, match=r"state\.pt: expected a training with its settings and inputs"):
            TrainingRun(tmp_path, RECIPE, Beginning(resume=True))
