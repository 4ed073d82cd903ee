"""2D landmarks: JSON, iBUG .pts, plain text and NPY."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, OutputError, naming, shown
from caricli.io.files import decode_text, read_bytes, text_start
from caricli.io.npz import read_array
from caricli.io.outputs import write_bytes
from caricli.io.parse_number import parse_number
from caricli.io.strict_json import found_value, parse_json, refuse_others, write_json
from caricli.limits import MAX_COORDINATE, MAX_LANDMARK_BYTES
from caricli.structures.landmarks import SCHEMES, Landmarks

SCHEMA = "caricli.landmarks/1"
_KIND = "a landmark file"
_KEYS = ("schema", "scheme", "image", "points", "spreads", "visibility", "slides")
_MAX_IMAGE_SIDE = 1_000_000


def read_landmarks(path: str | Path, pts_origin: int = 1) -> Landmarks:
    """Read landmarks; the content decides the format, whatever the extension.

    JSON (docs/formats.md), `.pts` (`version: 1`, `n_points: 68`, points in braces), text with `x y` (or `x, y`) a
    line, NPY (L,2). A point that is not known is `null` in JSON, `null null` in text and .pts, a NaN row in NPY.
    pts_origin: 0 or 1, the coordinate of the first pixel in .pts files, subtracted.
    Raises InputError when the file is malformed, or its points are not those of a face or of its picture.
    """
    data = read_bytes(path, MAX_LANDMARK_BYTES, _KIND)
    if data.startswith(b"\x93NUMPY"):
        points = _points_from_npy(data, path)
    elif text_start(data)[:1] in (b"{", b"["):
        value = parse_json(data, path)
        with naming(path):
            return landmarks_from_json(value)
    else:
        lines = decode_text(data, path, _KIND).splitlines() or [""]
        with naming(path):
            if Path(path).suffix.lower() == ".pts" or lines[0].startswith("version"):
                points = _points_from_pts(lines) - pts_origin
            else:
                points = _points_from_lines(list(enumerate(lines, 1)))
    with naming(path):
        return Landmarks(points)


def write_landmarks(path: str | Path, landmarks: Landmarks) -> None:
    """Write landmarks in the format of the path's extension: .json, .pts (from 1), .txt or .npy.

    Image size, spreads, visibility and slides are kept in JSON only.
    Raises OutputError when the extension is another or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    points = landmarks.points
    if suffix == ".json":
        write_json(path, landmarks_to_json(landmarks))
    elif suffix == ".npy":
        # Not into the file itself: there NumPy writes past Python and overlooks a full disk.
        stream = io.BytesIO()
        np.save(stream, points, allow_pickle=False)
        write_bytes(path, stream.getvalue())
    elif suffix == ".pts":
        write_bytes(path, f"version: 1\nn_points: {len(points)}\n{{\n{_text(points + 1)}}}\n".encode())
    elif suffix == ".txt":
        write_bytes(path, _text(points).encode())
    else:
        raise OutputError(f"{shown(path)}: expected .json, .pts, .txt or .npy for landmarks, found {shown(suffix)!r}")


def landmarks_from_json(value: Any) -> Landmarks:
    """The Landmarks of a JSON value. Raises InputError when it is malformed, or they are not those of a face."""
    points = _points_from_json(value)
    spreads = _spreads_from_json(value.get("spreads"), points)
    size = _image_size(value.get("image"))
    visibility = _visibility(value.get("visibility"))
    return Landmarks(points, size, spreads, visibility, _slides(value.get("slides"), len(points)))


def landmarks_to_json(landmarks: Landmarks) -> dict[str, Any]:
    """The JSON value of landmarks."""
    points = landmarks.points
    value: dict[str, Any] = {"schema": SCHEMA, "scheme": SCHEMES[len(points)]}
    if landmarks.image_size is not None:
        width, height = landmarks.image_size
        value["image"] = {"width": int(width), "height": int(height)}
    value["points"] = [None if np.isnan(point).any() else point.tolist() for point in points]
    if landmarks.spreads is not None:
        rows = landmarks.spreads[:, [0, 0, 1], [0, 1, 1]]
        value["spreads"] = [None if np.isnan(row).any() else row.tolist() for row in rows]
    if landmarks.visibility is not None:
        value["visibility"] = landmarks.visibility.tolist()
    if landmarks.slides is not None:
        value["slides"] = landmarks.slides.tolist()
    return value


def _text(points: np.ndarray) -> str:
    return "".join("null null\n" if np.isnan(x) else f"{x!r} {y!r}\n" for x, y in points.tolist())


def _points_from_npy(data: bytes, path: str | Path) -> np.ndarray:
    points = read_array(io.BytesIO(data), len(data), shown(path))
    if points.dtype.kind not in "iuf" or points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"{shown(path)}: expected numbers (L,2), found {points.dtype} {points.shape}")
    return points.astype(np.float64)


