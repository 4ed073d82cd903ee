"""The runtime that detectors see with."""

import os
import subprocess
import sys

_SEE = """
import numpy as np
from caricli.store.detector import load_detector
detector = load_detector()
detector.search(np.zeros((64, 64, 3), np.uint8))
"""
_TOLD = "CI", "GITHUB_ACTIONS", "ORT_DISABLE_TELEMETRY"  # each keeps it from telling its makers anything, too


def test_it_keeps_and_tells_nothing_of_its_use(tmp_path):
    environment = {name: value for name, value in os.environ.items() if name not in _TOLD}
    places = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    subprocess.run([sys.executable, "-c", _SEE], check=True, env=environment | places)
    assert not [path for path in tmp_path.rglob("*") if "Microsoft" in path.parts]
