"""How long commands let one wait, Python's start and pictures among it, and how much processor time they take.

Usage: python benchmarks/waiting.py PICTURE [RUNS]. PICTURE is examples/astronaut/astronaut.png, which `make demo` gets;
its landmarks lie beside it in the repository. Every command runs once to fill the caches, then RUNS times (default: 5)
as a process of its own. Medians of the wall's seconds, and of the processors' (user and system, all threads). On a busy
machine the first say little, and the second are up to twice those of a quiet one. The last line is JSON.
"""

import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MARKS = ROOT / "examples" / "astronaut" / "landmarks.json"


def commands(picture, folder):
    """Command lines by what they are called."""
    face = folder / "face.npz"
    fit = ["reconstruct-from-landmarks", MARKS, "--image", picture, "--out", folder / "face.obj"]
    rig = ["rig", face, "--out", folder / "rig.glb"]
    edit = ["edit-handle", face, "--handle", "nose_tip=0,0,0.01", "--out", folder / "edited.obj"]
    return {
        "`detect`": ["detect", picture, "--out-dir", folder / "detected"],
        "`reconstruct-from-landmarks` with its picture": fit,
        "the same with `--no-picture`": [*fit, "--no-picture"],
        "`texture --size 1024` with hair": ["texture", face, picture, "--size", "1024", "--out", folder / "textured"],
        "`rig` of the whole head with its sheet": rig,
        "`rig --no-picture`": [*rig, "--no-picture"],
        "`rig --parts skin,eyes`": [*rig, "--parts", "skin,eyes"],
        "`edit-handle`": edit,
        "`portrait`": ["portrait", picture, "--out-dir", folder / "portrait"],
    }


def measure(words):
    """Seconds of the wall and of the processors."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run(
        [sys.executable, "-m", "caricli", *map(str, words), "--overwrite"],
        check=True,
        env=environment,
        stdout=subprocess.DEVNULL,
    )
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main():
    """Print the table and the JSON line."""
    picture = Path(sys.argv[1]).resolve()
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, words in commands(picture, Path(folder)).items():
            measure(words)
            seconds = [measure(words) for _ in range(runs)]
            wall, processors = (statistics.median(column) for column in zip(*seconds, strict=True))
            rows[name] = {"wall": wall, "processors": processors}
            print(f"{name:46} {wall:6.2f} s  {processors:6.2f} s of processors", flush=True)
    print(json.dumps({"runs": runs, "commands": rows}))


if __name__ == "__main__":
    main()
