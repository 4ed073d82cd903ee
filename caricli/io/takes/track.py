"""Weights of expressions over time: Live Link Face CSV, MediaPipe blendshape JSON, caricli's own JSON, NPZ."""

from collections.abc import Sized
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import column_separator, decode_text, read_bytes, text_start, without_utf16
from caricli.io.npz import read_npz
from caricli.io.parse_number import parse_number
from caricli.io.strict_json import parse_json
from caricli.io.takes.mediapipe_head import mediapipe_head
from caricli.io.takes.timecode import timecode_seconds
from caricli.limits import MAX_FILE_BYTES, MAX_JSON_BYTES, MAX_SHAPES
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.track import FrameError, Track

SCHEMA = "caricli.weights/1"

MIN_FPS = 1e-3
MAX_FPS = 1000.0
MAX_FRAMES = 2**19
"""Longest track, about two hours at 60 frames a second."""
MAX_WEIGHTS = 2**25
"""Most weights of one track."""

HEAD_ANGLES = ("HeadYaw", "HeadPitch", "HeadRoll")

KIND = "weights (CSV, JSON or NPZ)"
OTHER_FPS = 30.0
"""Frames a second where a file does not say, but for Live Link Face."""
_LIVE_LINK_FPS = 60.0
_MAX_STAMP = 1e15
"""Largest timestamp, milliseconds: far above those that count from 1970."""


class _Values(NamedTuple):
    """What a file says of a track, before it is checked."""

    names: tuple[str, ...]
    times: np.ndarray
    weights: np.ndarray
    head: np.ndarray | None = None
    fps: float | None = None


def read_weights(path: str | Path, fps: float | None = None) -> Track:
    """Read weights over time; the format is told from the content.

    CSV of Live Link Face, with commas or semicolons, in UTF-8 or UTF-16: most of the 52 shapes, in Pascal or camel
    case and any order; the head's angles are all there or none; the eyes' angles and other columns are not read,
    because the eyeLook shapes say the same. Rows without a face, with a BlendShapeCount of 0 and no values, are left
    out. Times are those of its timecodes (``timecode_seconds``), 60 frames a second where these do not show the rate.
    JSON of MediaPipe's Face Landmarker: one result or a list (or {"frames": ...}) of results, each an object with
    `face_blendshapes` (`faceBlendshapes`) or the list of categories itself; times from `timestamp_ms` (`timestampMs`)
    where every result has one, else 30 results a second. The first face counts, results without a face are left out,
    and so is `_neutral`. The head turns as `facial_transformation_matrixes` (`facialTransformationMatrixes`) say, where
    every result has one.
    JSON of caricli: schema, names, weights and fps or times, optionally head. NPZ: names, weights, optionally fps (30).

    fps: frames a second of the recording, where the file does not say.
    Raises InputError when it is none of these, a row is ragged, names repeat, or a number is missing, not finite or
    out of range.
    """
    if fps is not None:
        _check_fps(fps, "--source-fps")
    data = without_utf16(read_bytes(path, MAX_FILE_BYTES, KIND))
    if data.startswith(b"PK"):
        arrays = read_npz(path)
        with naming(path):
            return _from_npz(arrays, fps)
    if text_start(data)[:1] not in (b"{", b"["):
        text = decode_text(data, path, KIND)
        with naming(path):
            return _from_csv(text, fps)
    if len(data) > MAX_JSON_BYTES:
        raise InputError(f"{shown(path)}: expected JSON of at most {MAX_JSON_BYTES} bytes, found {len(data)} bytes")
    value = parse_json(data, path)
    with naming(path):
        is_own = isinstance(value, dict) and "schema" in value
        return _from_own(value) if is_own else _from_mediapipe(value, fps)


def _from_csv(text: str, fps: float | None) -> Track:
    lines = text.splitlines() or [""]
    between = column_separator(lines[0])
    header = [word.strip().strip('"') for word in lines[0].split(between)]
    columns = _columns(header, lines[0])
    has_head = any(name.lower() in columns for name in HEAD_ANGLES)
    names = tuple(name for name in ARKIT_NAMES if name.lower() in columns)
    angles = HEAD_ANGLES if has_head else ()
    shapes = names if 2 * len(names) > len(ARKIT_NAMES) else ARKIT_NAMES
    missing = [name for name in ("BlendShapeCount", *shapes, *angles) if name.lower() not in columns]
    if missing:
        more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
        raise InputError(f"line 1: expected the columns {', '.join(missing[:3])}{more}, found none")
    if between == ";":
        # Where columns end with semicolons, fractions may begin with commas.
        lines = [line.replace(",", ".") for line in lines]
    numbered = [(number, line) for number, line in enumerate(lines[1:], 2) if line.strip(' .,;\t"')]
    rows = [(number, [_unquoted(word) for word in line.split(between)]) for number, line in numbered]
    faces = [k for k, (_, words) in enumerate(rows) if not _is_lost(words, columns)]
    wanted = (*names, *angles)
    _check_size(len(faces), len(wanted))
    values = np.empty((len(faces), len(wanted)))
    for row, (number, words) in zip(values, [rows[k] for k in faces], strict=True):
        with naming(f"line {number}"):
            if len(words) != len(header):
                raise InputError(f"expected {len(header)} values as in the header, found {len(words)}")
            row[:] = [_number(words[columns[name.lower()]], header[columns[name.lower()]]) for name in wanted]
    timecodes = [words[columns["timecode"]] for _, words in rows]
    times = timecode_seconds(timecodes, fps, _LIVE_LINK_FPS)[faces]
    head = values[:, len(names) :] if has_head else None
    track = _Values(names, times - times[0], values[:, : len(names)], head, fps or _LIVE_LINK_FPS)
    return _track(track, [f"line {rows[k][0]}" for k in faces])