def _points_from_json(value: Any) -> np.ndarray:
    if not isinstance(value, dict):
        raise InputError(f"expected landmarks as an object of the schema {SCHEMA!r}, found a list")
    if value.get("schema") != SCHEMA:
        raise InputError(f"expected the schema {SCHEMA!r}, found {found_value(value.get('schema'))}")
    refuse_others(value, _KEYS)
    entries = value.get("points")
    if not isinstance(entries, list):
        raise InputError(f"expected points to be a list, found {found_value(entries)}")
    if len(entries) in SCHEMES and value.get("scheme") != SCHEMES[len(entries)]:
        expected = f"the scheme {SCHEMES[len(entries)]!r} for {len(entries)} points"
        raise InputError(f"expected {expected}, found {found_value(value.get('scheme'))}")
    points = np.full((len(entries), 2), np.nan)
    for k, entry in enumerate(entries):
        if entry is None:
            continue
        if not (isinstance(entry, list) and len(entry) == 2 and all(_is_number(x) for x in entry)):
            raise InputError(f"point {k}: expected [x, y] or null, found {found_value(entry)}")
        points[k] = entry
    return points


def _spreads_from_json(entries: Any, points: np.ndarray) -> np.ndarray | None:
    """Covariances (L, 2, 2) of rows [xx, xy, yy], NaN where a point is not known; None where there are none."""
    if entries is None:
        return None
    if not isinstance(entries, list) or len(entries) != len(points):
        raise InputError(f"expected a list of {len(points)} spreads, found {found_value(entries)}")
    spreads = np.full((len(points), 2, 2), np.nan)
    for k in np.flatnonzero(np.isfinite(points).all(axis=1)):
        entry = entries[k]
        if not (isinstance(entry, list) and len(entry) == 3 and all(_is_number(x) for x in entry)):
            raise InputError(f"spread {k}: expected [xx, xy, yy], found {found_value(entry)}")
        spreads[k] = [[entry[0], entry[1]], [entry[1], entry[2]]]
    return spreads


def _visibility(entries: Any) -> np.ndarray | None:
    if entries is None:
        return None
    if not isinstance(entries, list) or not all(_is_number(x) for x in entries):
        raise InputError(f"expected visibility to be a list of numbers, found {found_value(entries)}")
    return np.array(entries, np.float64)


def _slides(entries: Any, count: int) -> np.ndarray | None:
    """(L, 2) of rows [x, y]; None where there are none."""
    if entries is None:
        return None
    if not isinstance(entries, list) or len(entries) != count:
        raise InputError(f"expected a list of {count} slides, found {found_value(entries)}")
    for k, entry in enumerate(entries):
        if not (isinstance(entry, list) and len(entry) == 2 and all(_is_number(x) for x in entry)):
            raise InputError(f"slide {k}: expected [x, y], found {found_value(entry)}")
    return np.array(entries, np.float64)


def _image_size(image: Any) -> tuple[int, int] | None:
    if image is None:
        return None
    if not isinstance(image, dict) or set(image) != {"width", "height"}:
        raise InputError(f"expected an image with width and height, found {found_value(image)}")
    size = (image["width"], image["height"])
    if not all(type(side) is int and 1 <= side <= _MAX_IMAGE_SIDE for side in size):
        raise InputError(f"expected an image size in whole pixels, found {shown(size, 60)}")
    return size


def _points_from_pts(lines: list[str]) -> np.ndarray:
    rows = [(number, line.strip()) for number, line in enumerate(lines, 1) if line.strip()]
    words = [line.replace(" ", "").replace("\t", "") for _, line in rows]
    if len(rows) < 4 or words[0] != "version:1" or not words[1].startswith("n_points:"):
        raise InputError("expected 'version: 1', 'n_points: L' and points in braces, found other text")
    if words[2] != "{" or words[-1] != "}":
        raise InputError("expected points between '{' and '}', found no such lines")
    points = _points_from_lines(rows[3:-1])
    if words[1] != f"n_points:{len(points)}":
        raise InputError(f"expected {shown(rows[1][1], 40)!r}, found {len(points)} points")
    return points


def _points_from_lines(lines: list[tuple[int, str]]) -> np.ndarray:
    points = []
    for number, line in lines:
        words = line.replace(",", " ").split()
        if not words:
            continue
        if words in (["null"], ["null", "null"]):
            points.append((np.nan, np.nan))
            continue
        try:
            x, y = map(parse_number, words)
        except ValueError:
            x = y = np.nan
        if not (abs(x) <= MAX_COORDINATE and abs(y) <= MAX_COORDINATE):
            raise InputError(f"line {number}: expected two numbers x y, found {shown(line, 60)!r}")
        points.append((x, y))
    return np.array(points).reshape(-1, 2)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MAX_COORDINATE
