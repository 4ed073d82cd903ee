import subprocess
import sys

import pytest

from caricli.models.kinds import KINDS, config_class, model_class


@pytest.mark.parametrize("kind", KINDS)
def test_the_classes_of_a_kind_are_found_by_its_name(kind):
    assert model_class(kind).kind == kind
    assert config_class(kind)().seed == 0


def test_every_kind_has_tests(tested_kinds):
    """What every shape model must do, or a file of its own where a model is not trained on shapes alone."""
    assert set(KINDS) == {*tested_kinds, "deformable", "morphable", "bilinear"}


@pytest.mark.parametrize("kind", KINDS)
def test_a_class_is_imported_only_when_it_is_asked_for(kind):
    """Nobody who asks for settings, or for a model of arrays, waits for torch."""
    asked = "config_class" if kind == "deformable" else "model_class"
    lines = ["import sys", "from caricli.models.kinds import config_class, model_class", f"{asked}({kind!r})"]
    run = subprocess.run(
        [sys.executable, "-c", "; ".join([*lines, "print('torch' in sys.modules)"])],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == "False"