def _is_lost(words: list[str], columns: dict[str, int]) -> bool:
    """Whether a row tells of no face: no shapes are counted, and there is nothing else but the time."""
    counted = columns["blendshapecount"]
    if len(words) <= max(counted, columns["timecode"]) or words[counted] != "0":
        return False
    return sum(bool(word) for word in words) <= 2


def _unquoted(word: str) -> str:
    """A value without blanks and the quotes around it."""
    bare = word.strip()
    return bare[1:-1].strip() if len(bare) > 1 and bare[0] == bare[-1] == '"' else bare


def _columns(header: list[str], line: str) -> dict[str, int]:
    """Where every column of a take stands, by its name in small letters."""
    columns = {word.lower(): k for k, word in enumerate(header)}
    if "timecode" not in columns:
        raise InputError(f"expected {KIND}, found {shown(line, 40)!r}")
    if len(columns) < len(header):
        twice = next(word for k, word in enumerate(header) if columns[word.lower()] != k)
        raise InputError(f"line 1: expected distinct columns, found {shown(twice, 40)!r} twice")
    return columns


def _number(word: str, name: str) -> float:
    try:
        return parse_number(word)
    except ValueError:
        raise InputError(f"{name}: expected a number, found {shown(word, 40)!r}") from None


def _from_mediapipe(value: Any, fps: float | None) -> Track:
    if isinstance(value, dict) and isinstance(value.get("frames"), list):
        value = value["frames"]
    # A list of categories is one result; any other list holds results.
    results = value if isinstance(value, list) and not _is_categories(value) else [value]
    scores = {}
    for frame, result in enumerate(results):
        with naming(f"frame {frame}"):
            face = _scores(result)
        if face is not None:
            scores[frame] = face
    if not scores:
        raise InputError("expected MediaPipe blendshapes of a face, found none")
    frames = list(scores)
    first = scores[frames[0]]
    names = tuple(name for name in first if name != "_neutral")
    head = mediapipe_head([results[frame] for frame in frames], frames)
    _check_size(len(frames), len(names))
    weights = np.empty((len(frames), len(names)))
    for row, frame in zip(weights, frames, strict=True):
        if set(scores[frame]) != set(first):
            odd = shown(min(set(scores[frame]) ^ set(first)), 40)
            raise InputError(f"frame {frame}: expected the same names in all frames, found {odd!r} in some only")
        row[:] = [scores[frame][name] for name in names]
    stamps = {}
    for frame in frames:
        with naming(f"frame {frame}"):
            stamps[frame] = _stamp(results[frame])
    times = _mediapipe_times(list(stamps.values()), frames, fps)
    return _track(_Values(names, times, weights, head, fps), [f"frame {frame}" for frame in frames])


def _mediapipe_times(stamps: list[float | None], frames: list[int], fps: float | None) -> np.ndarray:
    """Seconds (T,) from 0 of results, by their stamps where they have some, else by their numbers."""
    bare = [frame for frame, stamp in zip(frames, stamps, strict=True) if stamp is None]
    if bare and len(bare) < len(frames):
        raise InputError(f"frame {bare[0]}: expected a timestamp as in other frames, found none")
    times = np.array(frames) / (fps or OTHER_FPS) if bare else np.array(stamps, float)
    return times - times[0]


def _is_categories(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict) and "score" in value[0]


def _stamp(result: Any) -> float | None:
    """Seconds at which a result came, or None where it does not say."""
    stamp = result.get("timestamp_ms", result.get("timestampMs")) if isinstance(result, dict) else None
    if not isinstance(stamp, int | float) or isinstance(stamp, bool):
        return None
    if abs(stamp) > _MAX_STAMP:
        raise InputError(f"expected a timestamp of at most {_MAX_STAMP:g} ms, found {shown(stamp, 40)}")
    return stamp / 1000


