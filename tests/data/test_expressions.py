import pytest

from caricli.data.expressions import expand_sides, named_expressions, read_expressions, single_expressions
from caricli.errors import InputError
from caricli.structures.arkit import ARKIT_NAMES

NAMES = ("jawOpen", "mouthSmileLeft", "mouthSmileRight", "browDownLeft", "browDownRight")


def test_a_name_whose_sides_undo_each_other_is_refused():
    for name in ("jaw", "mouth"):
        with pytest.raises(InputError, match=f"'{name}': {name}Left and {name}Right undo each other"):
            expand_sides({name: 1.0}, ARKIT_NAMES)


def test_a_name_without_a_side_stands_for_both():
    weights = {"mouthSmile": 1, "jawOpen": 0.3}
    assert expand_sides(weights, NAMES) == {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0, "jawOpen": 0.3}
    assert expand_sides({"browDownLeft": 0.2}, NAMES) == {"browDownLeft": 0.2}


def test_a_side_that_is_named_itself_has_its_own_weight_in_either_order():
    for weights in ({"browDownLeft": 1, "browDown": 0.2}, {"browDown": 0.2, "browDownLeft": 1}):
        assert expand_sides(weights, NAMES) == {"browDownLeft": 1.0, "browDownRight": 0.2}


def test_an_unknown_name_is_refused():
    with pytest.raises(InputError, match="earWiggle"):
        expand_sides({"earWiggle": 1.0}, NAMES)


def test_the_bundled_table_has_25_expressions_of_known_actions(head):
    table = named_expressions(head.action_names)
    assert len(table) == 25 and next(iter(table)) == "neutral"
    assert sum(name.startswith("caricature_") for name in table) == 14
    for name, weights in table.items():
        assert set(weights) <= set(head.action_names)
        assert all(0 < weight <= 1 for weight in weights.values()), name
        assert bool(weights) == (name != "neutral")
    assert len({str(weights) for weights in table.values()}) == 25


def test_the_default_set_is_neutral_and_every_action(head):
    table = single_expressions(head.action_names)
    assert list(table) == ["neutral", *head.action_names]
    assert table["neutral"] == {} and table["jawOpen"] == {"jawOpen": 1.0}


def test_a_file_is_read_with_the_neutral_one_first(tmp_path):
    path = tmp_path / "set.yaml"
    path.write_text("smile: {mouthSmile: 0.7, jawOpen: 0}\nneutral: {}\n")
    smile = {"mouthSmileLeft": 0.7, "mouthSmileRight": 0.7, "jawOpen": 0.0}
    expected = {"neutral": {}, "smile": smile}
    assert read_expressions(path, NAMES) == expected and list(read_expressions(path, NAMES)) == list(expected)
    path.write_text('{"neutral": {}, "smile": {"mouthSmileLeft": 1.5}}')
    assert read_expressions(path, NAMES)["smile"] == {"mouthSmileLeft": 1.5}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("smile: {jawOpen: 1}\nfrown: {jawOpen: 1}", "expected an expression 'neutral' without actions, found none"),
        ("neutral: {jawOpen: 1}\nfrown: {jawOpen: 1}", "expected an expression 'neutral' without actions"),
        ("neutral: {}\na: {jawOpen: 1}\na: {jawOpen: 0.5}", "expected distinct keys, found 'a' twice"),
        ("neutral: {}\na: {jawOpen: -0.1}", "a: expected weights from 0 to 1.5, found jawOpen: -0.1"),
        ("neutral: {}\na: {jawOpen: .nan}", "expected weights from 0 to 1.5"),
        ("neutral: {}\na: {jawOpen: yes}", "expected weights from 0 to 1.5"),
        ("neutral: {}\na: {earWiggle: 1}", "a: no ARKit action is named 'earWiggle'"),
        ("neutral: {}\na: {1: 0.5}", "a: expected names that are text, found 1"),
        ("neutral: {}\nno: {jawOpen: 1}", "expected names that are text, found False; in YAML write it in quotes"),
        ("neutral: {}\n~: {jawOpen: 1}", "expected names that are text, found None"),
        ("neutral: {}\na: {}", "a: expected actions with weights, found {}"),
        ("neutral: {}\na: {jawOpen: 0, cheekPuff: 0.0}", "a: expected a weight above 0, found {'jawOpen': 0"),
        ("neutral: {}", "expected 2 to"),
        ("[neutral, smile]", "expected 2 to"),
    ],
)
def test_bad_files_are_refused(text, words, tmp_path):
    path = tmp_path / "set.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_expressions(path, NAMES)
    assert words in str(refused.value) and "set.yaml" in str(refused.value) and "\n" not in str(refused.value)
