"""Whether strokes of sketches without names find the curves that they draw, with what the network sees and without.

Usage: python -m benchmarks.stroke_names DATASET [COUNT]. The sketches are COUNT (default: 60) faces of a dataset whose
people nobody trained on, from the front: clean lines, lines of a hand (moved, bent, some of them left out), the same
without what is drawn beside others, if at all (folds of lids, nostrils, tips of noses, ears), and with what the hand
draws twice and in pieces. Of every stroke but these the curve is known; it is named rightly, wrongly, or not at all.
Figures are percent of the strokes of a sketch whose curve is known, in the mean. The last line is JSON.
"""

import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from caricli.data.dataset import read_dataset
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.name_strokes import name_strokes
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.methods.sketch.settings import BESIDE, SELDOM
from caricli.methods.sketch.vary_sketch import vary_sketch
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.store.sketch_networks import load_sketch_pair
from caricli.structures.sketch import StrokeKind
from caricli.template.feature_curves import named_curves

LINES = ("clean", "by a hand", "by a hand, fewer", "by a hand, twice and in pieces")


def sketches(vertices, curves, generator):
    """Sketches of a face (V, 3) with the names of their curves, one for each of LINES."""
    clean = draw_sketch(vertices, curves, canvas_camera(vertices, curves))
    hand = vary_sketch(clean, generator)
    drawn = hand.with_strokes(stroke for stroke in hand.strokes if stroke.curve)
    fewer = (stroke for stroke in drawn.strokes if not stroke.curve.startswith((*SELDOM, BESIDE)))
    return dict(zip(LINES, (clean, drawn, drawn.with_strokes(fewer), hand), strict=True))


def judged(sketch, name):
    """Shares of the strokes of a sketch that are named rightly and wrongly. name: from a Sketch without to one with."""
    plain = sketch.with_strokes(
        replace(stroke, curve=None, kind=StrokeKind.UNKNOWN, pressure=None) for stroke in sketch.strokes
    )
    # A closed stroke that passes for both lids becomes two.
    told = {stroke.points.tobytes(): stroke.curve for stroke in name(plain).strokes}
    pairs = [(each.curve, told.get(each.points.tobytes(), "another")) for each in sketch.strokes if each.curve]
    right = [curve == name for curve, name in pairs]
    wrong = [name not in (None, curve) for curve, name in pairs]
    return np.mean(right), np.mean(wrong)


def main(dataset, count=60):
    """Print the table."""
    network, basis = load_sketch_pair()
    model = load_model(kind=DEFAULT_LATENT)
    curves = named_curves(model.template.annotation)
    by_boxes = partial(name_strokes, handles=LineHandles(curves), model=model)
    ways = {
        "boxes alone": by_boxes,
        "and what the network sees": partial(by_boxes, see=partial(see_sketch, network=network, basis=basis)),
    }
    faces = read_dataset(Path(dataset)).vertices
    chosen = np.linspace(0, len(faces) - 1, int(count)).astype(int)
    drawn = [sketches(np.asarray(faces[row], float), curves, np.random.default_rng(int(row))) for row in chosen]
    rows = []
    for lines in LINES:
        for way, name in ways.items():
            right, wrong = 100 * np.mean([judged(each[lines], name) for each in drawn], axis=0)
            rows.append({"lines": lines, "way": way, "right": float(right), "wrong": float(wrong)})
            print(f"{lines:30} {way:26} right {right:.1f} %, wrong {wrong:.1f} %", flush=True)
    print(json.dumps({"strokes": rows}))


if __name__ == "__main__":
    main(*sys.argv[1:])