def _scores(result: Any) -> dict[str, float] | None:
    """The scores of the first face of a result by their names, or None where it has no face."""
    while not _is_categories(result):
        keys = ("face_blendshapes", "faceBlendshapes", "categories")
        if isinstance(result, dict) and any(key in result for key in keys):
            result = next(result[key] for key in keys if key in result)
        elif isinstance(result, list):
            if not result:
                return None
            result = result[0]
        else:
            raise InputError(f"expected MediaPipe blendshapes, found {shown(result, 40)}")
    scores: dict[str, float] = {}
    for category in result:
        entry = category if isinstance(category, dict) else {}
        name = entry.get("category_name", entry.get("categoryName"))
        score = entry.get("score")
        if not isinstance(name, str) or not name or not isinstance(score, int | float) or isinstance(score, bool):
            raise InputError(f"expected a category with a name and a score, found {shown(category, 60)}")
        if name in scores:
            raise InputError(f"expected distinct names, found {shown(name, 40)!r} twice")
        scores[name] = float(score)
    return scores


def _from_own(value: dict) -> Track:
    if value["schema"] != SCHEMA:
        raise InputError(f"expected weights with schema {SCHEMA!r}, found {shown(value['schema'], 40)!r}")
    unknown = set(value) - {"schema", "fps", "times", "names", "weights", "head"}
    if unknown or ("fps" in value) == ("times" in value) or "names" not in value or "weights" not in value:
        raise InputError(f"expected names, weights, and fps or times, found {shown(', '.join(value), 60)}")
    names = value["names"]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"names: expected a list of texts, found {shown(names, 60)}")
    rows = value["weights"]
    _check_size(len(rows) if isinstance(rows, list) else 0, len(names))
    weights = _table(rows, len(names), "weights")
    if "fps" in value:
        _check_fps(value["fps"], "fps")
        times = np.arange(len(rows)) / value["fps"]
    else:
        times = _table([value["times"]], len(rows), "times")[0]
    head = _table(value["head"], 3, "head") if "head" in value else None
    return _track(_Values(tuple(names), times, weights, head, value.get("fps")), _numbered(rows))


def _from_npz(arrays: dict[str, np.ndarray], fps: float | None) -> Track:
    unknown = set(arrays) - {"names", "weights", "fps"}
    if unknown or not {"names", "weights"} <= set(arrays):
        raise InputError(f"expected names, weights and fps, found {shown(', '.join(arrays), 60)}")
    names = arrays["names"]
    weights = arrays["weights"]
    if names.dtype.kind != "U" or names.ndim != 1 or weights.dtype.kind not in "fiu":
        raise InputError(f"expected names (K,) and weights (T,K), found {names.dtype}, {weights.dtype}")
    if weights.ndim != 2 or weights.shape[1] != len(names):
        raise InputError(f"weights: expected (T,{len(names)}) as the names, found {weights.shape}")
    _check_size(*weights.shape)
    if "fps" in arrays and (arrays["fps"].size != 1 or arrays["fps"].dtype.kind not in "fiu"):
        raise InputError(f"fps: expected one number, found {arrays['fps'].shape}")
    rate = float(arrays["fps"].item()) if "fps" in arrays else fps or OTHER_FPS
    _check_fps(rate, "fps")
    times = np.arange(len(weights)) / rate
    return _track(_Values(tuple(names.tolist()), times, weights.astype(float), fps=rate), _numbered(weights))


def _table(rows: Any, width: int, where: str) -> np.ndarray:
    """Rows of numbers as an array (T, width)."""
    if not isinstance(rows, list):
        raise InputError(f"{where}: expected rows of {width} numbers, found something else")
    for k, row in enumerate(rows):
        numbers = isinstance(row, list) and all(isinstance(x, int | float) and not isinstance(x, bool) for x in row)
        if not numbers or len(row) != width:
            raise InputError(
                f"{where}: row {k}: expected {width} numbers, found {len(row) if numbers else 'something else'}"
            )
    return np.array(rows, float).reshape(-1, width)


def _check_fps(fps: Any, where: str) -> None:
    sound = isinstance(fps, int | float) and not isinstance(fps, bool) and MIN_FPS <= fps <= MAX_FPS
    if not sound:
        expected = f"from {MIN_FPS:g} to {MAX_FPS:g} frames a second"
        raise InputError(f"{where}: expected {expected}, found {shown(fps, 40)}")


def _check_size(frames: int, names: int) -> None:
    if not frames or not names:
        raise InputError(f"expected at least one frame of weights, found {frames} of {names} names")
    if frames > MAX_FRAMES or names > MAX_SHAPES or frames * names > MAX_WEIGHTS:
        most = f"{MAX_FRAMES} frames, {MAX_SHAPES} names and {MAX_WEIGHTS} weights"
        raise InputError(f"expected at most {most}, found {frames} frames of {names}")


def _numbered(frames: Sized) -> list[str]:
    """What frames are called that have no other name in their file."""
    return [f"frame {k}" for k in range(len(frames))]


def _track(values: _Values, rows: list[str]) -> Track:
    """The Track of a file's values, with ARKit's spelling. rows: (T,) texts, what a frame is called in the file."""
    arkit = {name.lower(): name for name in ARKIT_NAMES}
    spelled = tuple(arkit.get(name.lower(), name) for name in values.names)
    try:
        return Track(spelled, values.times, values.weights, values.head, values.fps or OTHER_FPS)
    except FrameError as error:
        raise InputError(f"{rows[error.frame]}: {error.problem}") from None
