"""What a table, or the names of files, say of meshes: who they show, with which expression, and labels."""

import csv
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from caricli.data.expressions import NEUTRAL
from caricli.data.mesh_names import (
    MeshName,
    check_capitals,
    expression_name,
    normal_name,
    read_level,
    read_mesh_name,
)
from caricli.errors import InputError, naming, shown
from caricli.io.files import column_separator, read_text
from caricli.io.parse_number import parse_number

MAX_CSV_BYTES = 2**26
_MAX_LABEL = float(np.finfo(np.float32).max)

_OWN_COLUMNS = ("file", "identity", "expression", "level")
_ALIKE = 0.85
"""How much the name of a label is like one of these columns (``difflib``) where it may be a misspelt one, at least."""


@dataclass(frozen=True, eq=False)
class Labels:
    """What a table, or the names of files, say about N files.

    shown: N MeshNames. names: (A,) of the attributes. values: (N, A) float32.
    Raises InputError for people or expressions that are others only by their capitals.
    """

    shown: tuple[MeshName, ...]
    names: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        """Check the names."""
        check_capitals("people", self.people)
        check_capitals("expressions", self.expressions)

    @property
    def people(self) -> list[str]:
        """Their names, in the order in which they come."""
        return list(dict.fromkeys(name.person for name in self.shown))

    @property
    def expressions(self) -> list[str]:
        """The names of all expressions, the neutral one first."""
        return list(dict.fromkeys([NEUTRAL, *sorted(name.expression for name in self.shown)]))

    @property
    def notes(self) -> tuple[str, ...]:
        """What is worth knowing of them, a line each."""
        meant = {name: _meant(name) for name in self.names.tolist()}
        notes = [f"column {shown(name, 40)!r} is taken for a label{meant[name]}" for name in meant if meant[name]]
        counts = Counter(name.expression for name in self.shown)
        if not counts[NEUTRAL]:
            commonest = max(self.expressions, key=counts.__getitem__)
            of_these = f"of the expressions train morphable takes the commonest, {commonest}, for none"
            notes.append(f"no mesh is {NEUTRAL}: {of_these}")
        return tuple(notes)

    def columns(self) -> dict[str, np.ndarray]:
        """(N,) int32 by the names of a dataset's columns."""
        people = {person: k for k, person in enumerate(self.people)}
        expressions = {expression: k for k, expression in enumerate(self.expressions)}
        rows = [(people[name.person], expressions[name.expression], name.level) for name in self.shown]
        return dict(zip(("identity", "expression", "level"), np.array(rows, dtype=np.int32).T, strict=True))


def read_labels(path: Path | None, files: Sequence[str]) -> Labels:
    """Read the CSV with a row for every file; what it does not say, the names of the files do.

    path: of the CSV, its columns between commas or semicolons. files: (N,) names, each that of its row in any Unicode
    form, blanks around it aside. Raises InputError.
    """
    if path is None:
        return Labels(tuple(map(_name_of, files)), np.array([], dtype="<U1"), np.zeros((len(files), 0), np.float32))
    text = read_text(path, MAX_CSV_BYTES, "a CSV file")
    between = column_separator(text.partition("\n")[0])
    with naming(path):
        try:
            header, *lines = csv.reader(io.StringIO(text), delimiter=between)
        except (csv.Error, ValueError) as error:
            raise InputError(f"expected a CSV, found {error}") from None
        header = [_column(name) for name in header]
        if "file" not in header or len(set(header)) < len(header):
            raise InputError("expected a CSV with a column 'file' and no column twice")
        return _labels(header, lines, files, "," if between == ";" else ".")


def _labels(header: list[str], lines: list[list[str]], files: Sequence[str], point: str) -> Labels:
    """The Labels of the rows of a table. point: what fractions begin with."""
    names = [name for name in header if name not in _OWN_COLUMNS]
    said: dict[str, MeshName] = {}
    values: dict[str, list[float]] = {}
    for number, line in enumerate(lines, 2):
        if not line:
            continue
        with naming(f"line {number}"):
            if len(line) != len(header):
                raise InputError(f"expected {len(header)} columns, found {len(line)}")
            row = {name: normal_name(cell) for name, cell in zip(header, line, strict=True)}
            file = row["file"]
            if file in values:
                raise InputError(f"{file!r} comes twice")
            said[file] = _shown(row)
            values[file] = [_number(row[name].replace(point, "."), name) for name in names]
    missing = [file for file in files if normal_name(file) not in values]
    if missing:
        raise InputError(f"expected a row for every file, found none for {missing[0]} ({len(missing)} in all)")
    rows = [normal_name(file) for file in files]
    ordered = tuple(said[row] for row in rows)
    return Labels(ordered, np.array(names, dtype=str), np.array([values[row] for row in rows], np.float32))


def _column(name: str) -> str:
    """The name of a column; in any capitals it is one of the own."""
    plain = normal_name(name)
    return plain.lower() if plain.lower() in _OWN_COLUMNS else plain


def _name_of(file: str) -> MeshName:
    """What the name of a file says, with its suffix."""
    with naming(file):
        return read_mesh_name(Path(file).stem)


def _shown(row: dict[str, str]) -> MeshName:
    """What a row of a table says of its file; its name says what the table has no column for, or no person in."""
    whole = {"expression", "level"} <= set(row) and row.get("identity")
    name = MeshName("") if whole else _name_of(row["file"])
    level = read_level(row["level"]) if "level" in row else name.level
    person = row.get("identity") or name.person
    return MeshName(person, expression_name(row.get("expression", name.expression) or NEUTRAL), level)


def _number(text: str, name: str) -> float:
    """What a label column, by its name, says of a file."""
    try:
        number = parse_number(text)
    except ValueError:
        column = f"the label column {shown(name, 40)!r}{_meant(name)}"
        raise InputError(f"expected a number in {column}, found {shown(text, 40)!r}") from None
    if abs(number) > _MAX_LABEL:
        raise InputError(f"expected finite labels of single precision, found {shown(text, 40)} for {shown(name, 40)!r}")
    return number


def _meant(name: str) -> str:
    """A question whether a label's name is a misspelt column's, or nothing."""
    columns = get_close_matches(name.lower(), _OWN_COLUMNS, 1, _ALIKE)
    return "".join(f" (is {column} meant?)" for column in columns)
