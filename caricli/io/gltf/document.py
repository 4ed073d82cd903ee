"""The arrays of a glTF document; nothing in it is trusted, and nothing is allocated before it is checked."""

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.gltf.format import DTYPES, TYPES
from caricli.io.strict_json import take, take_whole
from caricli.limits import MAX_CORNERS

_MAX_STRIDE = 252


class Document:
    """A glTF document and its buffers. Its methods raise InputError where the document lies.

    content: the JSON object. buffers: the bytes of its buffers that are inside the file, in their order.
    """

    def __init__(self, content: dict, buffers: list[memoryview]) -> None:
        self.content = content
        self.buffers = buffers

    def item(self, holder: dict, key: str, container: str) -> dict:
        """The object of a container that a number points to."""
        items = take(self.content, container, list, [])
        index = holder.get(key)
        if type(index) is not int or not 0 <= index < len(items) or not isinstance(items[index], dict):
            raise InputError(f"{shown(key, 40)}: expected the number of one of {len(items)} {container}, found another")
        return items[index]

    def view_bytes(self, view: dict) -> memoryview:
        """The bytes of a buffer view."""
        buffer = self.item(view, "buffer", "buffers")
        if "uri" in buffer or view["buffer"] >= len(self.buffers):
            raise InputError("buffers: expected one inside the file, found another file")
        content = self.buffers[view["buffer"]]
        start = take_whole(view, "byteOffset", 0, len(content), 0)
        return content[start : start + take_whole(view, "byteLength", 1, len(content) - start)]

    def floats(self, holder: dict, key: str, width: int, count: int) -> np.ndarray:
        """Floats (count,W), zeros where the holder has none; whole numbers that stand for fractions become those."""
        if key not in holder:
            return np.zeros((count, width), np.float32)
        accessor = self.item(holder, key, "accessors")
        # Before anything is allocated by it.
        if accessor.get("count") != count:
            raise InputError(f"{key}: expected {count} values, found {shown(accessor.get('count'), 40)}")
        values = self.accessor(accessor, width)
        if values.dtype.kind == "f":
            return values
        if accessor.get("normalized") is not True:
            raise InputError(f"{key}: expected floats, found {values.dtype}")
        return np.float32(1 / np.iinfo(values.dtype).max) * values.astype(np.float32)

    def accessor(self, accessor: dict, width: int) -> np.ndarray:
        """The values (N,W) of an accessor, sparse ones filled in."""
        if accessor.get("type") != TYPES[width]:
            raise InputError(f"accessor: expected the type {TYPES[width]}, found {shown(accessor.get('type'), 40)}")
        count = take_whole(accessor, "count", 1, MAX_CORNERS)
        dtype = _dtype(accessor)
        if "bufferView" in accessor:
            values = self._view(accessor, dtype, count, width)
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            sparse = take(accessor, "sparse", dict)
            changed = take_whole(sparse, "count", 1, count)
            places = take(sparse, "indices", dict)
            where = self._view(places, _dtype(places), changed, 1)[:, 0]
            if where.dtype.kind == "f" or where.max() >= count:
                raise InputError(f"sparse: expected indices below {count}, found others")
            values[where] = self._view(take(sparse, "values", dict), dtype, changed, width)
        if not np.isfinite(values).all():
            raise InputError("accessor: expected finite numbers, found others")
        return values

    def _view(self, holder: dict, dtype: np.dtype, count: int, width: int) -> np.ndarray:
        """A copy of the values (N,W) that lie in a view, dense or interleaved."""
        view = self.item(holder, "bufferView", "bufferViews")
        content = self.view_bytes(view)
        offset = take_whole(holder, "byteOffset", 0, len(content), 0)
        size = dtype.itemsize * width
        stride = take_whole(view, "byteStride", size, _MAX_STRIDE, size)
        needed = offset + stride * (count - 1) + size
        if needed > len(content):
            raise InputError(f"bufferView: expected at least {needed} bytes, found {len(content)}")
        return np.ndarray((count, width), dtype, content, offset, (stride, dtype.itemsize)).copy()


def _dtype(holder: dict) -> np.dtype:
    code = take_whole(holder, "componentType", min(DTYPES), max(DTYPES))
    if code not in DTYPES:
        raise InputError(f"componentType: expected one of {[*DTYPES]}, found {code}")
    return DTYPES[code]
