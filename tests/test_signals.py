"""Signals at awkward moments: while a module is imported, in a callback, in a step that must be whole."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import caricli
from caricli import signals

ROOT = Path(caricli.__file__).parents[1]


def process(code, *arguments, **options):
    return subprocess.Popen(
        [sys.executable, *arguments, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def ask(number=signal.SIGTERM):
    os.kill(os.getpid(), number)


def test_a_signal_waits_for_the_end_of_an_import(tmp_path, monkeypatch):
    (tmp_path / "extension_of_a_test.py").write_text(
        "import os, signal\nos.kill(os.getpid(), signal.SIGTERM)\nfor _ in range(1000):\n    pass\nwhole = True\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(signals.Stopped) as stop, signals.raising():
        import extension_of_a_test  # noqa: F401

        threading.Event().wait(30)
        pytest.fail("nobody stopped")
    assert stop.value.number == signal.SIGTERM
    assert sys.modules.pop("extension_of_a_test").whole


def test_a_swallowed_stop_comes_again_and_says_nothing(capsys):
    class Finaliser:
        def __del__(self):
            ask()

    with pytest.raises(signals.Stopped), signals.raising():
        finaliser = Finaliser()
        del finaliser
        threading.Event().wait(30)
        pytest.fail("nobody stopped")
    assert capsys.readouterr().err == ""


def test_a_failure_after_a_signal_is_the_stop():
    with pytest.raises(signals.Stopped) as stop, signals.raising(), signals.held():
        ask(signal.SIGINT)
        raise ImportError("std::bad_cast")
    assert stop.value.number == signal.SIGINT


def test_a_held_step_is_done_whole():
    steps = []
    with pytest.raises(signals.Stopped), signals.raising():
        with signals.held():
            ask()
            with signals.held():
                steps.append("first")
            threading.Event().wait(3 * signals.ASK_AGAIN)
            steps.append("second")
        steps.append("third")
    assert steps == ["first", "second"]


def test_what_cleans_up_is_not_interrupted():
    cleaned = []
    with pytest.raises(signals.Stopped), signals.raising():
        try:
            ask()
            threading.Event().wait(30)
        finally:
            ask(signal.SIGINT)
            threading.Event().wait(3 * signals.ASK_AGAIN)
            cleaned.append("all")
    assert cleaned == ["all"]


def test_an_alarm_that_comes_too_late_sets_no_clock():
    with pytest.raises(signals.Stopped), signals.raising():
        ask()
        threading.Event().wait(30)
    signal.raise_signal(signal.SIGALRM)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_without_a_signal_nothing_changes():
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)]
    hook = sys.unraisablehook
    with signals.raising(), signals.held():
        signals.raise_if_asked()
    assert sys.unraisablehook is hook
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)] == before
    with pytest.raises(ZeroDivisionError), signals.raising():
        _ = 1 / 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_command_line_listens_before_it_is_imported(number, tmp_path):
    # A stand-in for click that says when it is imported and takes its time.
    (tmp_path / "click.py").write_text("import time\nprint('importing', flush=True)\ntime.sleep(60)\n")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from caricli.__main__ import main; main()"
    early = process(code)
    assert early.stdout is not None and early.stdout.readline() == "importing\n"
    early.send_signal(number)
    _, said = early.communicate(timeout=30)
    assert early.returncode == 128 + number
    assert said == f"caricli: error: stopped by {number.name}\n"
