"""Weights over time as files that caricli reads and does not write."""

import numpy as np

from caricli.io.outputs import write_bytes
from caricli.io.strict_json import format_json
from caricli.io.takes.track import SCHEMA


def write_weights(path, track):
    """Write weights as caricli's JSON: fps where the times are even, else the times."""
    times = np.asarray(track.times, float)
    fps = round((len(times) - 1) / times[-1] if len(times) > 1 else track.fps, 6)
    even = np.array_equal(times, np.arange(len(times)) / fps)
    value = {"schema": SCHEMA, "names": list(track.names), "weights": track.weights}
    value |= {"fps": fps} if even else {"times": times}
    value |= {} if track.head is None else {"head": track.head}
    write_bytes(path, format_json(value, path, indent=None).encode())
