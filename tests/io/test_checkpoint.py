import io
import json
import pickle
import tracemalloc
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from caricli.errors import InputError, OutputError
from caricli.io.checkpoint import read_checkpoint, write_checkpoint

VALUES = st.sampled_from(["f4", "f8", "i4", "i8", "u1", "?"]).flatmap(
    lambda dtype: arrays(
        dtype,
        array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
        elements=None if dtype in ("u1", "?") else {"min_value": -(10**9), "max_value": 10**9},
    )
)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    tensors=st.dictionaries(st.text(st.characters(exclude_categories=["Cs"]), max_size=5), VALUES, max_size=4),
    metadata=st.dictionaries(
        st.text(max_size=3, alphabet="abc"), st.integers() | st.floats(0, 1) | st.none(), max_size=3
    ),
)
def test_round_trip(tmp_path_factory, tensors, metadata):
    tensors.pop("__metadata__", None)
    metadata = {key: value for key, value in metadata.items() if not isinstance(value, int) or abs(value) < 10**30}
    path = tmp_path_factory.mktemp("model") / "a.safetensors"
    write_checkpoint(path, tensors, metadata)
    back, settings_back = read_checkpoint(path)
    assert settings_back == metadata and set(back) == set(tensors)
    for name, value in tensors.items():
        np.testing.assert_array_equal(back[name], value)
        assert back[name].dtype == value.dtype and back[name].shape == value.shape


def good(folder):
    write_checkpoint(folder / "a.safetensors", {"a": np.arange(3.0), "b": np.ones((2, 2), np.float16)}, {"kind": "pca"})
    return (folder / "a.safetensors").read_bytes()


def test_half_precision_is_read_as_single(tmp_path):
    good(tmp_path)
    tensors, metadata = read_checkpoint(tmp_path / "a.safetensors")
    assert tensors["b"].dtype == np.float32 and tensors["b"].tolist() == [[1, 1], [1, 1]]
    assert tensors["b"].flags.writeable and metadata == {"kind": "pca"}


def test_same_content_same_bytes_and_slices(tmp_path):
    first = good(tmp_path)
    assert good(tmp_path) == first
    matrix = np.arange(12.0).reshape(3, 4)
    write_checkpoint(tmp_path / "b.safetensors", {"x": matrix[:, ::2], "y": matrix.T}, {})
    tensors, _ = read_checkpoint(tmp_path / "b.safetensors")
    np.testing.assert_array_equal(tensors["x"], matrix[:, ::2])
    np.testing.assert_array_equal(tensors["y"], matrix.T)


def test_the_safetensors_library_agrees(tmp_path):
    from safetensors.numpy import load, save

    assert set(load(good(tmp_path))) == {"a", "b"}
    (tmp_path / "b.safetensors").write_bytes(save({"x": np.arange(4)}, {"caricli": "{}"}))
    np.testing.assert_array_equal(read_checkpoint(tmp_path / "b.safetensors")[0]["x"], [0, 1, 2, 3])


class Trap:
    def __reduce__(self):
        return (pytest.fail, ("a pickle ran",))


@pytest.mark.parametrize("protocol", range(6))
def test_a_pickle_is_refused(tmp_path, protocol):
    (tmp_path / "a.safetensors").write_bytes(pickle.dumps([Trap()], protocol))
    with pytest.raises(InputError, match="found a pickle" if protocol > 1 else "expected a .safetensors model"):
        read_checkpoint(tmp_path / "a.safetensors")


def test_a_torch_file_is_refused(tmp_path):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("model/data.pkl", pickle.dumps([Trap()]))
    (tmp_path / "a.safetensors").write_bytes(stream.getvalue())
    with pytest.raises(InputError, match="found a pickle or torch file, which could run code on load"):
        read_checkpoint(tmp_path / "a.safetensors")


def test_a_face_in_the_place_of_a_model_is_no_torch_file(tmp_path):
    np.savez(tmp_path / "face.npz", vertices=np.zeros((4, 3)))
    with pytest.raises(InputError, match=r"face\.npz: expected a \.safetensors model, found a zip archive"):
        read_checkpoint(tmp_path / "face.npz")


def build(header, data=b"", length=None):
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return (len(text) if length is None else length).to_bytes(8, "little") + text + data


def entry(**changes):
    return {"dtype": "F32", "shape": [2], "data_offsets": [0, 8], **changes}


