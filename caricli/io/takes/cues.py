"""Mouth cues of Rhubarb Lip Sync (JSON, TSV, XML), and visemes in the same three forms."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.io.files import decode_text, read_bytes, text_start
from caricli.io.parse_number import parse_number
from caricli.io.parse_xml import parse_xml
from caricli.io.strict_json import parse_json
from caricli.limits import MAX_JSON_BYTES
from caricli.structures.cues import REST, RHUBARB, VISEMES, Cues, viseme_name

MAX_CUES = 100_000
"""About two hours of them."""

LETTERS = frozenset(RHUBARB)

KIND = "mouth cues (JSON, TSV or XML)"

_ROW = re.compile(rb"\s*\d+(?:\.\d+)?\t[A-Za-z_]{1,16}\s*(?:\n|\Z)")
_ALIKE = 1e-3
"""Seconds that cues may overlap or leave open where one ends and the next begins: files have two or three digits."""

Row = tuple[float, float | None, str]
"""Start and end in seconds, None for until the next one, and the name."""


def is_cues(start: bytes) -> bool:
    """Whether a file that begins so holds mouth cues."""
    text = text_start(start)
    if text.startswith(b"<"):
        return b"<rhubarbResult" in text
    return bool(_ROW.match(text)) or (text.startswith(b"{") and b'"mouthCues"' in text)


def read_cues(path: str | Path) -> Cues:
    """Read mouth cues; the format is told from the content.

    JSON: {"metadata": {"duration": s}, "mouthCues": [{"start": s, "end": s, "value": name}, ...]}. TSV: start and name
    on every line; the last line says when the one before ends. XML: <rhubarbResult> with <mouthCue start end>. A name
    is Rhubarb's letter where all of them are, else a viseme, also with "viseme_" before it. Where no cue is, the mouth
    rests.

    Raises InputError when it is none of these, a name is unknown, or times do not rise.
    """
    data = read_bytes(path, MAX_JSON_BYTES, KIND)
    text = text_start(data)
    with naming(path):
        if text.startswith(b"<"):
            rows, end = _xml_rows(data)
        elif text.startswith(b"{"):
            rows, end = _json_rows(parse_json(data, "cues"))
        else:
            rows, end = _tsv_rows(decode_text(data, "cues", KIND))
        if not 0 < len(rows) <= MAX_CUES:
            raise InputError(f"expected 1 to {MAX_CUES} cues, found {len(rows)}")
        return _cues(rows, end)


def _json_rows(value: Any) -> tuple[list[Row], float | None]:
    entries = value.get("mouthCues") if isinstance(value, dict) else None
    if not isinstance(entries, list):
        raise InputError(f"expected a list 'mouthCues', found {shown(value, 40)}")
    rows: list[Row] = []
    for k, entry in enumerate(entries):
        with naming(f"cue {k}"):
            if not isinstance(entry, dict) or not isinstance(entry.get("value"), str):
                raise InputError(f"expected start, end and value, found {shown(entry, 60)}")
            rows.append((_seconds(entry.get("start")), _seconds(entry.get("end")), entry["value"]))
    about = value.get("metadata")
    duration = about.get("duration") if isinstance(about, dict) else None
    return rows, None if duration is None else _seconds(duration)


def _tsv_rows(text: str) -> tuple[list[Row], float | None]:
    rows: list[Row] = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip():
            with naming(f"line {number}"):
                words = line.split("\t")
                if len(words) != 2:
                    raise InputError(f"expected seconds and a name with a tab between them, found {shown(line, 40)!r}")
                rows.append((_seconds(words[0]), None, words[1].strip()))
    # The last line has no length: it is where Rhubarb's mouth comes to rest.
    return rows, None


def _xml_rows(data: bytes) -> tuple[list[Row], float | None]:
    root = parse_xml(data, "the XML of Rhubarb Lip Sync")
    if root.tag != "rhubarbResult":
        raise InputError(f"expected <rhubarbResult>, found <{shown(root.tag, 40)}>")
    rows: list[Row] = []
    for k, entry in enumerate(root.iterfind("mouthCues/mouthCue")):
        with naming(f"cue {k}"):
            name = (entry.text or "").strip()
            rows.append((_seconds(entry.get("start")), _seconds(entry.get("end")), name))
    duration = root.findtext("metadata/duration")
    return rows, None if duration is None else _seconds(duration)


def _seconds(value: Any) -> float:
    try:
        seconds = parse_number(value) if isinstance(value, str) else value
    except ValueError:
        seconds = None
    # No recording is longer than a day.
    if not isinstance(seconds, int | float) or isinstance(seconds, bool) or not 0 <= seconds <= 86400:
        raise InputError(f"expected seconds, found {shown(value, 40)}")
    return float(seconds)


def _cues(rows: list[Row], end: float | None) -> Cues:
    """Cues of rows, the mouth at rest in between."""
    is_rhubarb = all(name in LETTERS or viseme_name(name) is None for _, _, name in rows)
    names: list[str] = []
    starts: list[float] = []
    now = 0.0

    def add(name: str, start: float) -> None:
        names.append(name)
        starts.append(start)

    for k, (start, until, name) in enumerate(rows):
        with naming(f"cue {k}"):
            if start < now - _ALIKE:
                raise InputError(f"expected one after the other, found it at {start:g} s, before {now:g} s")
            if until is not None and until < start:
                raise InputError(f"expected an end after its start at {start:g} s, found {until:g} s")
            if start > now + _ALIKE:
                add(REST, now)
                now = start
            stop = until if until is not None else rows[k + 1][0] if k + 1 < len(rows) else max(end or 0, now + _ALIKE)
            shape = f"rhubarb_{name}" if is_rhubarb and name in LETTERS else viseme_name(name)
            if shape is None:
                expected = f"one of Rhubarb's letters {RHUBARB}, or of {', '.join(VISEMES)}"
                raise InputError(f"expected {expected}, found {shown(name, 40)!r}")
            if stop > now:
                add(shape, now)
                now = stop
    if end is not None and end > now + _ALIKE:
        add(REST, now)
        now = end
    return Cues(tuple(names), np.array(starts), now)
