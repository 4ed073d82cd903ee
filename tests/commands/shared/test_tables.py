import click
import numpy as np
from click.testing import CliRunner

from caricli.commands.shared.tables import number, print_directions, print_table, shape_errors
from caricli.methods.evaluate.evaluate_shape import ShapeError
from caricli.structures import Directions


def printed(function, *args):
    result = CliRunner().invoke(click.command()(lambda: function(*args)))
    assert result.exit_code == 0, result.output
    return result.stdout.splitlines()


def test_a_table_in_a_file_has_one_width_and_whole_names():
    name = "a name of many words, " * 3
    lines = printed(print_table, ("method", "error %"), [(name, "1.00"), ("b", "-")], "two methods")
    assert any(name.strip() in line and "1.00" in line for line in lines)
    assert max(map(len, lines)) <= 120 and "two methods" in lines[0]


def test_numbers_have_their_digits_and_none_is_a_dash():
    assert number(1.2345, 2) == "1.23" and number(None, 3) == "-"


def test_errors_are_named_by_their_split():
    errors = {"train": ShapeError(3, 1.0, 0.5, 1.0), "test": ShapeError(2, 2.0, 1.0, 1.0)}
    assert shape_errors(errors) == "shape error train 0.500 %, test 1.000 % of the head's height"


def test_directions_stand_in_columns():
    figures = (np.array([0.9]), np.array([4]), 12, np.array([0.1]), np.array([0.5]))
    directions = Directions(("BigNose",), np.eye(2)[:1], np.eye(2)[:1], *figures, "", {}, np.eye(2))
    first, nose = printed(print_directions, directions)
    assert first.split() == ["label", "AUC", "positives", "change"]
    assert nose.split() == ["BigNose", "0.900", "4", "0.50"]
