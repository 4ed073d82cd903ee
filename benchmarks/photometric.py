"""What colours tell of a face beyond its landmarks: 3D errors of `fit-morphable` with and without `--photometric`.

Usage: python benchmarks/photometric.py DATASET [COUNT]. The faces are those of `evaluate portrait --data DATASET
--everyone`: people of the dataset whom the model was not trained with, rendered by the studio in random poses, colours
and light, landmarks displaced by 0.3 % of their diagonal. Errors are mean distances of the face's vertices after
alignment in percent of the head's height. The interval is that of the mean of the differences, from 10,000 draws of the
people with replacement. The last line is JSON.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

from caricli.data.dataset import read_dataset
from caricli.data.unseen import unseen_data
from caricli.methods.evaluate.evaluate_portrait import RenderedPortraits, RenderSettings
from caricli.methods.evaluate.ratio_interval import ratio_interval
from caricli.methods.evaluate.reconstruct_portrait import shape_error
from caricli.methods.morphable.fit_photometric import fit_photometric
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.store.models import load_morphable

DRAWS = 10_000
"""Of the people, for the interval."""


def main(folder, count=50):
    """Print a line for every face, the means and the JSON line."""
    model = load_morphable()
    data = unseen_data(read_dataset(Path(folder)), {"morphable": model.seen}, everyone=True).data
    portraits = RenderedPortraits(data, RenderSettings(count=count))
    errors = []
    seconds = []
    for portrait, row in zip(portraits, portraits.rows, strict=True):
        marks = fit_morphable(portrait.points, model)
        start = time.process_time()
        both = fit_photometric(portrait.picture, model)
        seconds.append(time.process_time() - start)
        pair = [shape_error(fit.face.vertices, portrait.truth, data.template) for fit in (marks, both)]
        errors.append(pair)
        kind = "regular" if data.regular[row] else "exaggerated"
        print(f"{portrait.name} ({kind}): {pair[0]:.3f} to {pair[1]:.3f} %", flush=True)
    pairs = np.array(errors)
    regular = data.regular[portraits.rows]
    groups = {"all": np.ones(len(pairs), bool), "regular": regular, "exaggerated": ~regular}
    people = data.identity[portraits.rows]
    figures = {name: compare(pairs[rows], people[rows]) for name, rows in groups.items() if rows.any()}
    for name, own in figures.items():
        low, high = own["interval"]
        change = (
            f"{own['landmarks']:.3f} to {own['photometric']:.3f} %, by {own['change']:.3f} ({low:.3f} to {high:.3f})"
        )
        print(f"{name}: {change}, lower on {own['lower']} of {own['faces']}")
    print(json.dumps({"errors": figures, "seconds": float(np.median(seconds))}))


def compare(pairs, people):
    """Figures of errors (N, 2), landmarks alone and with colours, of people (N,)."""
    change = pairs[:, 1] - pairs[:, 0]
    mean, *interval = ratio_interval(change, np.ones(len(change)), people, DRAWS)
    return {
        "faces": len(pairs),
        "landmarks": float(pairs[:, 0].mean()),
        "photometric": float(pairs[:, 1].mean()),
        "change": mean,
        "interval": interval,
        "lower": int((change < 0).sum()),
    }


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
