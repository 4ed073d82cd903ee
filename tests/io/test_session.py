import json

import pytest

from caricli.errors import InputError
from caricli.io.session import SCHEMA, read_session, write_session
from caricli.structures import Operation, Session, Start

OPERATIONS = (
    Operation("draw", {"points": [[0.1, 1 / 3], [2, 5e5 + 1e-6]], "pressure": [0.5, 1.0]}),
    Operation("clear"),
    Operation("expression", {"weights": {"jawOpen": 0.7}}),
)


@pytest.mark.parametrize("start", [None, Start("Gesicht ä.npz", "ab" * 32)])
@pytest.mark.parametrize("count", [0, 1, 3])
def test_what_is_written_is_read_again(tmp_path, start, count):
    session = Session(start, OPERATIONS[:count])
    write_session(tmp_path / "s.json", session)
    assert read_session(tmp_path / "s.json") == session
    assert json.loads((tmp_path / "s.json").read_text("utf-8"))["schema"] == SCHEMA
    assert len((tmp_path / "s.json").read_text("utf-8").splitlines()) == (1 if count == 0 else 2 + count)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([], "expected a session of the schema 'caricli.session/1', found none"),
        ({"schema": "caricli.sketch/1"}, "found 'caricli.sketch/1'"),
        ({"schema": SCHEMA}, "operations: expected list"),
        ({"schema": SCHEMA, "operations": [], "run": "rm"}, "expected only schema, start, operations, found 'run'"),
        ({"schema": SCHEMA, "operations": [3]}, "operation 0: expected an object with name and parameters, found int"),
        ({"schema": SCHEMA, "operations": [{"name": "draw", "x": 1}]}, "operation 0: expected only name, parameters"),
        ({"schema": SCHEMA, "operations": [{"name": 1}]}, "operation 0: name: expected str, found int"),
        ({"schema": SCHEMA, "operations": [], "start": "face.npz"}, "start: expected an object with file and sha256"),
        (
            {"schema": SCHEMA, "operations": [], "start": {"file": "../../etc/passwd", "sha256": "ab" * 32}},
            "start: file: expected the name of a file without a folder",
        ),
    ],
)
def test_what_is_no_session_is_refused_in_one_line(tmp_path, value, message):
    path = tmp_path / "s.json"
    path.write_text(json.dumps(value))
    with pytest.raises(InputError) as error:
        read_session(path)
    assert str(error.value).startswith(f"{path}: ") and message in str(error.value)
    assert "\n" not in str(error.value)
