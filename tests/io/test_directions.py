import dataclasses

import numpy as np
import pytest

from caricli.errors import InputError, OutputError
from caricli.io.directions import read_directions, write_directions
from caricli.io.npz import read_npz, write_npz
from caricli.structures import Directions


def some():
    normals = np.array([[0.6, 0.8, 0, 0], [0, 0, -1.0, 0], [0.5, 0.5, 0.5, 0.5]])
    return Directions(
        names=("BigNose", "Smile", "rond"),
        normals=normals,
        gradients=0.5 * normals,
        auc=np.array([0.99, 1.0, 0.5]),
        positives=np.array([10, 20, 30]),
        count=40,
        cost=np.array([0.1, 1.0, 0.001]),
        change=np.array([0.9, -0.1, 0.0]),
        model_id="a" * 64,
        recipe={"command": "train semantic", "inputs": {"dataset/dataset.json": "0" * 64}, "seed": 3},
        people=np.array([[1.0, 0, 0, 0], [0, 2, 0, -1]]),
    )


def test_all_fields_come_back(tmp_path):
    write_directions(tmp_path / "a.npz", some())
    back = read_directions(tmp_path / "a.npz")
    for field in dataclasses.fields(Directions):
        value, expected = getattr(back, field.name), getattr(some(), field.name)
        assert type(value) is type(expected), field.name
        if isinstance(value, np.ndarray):
            np.testing.assert_allclose(value, expected, rtol=1e-6)
        else:
            assert value == expected
    assert np.abs(np.linalg.norm(back.normals, axis=1) - 1).max() < 1e-12
    stored = read_npz(tmp_path / "a.npz")
    assert stored["schema"] == "caricli.directions/1" and stored["normals"].dtype == np.float32


def test_the_same_directions_give_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        write_directions(tmp_path / f"{name}.npz", some())
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"schema": np.array("caricli.face/1")}, "schema"),
        ({"auc": None}, "'auc' found none"),
        ({"more": np.zeros(3)}, "'more'"),
        ({"normals": np.zeros((3, 4), np.float32)}, "unit vectors"),
        ({"normals": np.eye(4, dtype=np.float32)}, "names: expected the shape"),
        ({"normals": np.ones(3, np.float32)}, "normals: expected"),
        ({"normals": np.ones((3, 4), np.int32)}, "normals: expected float32"),
        ({"gradients": np.ones((3, 5), np.float32)}, "gradients"),
        ({"gradients": np.full((3, 4), np.nan, np.float32)}, "gradients: expected finite"),
        ({"people": np.ones((2, 5), np.float32)}, "people: expected the shape"),
        ({"auc": np.array([0.5, 2, 0.5], np.float32)}, "auc"),
        ({"change": np.array([0.5, np.inf, 0.5], np.float32)}, "change: expected finite"),
        ({"positives": np.array([1, 2, 41], np.int32)}, "positives"),
        ({"names": np.array(["a", "b", "a"])}, "distinct"),
        ({"names": np.array(["a", "b", ""])}, "names"),
        ({"model_id": np.array("")}, "model_id"),
        ({"recipe": np.array("[1]")}, "recipe"),
        ({"recipe": np.array("{")}, "recipe"),
    ],
)
def test_other_content_is_refused(tmp_path, changes, words):
    write_directions(tmp_path / "a.npz", some())
    arrays = {k: v for k, v in (read_npz(tmp_path / "a.npz") | changes).items() if v is not None}
    write_npz(tmp_path / "b.npz", arrays)
    with pytest.raises(InputError, match="b.npz") as caught:
        read_directions(tmp_path / "b.npz")
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_truncated_and_other_files_are_refused(tmp_path):
    write_directions(tmp_path / "a.npz", some())
    data = (tmp_path / "a.npz").read_bytes()
    for content in (data[:100], data[:-30], b"", b"\x80\x04pickle"):
        (tmp_path / "b.npz").write_bytes(content)
        with pytest.raises(InputError, match="b.npz"):
            read_directions(tmp_path / "b.npz")


def test_what_could_not_be_read_is_not_written(tmp_path):
    with pytest.raises(OutputError, match="model_id: expected text, found none"):
        write_directions(tmp_path / "a.npz", dataclasses.replace(some(), model_id=""))
    assert not (tmp_path / "a.npz").exists()
