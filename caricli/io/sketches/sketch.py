"""Sketches as JSON and SVG."""

from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, naming
from caricli.io.files import read_bytes
from caricli.io.outputs import write_bytes
from caricli.io.sketches.svg import is_svg, read_svg, write_svg
from caricli.io.strict_json import format_json, found_value, parse_json, refuse_others, take, take_whole
from caricli.limits import MAX_SKETCH_BYTES, MAX_SKETCH_SIDE, MAX_STROKES
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

SCHEMA = "caricli.sketch/1"
_KEYS = ("schema", "canvas", "strokes")
_STROKE_KEYS = ("kind", "curve", "width", "points", "pressure")
_DECIMALS = 4
_START = 4096
"""Bytes that tell the format."""


def read_sketch(path: str | Path) -> Sketch:
    """Read a sketch from JSON (docs/formats.md) or SVG, told by the content. Raises InputError when it is malformed."""
    data = read_bytes(path, MAX_SKETCH_BYTES, "a sketch")
    # A damaged SVG is one still.
    if is_svg(data[:_START]) or Path(path).suffix.lower() == ".svg":
        return read_svg(path)
    value = parse_json(data, path)
    with naming(path):
        return sketch_from_json(value)


def sketch_from_json(value: Any) -> Sketch:
    """The Sketch of a JSON value. Raises InputError when it is malformed."""
    if not isinstance(value, dict) or value.get("schema") != SCHEMA:
        schema = value.get("schema") if isinstance(value, dict) else None
        raise InputError(f"expected a sketch of the schema {SCHEMA!r}, found {found_value(schema)}")
    refuse_others(value, _KEYS)
    canvas = take(value, "canvas", dict)
    refuse_others(canvas, ("width", "height"))
    size = (take_whole(canvas, "width", 1, MAX_SKETCH_SIDE), take_whole(canvas, "height", 1, MAX_SKETCH_SIDE))
    entries = take(value, "strokes", list)
    if len(entries) > MAX_STROKES:
        raise InputError(f"strokes: expected at most {MAX_STROKES}, found {len(entries)}")
    strokes = []
    for number, entry in enumerate(entries):
        with naming(f"stroke {number}"):
            strokes.append(_stroke(entry))
    return Sketch(tuple(strokes), size)


def sketch_to_json(sketch: Sketch) -> dict[str, Any]:
    """The JSON value of a sketch."""
    width, height = sketch.size
    return {
        "schema": SCHEMA,
        "canvas": {"width": int(width), "height": int(height)},
        "strokes": [_entry(stroke) for stroke in sketch.strokes],
    }


def write_sketch(path: str | Path, sketch: Sketch) -> None:
    """Write a sketch as SVG where the name ends in .svg, else as JSON, a stroke a line.

    Raises OutputError when the file cannot be written.
    """
    if Path(path).suffix.lower() == ".svg":
        write_svg(path, sketch)
        return
    value = sketch_to_json(sketch)
    lines = [format_json(entry, path, None).rstrip("\n") for entry in value.pop("strokes")]
    head = format_json(value, path, None).rstrip("\n").removesuffix("}")
    body = ",\n".join(lines)
    write_bytes(path, f'{head}, "strokes": [\n{body}\n]}}\n'.encode())


def _entry(stroke: Stroke) -> dict[str, Any]:
    entry: dict[str, Any] = {"kind": str(stroke.kind)}
    if stroke.curve is not None:
        entry["curve"] = stroke.curve
    if stroke.width is not None:
        entry["width"] = round(float(stroke.width), _DECIMALS)
    entry["points"] = stroke.points.round(_DECIMALS).tolist()
    if stroke.pressure is not None:
        entry["pressure"] = stroke.pressure.round(_DECIMALS).tolist()
    return entry


def _stroke(entry: Any) -> Stroke:
    if not isinstance(entry, dict):
        raise InputError(f"expected an object with kind and points, found {found_value(entry)}")
    refuse_others(entry, _STROKE_KEYS)
    kind = take(entry, "kind", str, StrokeKind.UNKNOWN.value)
    if kind not in set(StrokeKind):
        raise InputError(f"expected the kind {', '.join(StrokeKind)}, found {found_value(kind)}")
    points = _numbers(take(entry, "points", list), "points", 2)
    pressure = _numbers(take(entry, "pressure", list), "pressure", 1) if "pressure" in entry else None
    curve = take(entry, "curve", str) if "curve" in entry else None
    width = entry.get("width")
    if not (width is None or type(width) in (int, float)):
        raise InputError(f"width: expected a number, found {found_value(width)}")
    return Stroke(points, StrokeKind(kind), curve, pressure, width)


def _numbers(rows: list, key: str, columns: int) -> np.ndarray:
    """(N, 2) or (N,) of a list of pairs or numbers."""
    flat = rows if columns == 1 else [x for row in rows if isinstance(row, list) and len(row) == 2 for x in row]
    if len(flat) != columns * len(rows) or not all(type(x) in (int, float) for x in flat):
        expected = "numbers" if columns == 1 else "pairs of numbers [x, y]"
        raise InputError(f"{key}: expected {expected}, found others")
    return np.array(flat, np.float64).reshape((-1, 2) if columns == 2 else -1)