META = {"__metadata__": {"caricli": "{}"}}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (build(META, length=2**62), "something else or a truncated file"),
        (build(META, length=2**25), "something else or a truncated file"),
        (build(b'{"__metadata__": {"caricli": "{}"}', length=34), "expected strict JSON"),
        (build(b"[" * 5000), "expected a .safetensors model"),
        (build(b'{"a":' * 5000), "nested at most"),
        (build(b'{"a": 1, "a": 2}'), "twice"),
        (build({}), "expected a model that caricli wrote"),
        (build({"__metadata__": {"format": "pt"}}), "expected a model that caricli wrote"),
        (build({"__metadata__": {"caricli": 3}}), "expected a model that caricli wrote"),
        (build({"__metadata__": {"caricli": "[1]"}}), "expected the model's settings"),
        (build({"__metadata__": {"caricli": "{NaN}"}}), "expected strict JSON"),
        (build({**META, "x": entry()}, bytes(4)), "within 4, found 0 to 8"),
        (build({**META, "x": entry()}, bytes(9)), "bytes, found"),
        (build({**META, "x": entry(data_offsets=[1, 9])}, bytes(9)), "expected bytes from 0"),
        (build({**META, "x": entry(), "y": entry()}, bytes(8)), "expected bytes from 8"),
        (build({**META, "x": entry(), "y": entry(data_offsets=[4, 12])}, bytes(12)), "expected bytes from 8"),
        (build({**META, "x": entry(shape=[2**39, 2**39])}, bytes(8)), "expected 8 bytes"),
        (build({**META, "x": entry(shape=[10**20])}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(shape=[-2])}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(shape=[True, 2])}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(shape="2")}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(shape=[1] * 9 + [2])}, bytes(8)), "expected 8 bytes"),
        (build({**META, "x": entry(data_offsets=[8, 0])}, bytes(8)), "expected -8 bytes"),
        (build({**META, "x": entry(data_offsets=[0])}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(dtype="BF16")}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(dtype=[])}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": 3}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry(more=1)}, bytes(8)), "expected dtype, shape and data_offsets"),
        (build({**META, "x": entry()}, np.array([1, np.nan], np.float32).tobytes()), "x: expected finite numbers"),
        (build({**META, "x": entry()}, np.array([1, np.inf], np.float32).tobytes()), "x: expected finite numbers"),
        (build({**META, "x": entry(dtype="BOOL", shape=[8])}, b"\2" * 8), "x: expected true or false"),
        (b"<!DOCTYPE html><html><body>not found</body></html>", "an HTML or XML page"),
        (b"short", "something else or a truncated file"),
    ],
)
def test_malformed(tmp_path, data, message):
    path = tmp_path / "a.safetensors"
    path.write_bytes(data)
    tracemalloc.start()
    with pytest.raises(InputError, match=message) as caught:
        read_checkpoint(path)
    assert tracemalloc.get_traced_memory()[1] < 2**22
    tracemalloc.stop()
    assert "a.safetensors" in str(caught.value) and "\n" not in str(caught.value)


def test_every_truncation_is_refused(tmp_path):
    data = good(tmp_path)
    for length in range(1, len(data)):
        (tmp_path / "a.safetensors").write_bytes(data[:length])
        with pytest.raises(InputError):
            read_checkpoint(tmp_path / "a.safetensors")


def test_writing_refuses(tmp_path):
    with pytest.raises(OutputError, match="expected finite numbers"):
        write_checkpoint(tmp_path / "b.safetensors", {}, {"x": float("nan")})
    with pytest.raises(OutputError, match="x: expected finite numbers of at most"):
        write_checkpoint(tmp_path / "b.safetensors", {"x": np.array([np.nan])}, {})
    with pytest.raises(OutputError, match="cannot be written"):
        write_checkpoint(tmp_path / "missing" / "b.safetensors", {}, {})
    assert list(tmp_path.iterdir()) == []


def test_a_header_length_that_begins_like_a_pickle_is_none(tmp_path):
    path = tmp_path / "model.safetensors"
    for padding in range(0x200, 0x600):
        write_checkpoint(path, {"w": np.ones(3, np.float32)}, {"padding": "x" * padding})
        if path.read_bytes()[0] == 0x80:
            break
    assert path.read_bytes()[0] == 0x80 and 2 <= path.read_bytes()[1] <= 5
    assert read_checkpoint(path)[1] == {"padding": "x" * padding}
