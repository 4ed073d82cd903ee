import re
import subprocess
import sys
import time

import pytest

from caricli.commands.shared.progress import progress_bar
from caricli.commands.shared.waited import waited

SLOW = "import time; time.sleep(0.7); from caricli.commands.shared.waited import waited; print(waited(), waited())"


def test_the_start_of_the_process_counts_and_then_the_last_item():
    start = time.monotonic()
    done = subprocess.run([sys.executable, "-c", SLOW], capture_output=True, text=True, check=True)
    lasted = time.monotonic() - start
    first, second = (float(number) for number in re.findall(r"([\d.]+) s", done.stdout))
    assert 0.69 <= first <= lasted + 0.02 and second < first - 0.5


def test_it_reads_as_seconds():
    waited()
    assert re.fullmatch(r"\d\.\d\d s", waited())


@pytest.mark.parametrize("terminal", [False, True])
def test_a_bar_is_shown_only_where_somebody_looks(terminal, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    monkeypatch.setenv("TTY_COMPATIBLE", "1" if terminal else "0")
    with progress_bar("painting") as report:
        report(1, 2)
    assert ("painting" in capsys.readouterr().err) == terminal
