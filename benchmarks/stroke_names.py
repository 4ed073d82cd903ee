"""Whether strokes of sketches without names find the curves that they draw, with what networks tell and without.

Usage: python -m benchmarks.stroke_names DATASET [COUNT]. The sketches are COUNT (default: 60) faces of a dataset whose
people nobody trained on, from the front: clean lines, lines of a hand (moved, bent, some of them left out), the same
without what is drawn beside others, if at all (folds of lids, nostrils, tips of noses, ears), and with what the hand
draws twice and in pieces. Of every stroke but these the curve is known; along it a line is named rightly, wrongly, or
not at all, a stroke's pieces each by itself. The same sketches drawn in ink on paper are read again as pictures, where
lines run into each other; there a place of a stroke is named rightly where a line of its name lies within 0.6 % of the
drawing's longer side. Figures are percent of the strokes of a sketch whose curve is known, in the mean. The last line
is JSON.
"""

import itertools
import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from caricli.data.dataset import read_dataset
from caricli.errors import InputError
from caricli.geometry.lines.match_line import resample
from caricli.methods.sketch.clean_drawing import clean_drawing
from caricli.methods.sketch.draw_sketch import canvas_camera, draw_sketch
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.name_strokes import name_strokes
from caricli.methods.sketch.read_strokes import read_strokes
from caricli.methods.sketch.see_sketch import see_sketch
from caricli.methods.sketch.settings import BESIDE, SELDOM
from caricli.methods.sketch.vary_sketch import vary_sketch
from caricli.render.pixels.rasterise_sketch import rasterise_sketch
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.store.sketch_networks import load_sketch_pair
from caricli.store.strokes import load_strokes
from caricli.structures.sketch import StrokeKind
from caricli.template.feature_curves import named_curves

LINES = ("clean", "by a hand", "by a hand, fewer", "by a hand, twice and in pieces")
ON_PAPER = ("clean", "by a hand, twice and in pieces")
SIDE = 900
"""Pixels of the paper."""
WIDTH = 2.5
"""Pixels of a line on it."""
NEAR = 0.006
"""Of the drawing's longer side: as near a line is the one that was drawn."""
DENSE = 200
"""Places along a stroke."""


def sketches(vertices, curves, generator):
    """Sketches of a face (V, 3) with the names of their curves, one for each of LINES."""
    clean = draw_sketch(vertices, curves, canvas_camera(vertices, curves))
    hand = vary_sketch(clean, generator)
    drawn = hand.with_strokes(stroke for stroke in hand.strokes if stroke.curve)
    fewer = (stroke for stroke in drawn.strokes if not stroke.curve.startswith((*SELDOM, BESIDE)))
    return dict(zip(LINES, (clean, drawn, drawn.with_strokes(fewer), hand), strict=True))


def on_paper(sketch):
    """A sketch drawn in ink, as it is read from the picture."""
    ink = rasterise_sketch(sketch, SIDE, WIDTH)
    return clean_drawing(np.repeat(255 - ink[..., None], 3, 2))


def judged(sketch, name):
    """Shares of the strokes of a sketch that are named rightly and wrongly. name: from a Sketch without to one with."""
    named = name(nameless(sketch)).strokes
    # A closed stroke that passes for two curves is drawn anew.
    pieces = {row.tobytes(): stroke.curve for stroke in named for row in stroke.points[1:-1]}
    shares = []
    for stroke in sketch.strokes:
        if stroke.curve:
            told = [pieces.get(row.tobytes(), "another") for row in stroke.points[1:-1]]
            right = [curve == stroke.curve for curve in told]
            wrong = [curve not in (None, stroke.curve) for curve in told]
            shares.append((np.mean(right), np.mean(wrong)))
    return np.mean(shares, axis=0)


def judged_on_paper(sketch, name):
    """The same of a sketch that is drawn on paper and read again."""
    try:
        named = name(on_paper(sketch)).strokes
    except InputError:
        return np.zeros(2)
    names = np.array([stroke.curve or "" for stroke in named for _ in range(DENSE)])
    drawn, read = (boxed([resample(stroke.points, DENSE) for stroke in each]) for each in (sketch.strokes, named))
    shares = []
    for stroke, points in zip(sketch.strokes, drawn.reshape(-1, DENSE, 2), strict=True):
        if stroke.curve:
            own = read[names == stroke.curve]
            right = KDTree(own).query(points)[0] < NEAR if len(own) else np.zeros(DENSE, bool)
            away, nearest = KDTree(read).query(points)
            wrong = ~right & (away < NEAR) & (names[nearest] != "")
            shares.append((right.mean(), wrong.mean()))
    return np.mean(shares, axis=0)


def boxed(lines):
    """Points (N, 2) of lines in a box of their own."""
    points = np.concatenate(lines)
    return (points - points.min(0)) / np.ptp(points, axis=0).max()


def nameless(sketch):
    """A sketch that says nothing of what its strokes draw."""
    return sketch.with_strokes(
        replace(stroke, curve=None, kind=StrokeKind.UNKNOWN, pressure=None) for stroke in sketch.strokes
    )


def main(dataset, count=60):
    """Print the table."""
    network, basis = load_sketch_pair()
    model = load_model(kind=DEFAULT_LATENT)
    curves = named_curves(model.template.annotation)
    by_boxes = partial(name_strokes, handles=LineHandles(curves), model=model)
    by_face = partial(by_boxes, see=partial(see_sketch, network=network, basis=basis))
    ways = {
        "boxes alone": by_boxes,
        "and what a network sees": by_face,
        "and what another reads": partial(by_face, read=partial(read_strokes, network=load_strokes())),
    }
    faces = read_dataset(Path(dataset)).vertices
    chosen = np.linspace(0, len(faces) - 1, int(count)).astype(int)
    drawn = [sketches(np.asarray(faces[row], float), curves, np.random.default_rng(int(row))) for row in chosen]
    rows = []
    for judge, kinds, where in ((judged, LINES, ""), (judged_on_paper, ON_PAPER, ", on paper")):
        for lines, (way, name) in itertools.product(kinds, ways.items()):
            right, wrong = 100 * np.mean([judge(each[lines], name) for each in drawn], axis=0)
            rows.append({"lines": f"{lines}{where}", "way": way, "right": float(right), "wrong": float(wrong)})
            print(f"{lines + where:30} {way:26} right {right:.1f} %, wrong {wrong:.1f} %", flush=True)
    print(json.dumps({"strokes": rows}))


if __name__ == "__main__":
    main(*sys.argv[1:])
