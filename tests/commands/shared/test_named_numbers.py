import pytest

from caricli.commands.shared.options import named_numbers
from caricli.errors import UsageError


def test_numbers_by_name():
    numbers = named_numbers("--label", ("Big=2", "a=b=-1.5", "odd=1e-3"), "NAME=S", "label")
    assert numbers == {"Big": 2, "a=b": -1.5, "odd": 1e-3}
    assert named_numbers("--label", (), "NAME=S", "label") == {}


@pytest.mark.parametrize("text", ["Big", "Big=", "Big=much", "", "Big=1_0", "Big= 1", "Big=nan", "Big=\u0661"])
def test_other_forms_are_refused(text):
    with pytest.raises(UsageError, match=f"^--label {text}: expected NAME=S"):
        named_numbers("--label", (text,), "NAME=S", "label")


def test_a_name_is_needed_and_only_once():
    with pytest.raises(UsageError, match="--label =1: expected NAME=S, found the label ''"):
        named_numbers("--label", ("=1",), "NAME=S", "label")
    with pytest.raises(UsageError, match="--label: expected every label once, found a=1 a=2"):
        named_numbers("--label", ("a=1", "a=2"), "NAME=S", "label")


@pytest.mark.parametrize("value", ["-0.1", "3.1", "nan", "inf"])
def test_limits(value):
    assert named_numbers("--scale", ("a=0", "b=3"), "NAME=K", "expression", (0, 3)) == {"a": 0, "b": 3}
    with pytest.raises(UsageError, match=f"--scale a={value}: expected NAME=K"):
        named_numbers("--scale", (f"a={value}",), "NAME=K", "expression", (0, 3))
