"""Fuzz the readers for a while.

python -m tests.fuzz --seconds 600 --folder .fuzz [--reader face.npz --reader rig.npz]
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from tests.fuzz.judge import REPORT
from tests.fuzz.readers import READERS

_OPTIONS = ("-max_len=65536", "-timeout=30", "-rss_limit_mb=0", "-print_final_stats=1", "-len_control=0")


def fuzz(folder: Path, seconds: float, readers: Sequence[str] = tuple(READERS), seed: int = 1) -> list[str]:
    """Fuzz readers for so many seconds.

    folder: keeps the corpus for the next time, and the findings. Returns the findings, one text each.
    """
    corpus = folder / "corpus"
    findings = folder / "findings"
    for path in (corpus, findings):
        path.mkdir(parents=True, exist_ok=True)
    end = time.monotonic() + seconds
    with open(folder / "log.txt", "w", encoding="utf-8") as log:
        while (left := int(end - time.monotonic())) > 0:
            options = (*_OPTIONS, f"-max_total_time={left}", f"-seed={seed}", f"-artifact_prefix={findings}/")
            command = [
                sys.executable,
                "-m",
                "tests.fuzz.target",
                str(findings),
                ",".join(readers),
                *options,
                str(corpus),
            ]
            done = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, check=False)
            # It ends early where a file ends the process or hangs, and has written that file down.
            if done.returncode and not any(findings.glob("*-*")):
                return [f"the fuzzer itself ended with {done.returncode}: see {folder / 'log.txt'}"]
            seed += 1
    broken = [path.name for kind in ("crash", "timeout", "oom") for path in sorted(findings.glob(f"{kind}-*"))]
    return [path.read_text("utf-8") for path in sorted(findings.glob(f"*{REPORT}"))] + broken


def main() -> None:
    """Read the options, fuzz, print the findings, and end with 1 where there are some."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--folder", type=Path, default=Path(".fuzz"))
    parser.add_argument("--reader", action="append", choices=READERS)
    options = parser.parse_args()
    findings = fuzz(options.folder, options.seconds, tuple(options.reader or READERS), seed=int(time.time()))
    print("\n".join(findings) or "nothing to say of any reader")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
