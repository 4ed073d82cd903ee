import os
import subprocess
import sys

from caricli.render.sheets.plot_curves import plot_curves

CURVES = {"error": {"train": ([1, 2, 3], [3.0, 2.0, 1.5]), "validation": ([2], [2.5])}}


def test_panels_are_side_by_side():
    one = plot_curves(CURVES)
    two = plot_curves(CURVES | {"other": CURVES["error"]})
    assert two.shape == (one.shape[0], 2 * one.shape[1], 3)
    assert one.std() > 0


def test_it_is_silent_where_there_is_no_home():
    code = f"from caricli.render.sheets.plot_curves import plot_curves; plot_curves({CURVES})"
    environment = {k: v for k, v in os.environ.items() if k != "XDG_CACHE_HOME"} | {"HOME": "/dev/null"}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
