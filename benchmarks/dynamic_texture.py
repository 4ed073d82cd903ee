"""One texture in an expression (expressions paper, section 4.4): milliseconds at 1,024 texels, and what they go into.

Usage: python benchmarks/dynamic_texture.py [NETWORK]. The open head with its 52 expressions and a texture of noise; a
random expression for each run, medians of RUNS after a warm-up, and processor time beside the clock's. Without NETWORK
the bundled one is timed. The last line is JSON.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np

from caricli.methods.dynamic.rig_moods import MoodPainter
from caricli.store.texture_networks import load_texture_network
from caricli.structures import Pictures, Rig
from caricli.template.head import load_head

SIDE, RUNS = 1024, 15


def timed(work):
    """Medians of milliseconds by the clock and of the processor."""
    rows = []
    for run in range(RUNS + 1):
        start = np.array([time.perf_counter(), time.process_time()])
        work(run)
        rows.append(1000 * (np.array([time.perf_counter(), time.process_time()]) - start))
    return [round(statistics.median(column), 1) for column in zip(*rows[1:], strict=True)]


def main():
    """Time the whole and its steps."""
    head = load_head()
    template = head.template()
    names = head.action_names
    noise = np.random.default_rng(0).integers(0, 256, (SIDE, SIDE, 3), np.uint8)
    rig = Rig(names, template, head.actions.astype(np.float32), pictures=Pictures(noise))
    model = load_texture_network(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    start = time.perf_counter()
    painter = MoodPainter(rig, template, model)
    began = round(1000 * (time.perf_counter() - start))
    weights = np.random.default_rng(1).uniform(0, 0.3, (RUNS + 1, len(names)))
    shapes = [rig.neutral + np.tensordot(row, rig.deltas, 1) for row in weights]
    steps = {
        "shape": timed(lambda run: painter.person.fields(shapes[run], weights[run])),
        "whole": timed(lambda run: painter.paint(weights[run])),
    }
    for name, (clock, processor) in steps.items():
        print(f"{name:8s}{clock:9.1f} ms{processor:9.1f} ms of processor")
    print(json.dumps({"begin_ms": began, **steps}))


if __name__ == "__main__":
    main()
