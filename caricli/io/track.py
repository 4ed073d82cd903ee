"""Weights of expressions over time: Live Link Face CSV, MediaPipe blendshape JSON, caricli's own JSON, NPZ."""

import re

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import decode_text, read_bytes
from caricli.io.npz import read_npz
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json, parse_json
from caricli.limits import MAX_FILE_BYTES, MAX_JSON_BYTES, MAX_SHAPES
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.track import FrameError, Track

SCHEMA = "caricli.weights/1"

MAX_FPS = 1000.0
MAX_FRAMES, MAX_WEIGHTS = 2**19, 2**25
"""Longest track, about two hours at 60 frames a second; most weights of one track."""

HEAD_ANGLES = ("HeadYaw", "HeadPitch", "HeadRoll")

_LIVE_LINK_FPS, _OTHER_FPS = 60.0, 30.0
_COMMON_FPS = (24, 25, 30, 48, 50, 60, 90, 120, 240)
_TIMECODE = re.compile(r"(\d{1,2}):(\d{1,2}):(\d{1,2})[:;](\d{1,4}(?:\.\d{1,9})?)")
_DAY = 86400.0


def read_weights(path, fps=None):
    """Read weights over time; the format is found from the content.

    CSV of Live Link Face: needs all 52 shapes, in Pascal or camel case and any order; the head's angles are all there
    or none; the eyes' angles and other columns are not read, because the eyeLook shapes say the same. Its timecodes
    HH:MM:SS:FF.fff count frames at a rate that the file does not hold: the smallest common one above the frames
    counted where a second ends within the take, else 60. Times go on over midnight. Where timecodes are no such text,
    repeat or go back, rows follow each other at the rate.
    JSON of MediaPipe's Face Landmarker: one result or a list (or {"frames": ...}) of results, each an object with
    `face_blendshapes` (`faceBlendshapes`) or the list of categories itself; times from `timestamp_ms` (`timestampMs`)
    where every result has one, else 30 results a second. The first face counts, results without a face are left out,
    and so is `_neutral`.
    JSON of caricli: schema, names, weights and fps or times, optionally head. NPZ: names, weights, optionally fps (30).

    Parameters: path; fps, frames per second of the recording where the file does not say.
    Returns: Track.
    Raises: InputError when it is none of these, a row is ragged, names repeat, or a number is missing, not finite or
    out of range.
    """
    if fps is not None:
        _check_fps(fps, "--source-fps")
    data = read_bytes(path, MAX_FILE_BYTES, "weights (CSV, JSON or NPZ)")
    if data.startswith(b"PK"):
        return _from_npz(read_npz(path), path, fps)
    if data.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"["):
        if len(data) > MAX_JSON_BYTES:
            raise InputError(f"{shown(path)}: expected JSON of at most {MAX_JSON_BYTES} bytes, found {len(data)} bytes")
        value = parse_json(data.removeprefix(b"\xef\xbb\xbf"), path)
        own = isinstance(value, dict) and "schema" in value
        return _from_own(value, path) if own else _from_mediapipe(value, path, fps)
    return _from_csv(decode_text(data, path, "weights (CSV, JSON or NPZ)"), path, fps)


def write_weights(path, track):
    """Write weights as caricli's JSON: fps where the times are even, else the times.

    Parameters: path; track, Track.
    Raises: OutputError when the track could not be read back or the file cannot be written.
    """
    times = np.asarray(track.times, float)
    fps = (len(times) - 1) / times[-1] if len(times) > 1 else _OTHER_FPS
    fps = round(fps, 6)
    even = 0 < fps <= MAX_FPS and np.array_equal(times, np.arange(len(times)) / fps)
    value = {"schema": SCHEMA} | ({"fps": fps} if even else {"times": times})
    value |= {"names": list(track.names), "weights": track.weights}
    value |= {} if track.head is None else {"head": track.head}
    write_bytes(path, format_json(value, path, indent=None).encode())


