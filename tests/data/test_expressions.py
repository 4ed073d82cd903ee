import pytest

from caricli.data.expressions import expand_sides
from caricli.errors import InputError
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml

NAMES = ("jawOpen", "mouthSmileLeft", "mouthSmileRight", "browDownLeft", "browDownRight")


def test_a_name_without_a_side_stands_for_both():
    weights = {"mouthSmile": 1, "jawOpen": 0.3}
    assert expand_sides(weights, NAMES) == {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0, "jawOpen": 0.3}
    assert expand_sides({"browDownLeft": 0.2}, NAMES) == {"browDownLeft": 0.2}


def test_an_unknown_name_is_refused():
    with pytest.raises(InputError, match="earWiggle"):
        expand_sides({"earWiggle": 1.0}, NAMES)


def test_the_bundled_table_has_25_expressions_of_known_actions(head):
    table = read_yaml(asset_path("expressions.yaml"))
    assert len(table) == 25 and next(iter(table)) == "neutral"
    assert sum(name.startswith("caricature_") for name in table) == 14
    for name, weights in table.items():
        expanded = expand_sides(weights, head.action_names)
        assert all(0 < weight <= 1 for weight in expanded.values()), name
        assert bool(expanded) == (name != "neutral")
    assert len({str(weights) for weights in table.values()}) == 25
