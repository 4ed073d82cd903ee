"""Write weights of a face that talks, blinks, smiles and looks about: make_weights.py WEIGHTS.json [SECONDS].

It starts and ends at rest, so that it can run in a loop.
"""

import json
import sys
from pathlib import Path

import numpy as np

FPS = 30
REST = 0.5  # seconds of it at the end
MIDDLE = ("browInnerUp", "jawOpen", "mouthClose", "mouthFunnel", "mouthPucker")  # these have no left and right
BLINK = (0.45, 1.0, 1.0, 0.65, 0.25)  # frame by frame: lids fall faster than they rise
SYLLABLES = (
    {"jawOpen": 0.7, "mouthLowerDown": 0.3},
    {"jawOpen": 0.35, "mouthStretch": 0.5, "mouthUpperUp": 0.4, "mouthLowerDown": 0.4},
    {"jawOpen": 0.45, "mouthFunnel": 0.9},
    {"jawOpen": 0.25, "mouthPucker": 0.9, "mouthFunnel": 0.4},
)


def bump(times, start, attack, hold, decay):
    """A curve (T,) that rises smoothly from 0 to 1, stays, and falls again; seconds."""
    rise, fall = (np.clip(x, 0, 1) for x in ((times - start) / attack, (times - start - attack - hold) / decay))
    return rise**2 * (3 - 2 * rise) * (1 - fall**2 * (3 - 2 * fall))


def talk(times, rng):
    """Phrases of syllables, some of which begin with closed lips as m, b and p do; and where each phrase starts."""
    curves = {name: np.zeros_like(times) for name in sorted({name for s in SYLLABLES for name in s})}
    closed, starts, now, end = np.zeros_like(times), [], 0.6, times[-1] - REST
    while now + 0.9 < end:
        starts.append(now)
        stop = min(now + rng.uniform(1.6, 2.4), end - 0.3)
        # Within a phrase the jaw never shuts: it is the lips that do.
        curves["jawOpen"] = np.maximum(curves["jawOpen"], 0.12 * bump(times, now, 0.1, stop - now - 0.1, 0.2))
        while now < stop:
            length, stress = rng.uniform(0.18, 0.28), rng.uniform(0.7, 1)
            if rng.random() < 0.35:
                closed = np.maximum(closed, bump(times, now - 0.07, 0.06, 0.03, 0.07))
            for name, weight in SYLLABLES[rng.integers(len(SYLLABLES))].items():
                curve = stress * weight * bump(times, now, 0.4 * length, 0.1 * length, 0.9 * length)
                # A mouth goes from one sound into the next.
                curves[name] = np.maximum(curves[name], curve)
            now += length
        now += rng.uniform(1.1, 1.6)
    for name in curves:
        if name != "jawOpen":
            curves[name] *= 1 - closed
    # mouthClose takes back what jawOpen opened.
    return curves | {"mouthClose": closed * curves["jawOpen"]}, starts


def face(seconds, rng):
    """Weights (T,) by ARKit's names, and yaw, pitch and roll of the head (T, 3) in radians."""
    times = np.arange(round(seconds * FPS)) / FPS
    curves, starts = talk(times, rng)

    # A smile comes and goes, and gives way where the lips are busy.
    smile = np.zeros_like(times)
    for start in np.arange(2.6, seconds - 1.5, 4.0):
        smile = np.maximum(smile, bump(times, start, 0.4, 0.7, 0.7))
    free = 1 - 0.6 * np.maximum(curves["mouthPucker"], curves["mouthFunnel"])
    curves |= {"mouthSmile": 0.85 * smile * free, "cheekSquint": 0.6 * smile, "eyeSquint": 0.35 * smile}
    brow = sum((rng.uniform(0.4, 0.8) * bump(times, start - 0.1, 0.2, 0.2, 0.6) for start in starts), 0 * times)
    curves |= {"browInnerUp": brow, "browOuterUp": 0.6 * brow}

    blink, frame = np.zeros_like(times), round(0.3 * FPS)
    while frame + len(BLINK) < len(times):
        blink[frame : frame + len(BLINK)] = BLINK
        frame += round(rng.uniform(1.6, 3.2) * FPS)
    # Wide eyes blink as well, and squinting lids have less far to go.
    curves["eyeBlink"] = blink * (1 - 0.3 * curves["eyeSquint"])

    # Eyes leap and rest; the head follows a little, and nods with what is said.
    side, up, now = np.zeros_like(times), np.zeros_like(times), 1.0
    while now + 1.2 < seconds - REST:
        length = rng.uniform(0.5, 1.1)
        leap = bump(times, now, 0.06, length, 0.06)
        side, up = side + rng.uniform(-0.6, 0.6) * leap, up + rng.uniform(-0.35, 0.25) * leap
        now += length + rng.uniform(0.4, 1.2)
    for name, curve in {"OutLeft": side, "InRight": side, "InLeft": -side, "OutRight": -side}.items():
        curves[f"eyeLook{name}"] = np.maximum(curve, 0)
    curves |= {"eyeLookUp": np.maximum(up, 0), "eyeLookDown": np.maximum(-up, 0)}
    awake = bump(times, 0, 0.6, seconds - 1.2, 0.5)
    sway = [np.sin(2 * np.pi * (times / period + rng.random())) for period in (4.1, 2.9, 5.3)]
    head = awake[:, None] * np.stack([0.1 * sway[0], 0.04 * sway[1], 0.04 * sway[2]], -1)
    head[:, 1] += 0.08 * curves["jawOpen"] - 0.05 * brow

    both = {}
    for name, curve in curves.items():
        whole = name.endswith(("Left", "Right")) or name in MIDDLE
        both |= {name: curve} if whole else {f"{name}Left": curve, f"{name}Right": curve}
    return both, head


def main(path, seconds=10.0):
    """Write the weights as caricli's JSON."""
    curves, head = face(float(seconds), np.random.default_rng(7))
    weights = np.clip(np.stack(list(curves.values()), -1), 0, 1)
    track = {"schema": "caricli.weights/1", "fps": FPS, "names": list(curves)}
    track |= {"weights": weights.round(4).tolist(), "head": head.round(4).tolist()}
    Path(path).write_text(json.dumps(track) + "\n", "utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