def _from_csv(text, path, fps):
    lines = text.removeprefix("\ufeff").splitlines()
    header = [word.strip().strip('"') for word in lines[0].split(",")]
    columns = {word.lower(): k for k, word in enumerate(header)}
    if "timecode" not in columns:
        raise InputError(f"{shown(path)}: expected weights (CSV, JSON or NPZ), found {shown(lines[0], 40)!r}")
    if len(columns) < len(header):
        twice = next(word for k, word in enumerate(header) if columns[word.lower()] != k)
        raise InputError(f"{shown(path)}: line 1: expected distinct columns, found {shown(twice, 40)!r} twice")
    head = [name for name in HEAD_ANGLES if name.lower() in columns]
    wanted = [*ARKIT_NAMES, *(HEAD_ANGLES if head else ())]
    missing = [name for name in ("BlendShapeCount", *wanted) if name.lower() not in columns]
    if missing:
        more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
        raise InputError(f"{shown(path)}: line 1: expected the columns {', '.join(missing[:3])}{more}, found none")
    rows = [(number, line) for number, line in enumerate(lines[1:], 2) if line.strip(" ,\t")]
    _check_size(len(rows), len(wanted), path)
    values, timecodes, picks = np.empty((len(rows), len(wanted))), [], [columns[name.lower()] for name in wanted]
    for k, (number, line) in enumerate(rows):
        words = line.split(",")
        if len(words) != len(header):
            found = f"{len(header)} values as in the header, found {len(words)}"
            raise InputError(f"{shown(path)}: line {number}: expected {found}")
        timecodes.append(words[columns["timecode"]].strip().strip('"'))
        try:
            values[k] = [float(words[pick]) for pick in picks]
        except ValueError:
            name, word = next((header[pick], words[pick]) for pick in picks if not _is_number(words[pick]))
            expected = f"line {number}: {name}: expected a number"
            raise InputError(f"{shown(path)}: {expected}, found {shown(word, 40)!r}") from None
    count = len(ARKIT_NAMES)
    places = [f"line {number}" for number, _ in rows]
    angles = values[:, count:] if head else None
    return _track(path, places, ARKIT_NAMES, _live_link_times(timecodes, fps), values[:, :count], angles)


def _is_number(word):
    try:
        float(word)
    except ValueError:
        return False
    return True


def _live_link_times(timecodes, fps):
    matches = [_TIMECODE.fullmatch(text) for text in timecodes]
    rows = np.arange(len(timecodes)) / (fps or _LIVE_LINK_FPS)
    if not all(matches):
        return rows
    hours, minutes, seconds, frames = np.array([[float(x) for x in match.groups()] for match in matches]).T
    clock = 3600 * hours + 60 * minutes + seconds
    clock += _DAY * np.cumsum(np.diff(clock, prepend=clock[0]) < -_DAY / 2)
    rate = fps or _LIVE_LINK_FPS
    if fps is None and clock[0] != clock[-1]:
        # A take that goes over a second's end shows how many frames a second has.
        top = np.floor(frames.max()) + 1
        rate = next((common for common in _COMMON_FPS if common >= top), top)
    times = clock + frames / rate
    return times - times[0] if (np.diff(times) > 0).all() else rows


def _from_mediapipe(value, path, fps):
    if isinstance(value, dict) and isinstance(value.get("frames"), list):
        value = value["frames"]
    # A list of categories is one result; any other list holds results.
    results = value if isinstance(value, list) and not _is_categories(value) else [value]
    found = [(k, _scores(result, f"{shown(path)}: frame {k}")) for k, result in enumerate(results)]
    found = [(k, scores) for k, scores in found if scores is not None]
    if not found:
        raise InputError(f"{shown(path)}: expected MediaPipe blendshapes of a face, found none")
    names = tuple(name for name in found[0][1] if name != "_neutral")
    _check_size(len(found), len(names), path)
    weights = np.empty((len(found), len(names)))
    for row, (k, scores) in enumerate(found):
        if set(scores) != set(found[0][1]):
            odd = min(set(scores) ^ set(found[0][1]))
            found = f"{shown(odd, 40)!r} in some only"
            raise InputError(f"{shown(path)}: frame {k}: expected the same names in all frames, found {found}")
        weights[row] = [scores[name] for name in names]
    frames = [k for k, _ in found]
    stamps = [_stamp(results[k]) for k in frames]
    given = [stamp is not None for stamp in stamps]
    if any(given) and not all(given):
        bare = frames[given.index(False)]
        raise InputError(f"{shown(path)}: frame {bare}: expected a timestamp as in other frames, found none")
    times = np.array(stamps, float) if all(given) else np.array(frames) / (fps or _OTHER_FPS)
    return _track(path, [f"frame {k}" for k in frames], names, times - times[0], weights)


def _is_categories(value):
    return isinstance(value, list) and value and isinstance(value[0], dict) and "score" in value[0]


def _stamp(result):
    """Seconds at which a result was made, or None where it does not say."""
    stamp = result.get("timestamp_ms", result.get("timestampMs")) if isinstance(result, dict) else None
    return stamp / 1000 if isinstance(stamp, int | float) and not isinstance(stamp, bool) else None


def _scores(result, where):
    """Names to scores of the first face of a result, or None where it has no face."""
    while not _is_categories(result):
        keys = ("face_blendshapes", "faceBlendshapes", "categories")
        if isinstance(result, dict) and any(key in result for key in keys):
            result = next(result[key] for key in keys if key in result)
        elif isinstance(result, list):
            if not result:
                return None
            result = result[0]
        else:
            raise InputError(f"{where}: expected MediaPipe blendshapes, found {shown(result, 40)}")
    scores = {}
    for category in result:
        name, score = None, None
        if isinstance(category, dict):
            name, score = category.get("category_name", category.get("categoryName")), category.get("score")
        if not isinstance(name, str) or not name or not isinstance(score, int | float) or isinstance(score, bool):
            raise InputError(f"{where}: expected a category with a name and a score, found {shown(category, 60)}")
        if name in scores:
            raise InputError(f"{where}: expected distinct names, found {shown(name, 40)!r} twice")
        scores[name] = float(score)
    return scores


