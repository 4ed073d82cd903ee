import pytest

from caricli.errors import InputError
from caricli.io.strict_json import write_json
from caricli.store.handles import load_handles


def test_handles_of_a_file_and_of_none(tmp_path):
    write_json(tmp_path / "a.json", {"nose_tip": [0, 0, "5%"], "12": [0.01, 0, 0]})
    assert load_handles(tmp_path / "a.json") == [("nose_tip", [0, 0, "5%"]), ("12", [0.01, 0, 0])]
    assert load_handles(None) == []


def test_other_json_is_refused_with_its_path(tmp_path):
    write_json(tmp_path / "a.json", [1])
    with pytest.raises(InputError, match="a.json: expected a JSON object .* found list"):
        load_handles(tmp_path / "a.json")
