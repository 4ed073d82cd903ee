"""Stops commands at random moments by SIGINT and SIGTERM, and says how each ended: code, lines, files, processes."""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
LANDMARKS = ROOT / "examples" / "astronaut" / "landmarks.json"
# What is run, each with the path that it may write below.
COMMANDS: dict[str, list] = {
    "reconstruct-from-landmarks": ["reconstruct-from-landmarks", LANDMARKS, "--out", "{out}/a/face.obj"],
    "rig": ["rig", "{face}", "--out", "{out}/a/rig.glb"],
    "edit-handle": ["edit-handle", "{face}", "--handle", "nose_tip=0,0,5%", "--out", "{out}/a/edited.obj"],
    "sample": ["sample", "--count", "3", "--out-dir", "{out}/a/samples"],
    "dataset build": [
        "dataset",
        "build",
        "{out}/a/dataset",
        "--identities",
        "4",
        "--expressions",
        "2",
        "--workers",
        "2",
    ],
}


def start(command: list, **words: str) -> subprocess.Popen:
    """A command as the leader of its own process group."""
    line = [sys.executable, "-m", "caricli", *(str(part).format(**words) for part in command)]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        line, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def processes_of(group: int) -> list[int]:
    """Processes of a group that still run, from /proc."""
    running = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group and fields[0] != "Z":
            running.append(int(status.parent.name))
    return running


def stop_once(command: list, face: str, delay: float, number: int) -> str:
    """How a command ended that got a signal after some seconds; "ok", "finished before", or what was wrong."""
    with tempfile.TemporaryDirectory() as out:
        process = start(command, out=out, face=face)
        time.sleep(delay)
        process.send_signal(number)
        try:
            stdout, stderr = process.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return "did not end within 60 s"
        time.sleep(0.0 if not processes_of(process.pid) else 2.0)
        if left := processes_of(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
            return f"{len(left)} processes left after 2 s"
        files = [str(path.relative_to(out)) for path in Path(out).rglob("*")]
    if process.returncode == 0 and "stopped by" not in stderr and not any(".caricli-" in name for name in files):
        return "finished before"
    if process.returncode != 128 + number:
        return f"exit {process.returncode}: {stderr.strip().splitlines()[-1:]}"
    if stderr != f"caricli: error: stopped by {signal.Signals(number).name}\n":
        return f"said {stderr!r}"
    return "ok" if not files else f"left {files[:3]}"


def main() -> None:
    """Run the trial that is asked for on the command line and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=200, help="moments for each command")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--earliest", type=float, default=0.0, help="seconds; Python itself starts before")
    parser.add_argument("--only", choices=COMMANDS, action="append")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        assert start(COMMANDS["reconstruct-from-landmarks"], out=folder, face="").wait() == 0
        face = f"{folder}/a/face.npz"
        for name in options.only or COMMANDS:
            began = time.monotonic()
            with tempfile.TemporaryDirectory() as out:
                start(COMMANDS[name], out=out, face=face).wait()
            seconds = time.monotonic() - began
            ends: Counter[str] = Counter()
            for _ in range(options.times):
                delay = float(rng.uniform(options.earliest, seconds))
                number = signal.SIGINT if rng.random() < 0.5 else signal.SIGTERM
                end = stop_once(COMMANDS[name], face, delay, number)
                ends[end] += 1
                if end not in ("ok", "finished before"):
                    print(f"{name} after {delay:.3f} s by {number.name}: {end}", flush=True)
            print(f"{name} ({seconds:.1f} s alone): {dict(ends)}", flush=True)


if __name__ == "__main__":
    # What a shell starts with `&` ignores SIGINT, and so would the commands.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    main()