def _from_own(value, path):
    if value["schema"] != SCHEMA:
        found = shown(value["schema"], 40)
        raise InputError(f"{shown(path)}: expected weights with schema {SCHEMA!r}, found {found!r}")
    unknown = set(value) - {"schema", "fps", "times", "names", "weights", "head"}
    if unknown or ("fps" in value) == ("times" in value) or "names" not in value or "weights" not in value:
        found = shown(", ".join(value), 60)
        raise InputError(f"{shown(path)}: expected names, weights, and fps or times, found {found}")
    names = value["names"]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{shown(path)}: names: expected a list of texts, found {shown(names, 60)}")
    rows = value["weights"]
    _check_size(len(rows) if isinstance(rows, list) else 0, len(names), path)
    weights = _table(rows, len(names), f"{shown(path)}: weights")
    if "fps" in value:
        _check_fps(value["fps"], f"{shown(path)}: fps")
        times = np.arange(len(rows)) / value["fps"]
    else:
        times = _table([value["times"]], len(rows), f"{shown(path)}: times")[0]
    head = _table(value["head"], 3, f"{shown(path)}: head") if "head" in value else None
    return _track(path, _numbered(rows), names, times, weights, head)


def _from_npz(arrays, path, fps):
    unknown = set(arrays) - {"names", "weights", "fps"}
    if unknown or not {"names", "weights"} <= set(arrays):
        raise InputError(f"{shown(path)}: expected names, weights and fps, found {shown(', '.join(arrays), 60)}")
    names, weights = arrays["names"], arrays["weights"]
    if names.dtype.kind != "U" or names.ndim != 1 or weights.dtype.kind not in "fiu":
        raise InputError(f"{shown(path)}: expected names (K,) and weights (T,K), found {names.dtype}, {weights.dtype}")
    if weights.ndim != 2 or weights.shape[1] != len(names):
        raise InputError(f"{shown(path)}: weights: expected (T,{len(names)}) as the names, found {weights.shape}")
    _check_size(*weights.shape, path)
    if "fps" in arrays and (arrays["fps"].size != 1 or arrays["fps"].dtype.kind not in "fiu"):
        raise InputError(f"{shown(path)}: fps: expected one number, found {arrays['fps'].shape}")
    rate = float(arrays["fps"].item()) if "fps" in arrays else fps or _OTHER_FPS
    _check_fps(rate, f"{shown(path)}: fps")
    return _track(path, _numbered(weights), names.tolist(), np.arange(len(weights)) / rate, weights.astype(float))


def _table(rows, width, where):
    """Rows of numbers as an array (T, width)."""
    sound = isinstance(rows, list)
    for k, row in enumerate(rows if sound else ()):
        numbers = isinstance(row, list) and all(isinstance(x, int | float) and not isinstance(x, bool) for x in row)
        if not numbers or len(row) != width:
            found = f"{len(row)}" if numbers else "something else"
            raise InputError(f"{where}: row {k}: expected {width} numbers, found {found}")
    if not sound:
        raise InputError(f"{where}: expected rows of {width} numbers, found something else")
    return np.array(rows, float).reshape(-1, width)


def _check_fps(fps, where):
    sound = isinstance(fps, int | float) and not isinstance(fps, bool) and 0 < fps <= MAX_FPS
    if not sound:
        expected = f"more than 0 and at most {MAX_FPS:g} frames a second"
        raise InputError(f"{where}: expected {expected}, found {shown(fps, 40)}")


def _check_size(frames, names, path):
    if not frames:
        raise InputError(f"{shown(path)}: expected at least one frame of weights, found none")
    if frames > MAX_FRAMES or names > MAX_SHAPES or frames * names > MAX_WEIGHTS:
        most = f"{MAX_FRAMES} frames, {MAX_SHAPES} names and {MAX_WEIGHTS} weights"
        raise InputError(f"{shown(path)}: expected at most {most}, found {frames} frames of {names}")


def _numbered(frames):
    """What frames are called that have no other name in their file."""
    return [f"frame {k}" for k in range(len(frames))]


def _track(path, rows, names, times, weights, head=None):
    """The Track of a file, with ARKit's spelling. rows: (T,) texts, what a frame is called in the file."""
    arkit = {name.lower(): name for name in ARKIT_NAMES}
    spelled = tuple(arkit.get(name.lower(), name) for name in names)
    with naming(path):
        try:
            return Track(spelled, times, weights, head)
        except FrameError as error:
            raise InputError(f"{rows[error.frame]}: {error.problem}") from None
