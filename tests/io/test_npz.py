import io
import tracemalloc
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from caricli.errors import InputError, OutputError
from caricli.io import npz
from caricli.io.npz import read_npz, take_array, write_npz


def header(descr="'<f8'", shape="(3,)", extra=""):
    text = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, {extra}}}".encode()
    return b"\x93NUMPY\1\0" + len(text).to_bytes(2, "little") + text


def write_zip(path, members, compression=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, data in members.items():
            archive.writestr(name, data)


VALUES = arrays(
    st.sampled_from(["f4", "f8", "f2", "i4", "i8", "u1", "?", ">f4", "<U3", "S2"]).map(np.dtype),
    array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(values=st.dictionaries(st.from_regex(r"[a-z_]{1,8}", fullmatch=True), VALUES, min_size=1, max_size=4))
def test_round_trip(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("npz") / "a.npz"
    write_npz(path, values)
    back = read_npz(path)
    assert list(back) == list(values)
    for name, value in values.items():
        np.testing.assert_array_equal(back[name], value)
        assert back[name].dtype == value.dtype.newbyteorder("=") and back[name].shape == value.shape
        assert back[name].flags.writeable
        np.testing.assert_array_equal(np.load(path, allow_pickle=False)[name], value)


def test_same_arrays_same_bytes(tmp_path, monkeypatch):
    write_npz(tmp_path / "a.npz", {"b": np.arange(1000), "a": np.array("text")})
    monkeypatch.setattr("time.time", lambda: 2e9)
    write_npz(tmp_path / "b.npz", {"b": np.arange(1000), "a": np.array("text")})
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize("order", "<>")
def test_text_that_could_not_be_read_again_is_not_written(tmp_path, order):
    names = np.array(["a", "b\udcff"]).astype(f"{order}U2")
    with pytest.raises(OutputError, match=r"a\.npz: names: expected text, found codes that are no characters"):
        write_npz(tmp_path / "a.npz", {"x": np.zeros(3), "names": names})
    assert not (tmp_path / "a.npz").exists()
    write_npz(tmp_path / "a.npz", {"names": names[:1], "none": np.zeros(2, "<U0")})


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_files_of_numpy(tmp_path, save):
    save(tmp_path / "a.npz", x=np.asfortranarray(np.arange(6.0).reshape(2, 3)), y=np.arange(3, dtype=">i2"))
    back = read_npz(tmp_path / "a.npz")
    np.testing.assert_array_equal(back["x"], [[0, 1, 2], [3, 4, 5]])
    np.testing.assert_array_equal(back["y"], [0, 1, 2])
    assert back["y"].dtype.isnative


def test_objects_are_never_loaded(tmp_path):
    class Trap:
        def __reduce__(self):
            return (pytest.fail, ("a pickle ran",))

    np.savez(tmp_path / "a.npz", x=np.array([Trap()], dtype=object))
    with pytest.raises(InputError, match="a.npz: x: expected numbers or text, found Python objects"):
        read_npz(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (header() + bytes(16), r"expected 24 bytes for shape \(3,\) of float64, found 16"),
        (header() + bytes(32), "found 32"),
        (header(shape="(1000000000, 1000000000)"), "expected 8000000000000000000 bytes"),
        (header(shape="(99999999999999999999,)"), "dimensions"),
        (header(shape="(0, 99999999999)"), "dimensions"),
        (header(shape="(-1,)"), "found the header"),
        (header(shape="(" + "1," * 9 + ")"), "at most 8 dimensions"),
        (header(shape="(1 1,)"), "dimensions"),
        (header(descr="'<c16'"), "expected an array of numbers or text"),
        (header(descr="'<M8[s]'"), "expected an array of numbers or text"),
        (header(descr="[('a', '<f8')]"), "expected an array of numbers or text"),
        (header(descr="'|V8'"), "expected an array of numbers or text"),
        (header(descr="'<U0'"), "expected 0 bytes"),
        (header(descr="'<U9999999'"), "expected an array of numbers or text"),
        (header(extra="__import__('os')"), "expected an array of numbers or text"),
        (header(descr="'<U1'", shape="()") + b"\xff\xff\xff\xff", "codes that are no characters"),
        (header(descr="'<U1'", shape="()") + b"\x00\xd8\x00\x00", "codes that are no characters"),
        (header(descr="'|b1'", shape="()") + b"\x02", "expected true or false"),
        (b"\x93NUMPY\1\0\xff\xff" + bytes(100), "a header of at most"),
        (b"\x93NUMPY\2\0\xff\xff\xff\xff" + bytes(100), "a header of at most"),
        (b"\x93NUMPY\7\0", "expected an NPY array, found something else"),
        (b"\x80\x04\x95abc", "found a pickle"),
        (b"", "expected an NPY array"),
    ],
)
def test_lying_headers(tmp_path, data, message):
    write_zip(tmp_path / "a.npz", {"x.npy": data})
    with pytest.raises(InputError, match=message):
        read_npz(tmp_path / "a.npz")


def test_every_truncation_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    write_npz(path, {"x": np.arange(50.0)})
    data = path.read_bytes()
    for length in range(1, len(data)):
        path.write_bytes(data[:length])
        with pytest.raises(InputError):
            read_npz(path)


def test_damage_is_seen(tmp_path):
    path = tmp_path / "a.npz"
    write_zip(path, {"x.npy": header() + bytes(24)}, zipfile.ZIP_STORED)
    data = path.read_bytes()
    at = data.index(header()) + len(header()) + 5
    path.write_bytes(data[:at] + b"\1" + data[at + 1 :])
    with pytest.raises(InputError, match="a damaged one"):
        read_npz(path)


def test_expansion_is_capped_before_it_happens(tmp_path, monkeypatch):
    bomb = tmp_path / "bomb.npz"
    write_zip(bomb, {"x.npy": header(descr="'|u1'", shape=f"({2**24},)") + bytes(2**24)})
    assert bomb.stat().st_size < 2**17
    assert read_npz(bomb)["x"].shape == (2**24,)
    tracemalloc.start()
    with pytest.raises(InputError, match=f"at most {2**22} bytes of arrays"):
        read_npz(bomb, max_bytes=2**22)
    # The directory claims little, the data are large: reading stops where the claim ends.
    data = bytearray(bomb.read_bytes())
    size = (2**24 + len(header(descr="'|u1'", shape=f"({2**24},)"))).to_bytes(4, "little")
    bomb.write_bytes(data.replace(size, (10000).to_bytes(4, "little")))
    with pytest.raises(InputError):
        read_npz(bomb, max_bytes=2**22)
    # The directory claims much, the data are small.
    small = tmp_path / "small.npz"
    write_zip(small, {"x.npy": header() + bytes(24)})
    data = small.read_bytes()
    size = (len(header()) + 24).to_bytes(4, "little")
    small.write_bytes(data.replace(size, (2**29).to_bytes(4, "little")))
    with pytest.raises(InputError, match="found only"):
        read_npz(small)
    assert tracemalloc.get_traced_memory()[1] < 2**22
    tracemalloc.stop()


def test_odd_archives(tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    array = header() + bytes(24)
    for members, message in [
        ({}, "found none"),
        ({"x.txt": b"hello"}, "another kind of file"),
        ({"x.npy": array, "x": array}, "one twice"),
    ]:
        write_zip(path, members)
        with pytest.raises(InputError, match=message):
            read_npz(path)
    write_zip(path, {"x.npy": array}, zipfile.ZIP_BZIP2)
    with pytest.raises(InputError, match="stored or deflated"):
        read_npz(path)
    write_zip(path, {"x.npy": array, "y.npy": array})
    monkeypatch.setattr(npz, "MAX_NPZ_MEMBERS", 1)
    with pytest.raises(InputError, match="at most 1 arrays"):
        read_npz(path)
    write_zip(path, {f"{k:0200}.npy": array for k in range(3)})
    with pytest.raises(InputError, match="a directory of"):
        read_npz(path)


def test_a_hidden_large_directory_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    write_zip(path, {"x.npy": header() + bytes(24)})
    data = path.read_bytes()
    path.write_bytes(data[:-22] + b"PK\x06\x07" + bytes(16) + data[-22:])
    with pytest.raises(InputError, match="found a directory"):
        read_npz(path)


def test_a_pickle_is_named(tmp_path):
    (tmp_path / "a.npz").write_bytes(b"\x80\x04\x95\0\0")
    with pytest.raises(InputError, match="expected an NPZ file, found a pickle"):
        read_npz(tmp_path / "a.npz")


def test_writing_refuses(tmp_path, monkeypatch):
    with pytest.raises(TypeError, match="object"):
        write_npz(tmp_path / "a.npz", {"x": np.array([None])})
    monkeypatch.setattr(npz, "MAX_NPZ_BYTES", 100)
    with pytest.raises(OutputError, match="at most 100 bytes"):
        write_npz(tmp_path / "b.npz", {"x": np.zeros(100)})
    with pytest.raises(OutputError, match="cannot be written"):
        write_npz(tmp_path / "missing" / "b.npz", {"x": np.zeros(1)})


def test_arrays_from_a_stream_are_read_to_the_end():
    data = header() + bytes(24)
    np.testing.assert_array_equal(npz.read_array(io.BytesIO(data), len(data), "a.npy"), [0, 0, 0])
    with pytest.raises(InputError, match="found more"):
        npz.read_array(io.BytesIO(data + b"x"), len(data), "a.npy")
    with pytest.raises(InputError, match="found 23"):
        npz.read_array(io.BytesIO(data[:-1]), len(data), "a.npy")


def test_numbers_that_signal_are_plain_unknowns(tmp_path):
    signalling = np.array([0x7F800001, 0x3F800000], np.uint32).view(np.float32)
    np.savez(tmp_path / "a.npz", values=signalling)
    values = read_npz(tmp_path / "a.npz")["values"]
    with np.errstate(all="raise"):
        np.testing.assert_array_equal(values.astype(np.float64), [np.nan, 1.0])


def test_an_array_is_taken_only_as_what_it_should_be():
    values = np.zeros((4, 3), np.float32)
    assert take_array({"a": values}, "a", "f", (None, 3)) is values
    assert take_array({"a": values}, "a", "if", (4, 3)) is values
    wrong = {"b": ("f", (None, 3)), "a": ("f", (None, 2)), "a ": ("f", (5, 3)), "a  ": ("f", (None, 3, 1)),
             "a   ": ("iu", (None, 3))}  # fmt: skip
    for key, (kinds, shape) in wrong.items():
        with pytest.raises(InputError, match="expected"):
            take_array({"a": values}, key.strip(), kinds, shape)
