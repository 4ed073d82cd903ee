"""Landmark reconstruction: error against prior, flipped triangles and time, for all models and several prior weights.

Usage: python benchmarks/landmarks.py [FOLDER [KIND...]]. FOLDER holds landmark files (default: $CARICLI_REAL_DATA,
else the astronaut). KIND is one of the bundled models, or the path of another .safetensors. The last line is JSON.
For comparison: the deformable paper (section 5.5) needs about 500 ms a face on a Titan Xp.
"""

import json
import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np

from caricli.io.landmarks import read_landmarks
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.models import load_model

ASTRONAUT = Path(__file__).parents[1] / "examples" / "astronaut"
PRIOR_WEIGHTS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
REPEATS = 5
KINDS = ("intrinsic", "kernel", "pca", "deformable")


def curves(marks, kinds):
    """Yield one row for each model and prior weight, averaged over the landmark sets."""
    for kind in kinds:
        model = load_model(Path(kind)) if kind.endswith(".safetensors") else load_model(kind=kind)
        method = "intrinsic" if model.kind == "intrinsic" else "latent"
        model.prepare()
        fit_landmarks(marks[0], model, method)
        for weight in PRIOR_WEIGHTS:
            results = []
            seconds = []
            for points in marks:
                for _ in range(REPEATS if weight == 1.0 else 1):
                    start = time.perf_counter()
                    result = fit_landmarks(points, model, method, weight)
                    seconds.append(time.perf_counter() - start)
                results.append(result)
            yield {
                "method": method,
                "model": kind,
                "prior_weight": weight,
                "nme": float(np.mean([r.nme for r in results])),
                "nme_worst": float(np.max([r.nme for r in results])),
                "nme_latent": float(np.mean([r.nme_latent for r in results])),
                "prior_rms": float(np.mean([r.prior_rms for r in results])),
                "flipped_percent": float(100 * np.mean([r.flipped for r in results])),
                "median_seconds": statistics.median(seconds),
            }


def landmark_files():
    """The landmark files of the folder that the first argument, or the environment, names; else the astronaut's."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("CARICLI_REAL_DATA") or ASTRONAUT)
    return sorted(p for p in folder.resolve().iterdir() if p.suffix in (".json", ".pts", ".txt", ".npy"))


def main():
    """Print the table and the JSON line."""
    files = landmark_files()
    rows = list(curves([read_landmarks(path).points for path in files], sys.argv[2:] or KINDS))
    print(f"{len(files)} landmark sets; NME and flipped triangles in percent; prior: rms of the whitened latent")
    print(
        f"{'model':10} {'weight':>6} {'NME':>6} {'worst':>6} {'latent':>6} {'prior':>6} {'flipped':>7} {'median s':>8}"
    )
    for r in rows:
        print(
            f"{r['model']:10} {r['prior_weight']:6.1f} {r['nme']:6.2f} {r['nme_worst']:6.2f} {r['nme_latent']:6.2f} "
            f"{r['prior_rms']:6.2f} {r['flipped_percent']:7.3f} {r['median_seconds']:8.2f}"
        )
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
