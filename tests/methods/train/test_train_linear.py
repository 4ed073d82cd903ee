from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.methods.train.train_linear import train_linear
from caricli.models.checkpoint import model_from_checkpoint
from caricli.models.kernel.config import KernelConfig
from caricli.models.pca.config import PcaConfig


@pytest.fixture(scope="module")
def data(head_template, people):
    """Stands in for a Dataset of 12 heads, of which the last four are for tests."""
    splits = {"train": range(8), "validation": (), "test": range(8, 12)}
    return SimpleNamespace(
        template=head_template,
        vertices=people[:12].astype(np.float32),
        rows=lambda split: np.isin(np.arange(12), list(splits[split])),
    )


def test_what_is_measured_is_what_is_written(data):
    calls = []
    training = train_linear("pca", data, PcaConfig(dimension=5), {"who": "me"}, lambda *call: calls.append(call))
    again = model_from_checkpoint(*training.checkpoint, "again")
    assert again.model_id == training.model.model_id == training.figures["model_id"]
    assert training.checkpoint[1]["recipe"] == {"who": "me"}
    # A split without meshes has no error; only a morphable model tells who from what.
    assert [*training.errors] == ["train", "test"] and "agreement" not in training.figures
    assert training.errors["test"].meshes == 4
    assert 0 < training.errors["train"].percent < training.errors["test"].percent
    assert calls == [(0, 2), (1, 2), (2, 2)]


def test_too_few_meshes_are_refused(data):
    few = SimpleNamespace(**vars(data) | {"rows": lambda split: np.arange(12) < 2})
    with pytest.raises(InputError, match="at least 3 meshes in the dataset's train split, found 2"):
        train_linear("pca", few, PcaConfig(), {})


def test_the_number_of_threads_changes_no_byte(data):
    trained = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            trained.append(train_linear("kernel", data, KernelConfig(dimension=5), {}).checkpoint[0])
    for name, tensor in trained[0].items():
        np.testing.assert_array_equal(tensor, trained[1][name], err_msg=name)
