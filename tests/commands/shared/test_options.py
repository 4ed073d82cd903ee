import click
import pytest

from caricli.cli import COMMANDS, cli
from caricli.commands.shared.options import FiniteRange, WholeRange

NO_NUMBERS = ["1_0", " 1", "1 ", "\u0661", "\uff11", "nan", "inf", "0x10", "1e999", "", "1,5", "--1"]


@pytest.mark.parametrize("kind", [FiniteRange(0, 100), WholeRange(0, 100)])
@pytest.mark.parametrize("text", NO_NUMBERS)
def test_what_is_no_number_is_wrong_usage(kind, text):
    with pytest.raises(click.BadParameter, match="is (no|a) "):
        kind.convert(text, None, None)


def test_numbers_are_taken():
    assert FiniteRange(0, 100).convert("1.5e1", None, None) == 15
    assert FiniteRange(0, 100).convert(".5", None, None) == FiniteRange(0, 100).convert(0.5, None, None) == 0.5
    assert WholeRange(0, 100).convert("10", None, None) == WholeRange(0, 100).convert(10, None, None) == 10
    for text in ("1.0", "1e1", "010"):
        with pytest.raises(click.BadParameter):
            WholeRange(0, 100).convert(text, None, None)


@pytest.mark.parametrize("name", [name for name, entry in COMMANDS.items() if entry[0]])
def test_every_option_takes_numbers_alike(name):
    command = cli
    for word in name.split():
        command = command.get_command(None, word)
    plain = (click.types.IntParamType, click.types.FloatParamType)
    kinds = [part for option in command.params for part in getattr(option.type, "types", [option.type])]
    assert [kind for kind in kinds if isinstance(kind, plain) and not isinstance(kind, FiniteRange | WholeRange)] == []


@pytest.mark.parametrize("command", [("sample", "--count"), ("caricaturize", "f.npz", "--strength")])
def test_it_is_said_in_one_line(run, tmp_path, command):
    result = run(*command, "1_0", "--out-dir", tmp_path / "out")
    assert result.exit_code == 2 and "'1_0' is no " in result.stderr
