"""Sketches whose lines no renderer of ours drew: how near the landmarks of the faces of them come.

The lines are the landmarks of real drawings, as polylines and joined to smooth strokes, with names and without; and the
edges of the drawings. The folder has a picture N.jpg and a file N.txt of 68 landmarks for every drawing, as the public
data of Wu et al. (2018) have them. Errors are mean distances of the projected landmarks from the given ones in percent
of the diagonal of these (NME), without following the lines and with.
"""

import argparse
import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from skimage.color import rgb2gray
from skimage.filters import gaussian
from skimage.transform import resize

from caricli.errors import InputError
from caricli.geometry.lines.cubic_spline import CubicSpline
from caricli.geometry.lines.trace_lines import trace_lines
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks
from caricli.methods.parts.whole_head import whole_head
from caricli.methods.sketch.read_strokes import read_strokes
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.render.sheets.sketch_sheet import sketch_sheet
from caricli.store.landmark_encoders import elastic_encoder
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.store.strokes import load_strokes
from caricli.structures.landmarks import (
    BRIDGE,
    BROW_LEFT,
    BROW_RIGHT,
    JAW,
    LOWER_LID,
    LOWER_LIP,
    LOWER_LIP_INSIDE,
    NOSTRILS,
    UPPER_LID,
    UPPER_LIP,
    UPPER_LIP_INSIDE,
)
from caricli.structures.sketch import Sketch, Stroke, StrokeKind

LINES = {
    "silhouette": JAW, "brow_right": BROW_RIGHT, "brow_left": BROW_LEFT, "nose_bridge": BRIDGE, "nose": NOSTRILS,
    "eye_upper_left": UPPER_LID["left"], "eye_lower_left": LOWER_LID["left"],
    "eye_upper_right": UPPER_LID["right"], "eye_lower_right": LOWER_LID["right"],
    "mouth_upper": UPPER_LIP, "mouth_lower": LOWER_LIP,
    "mouth_inner_upper": UPPER_LIP_INSIDE, "mouth_inner_lower": LOWER_LIP_INSIDE,
}  # fmt: skip
"""Landmarks of iBUG-68 along the curves of a head."""

POINTS = 48

KINDS = ("polylines", "curves", "named", "nameless", "edges")
"""How landmarks become lines; "edges" are those of the picture, which know of no landmarks."""

PIECES = 8
"""Points to a piece of a curve between two landmarks."""

SIDE = 512
"""Pixels of the longer side of a picture whose edges are found."""


def smooth_line(points):
    """Points (48, 2) of the spline through landmarks (N, 2), N at least 4, by the lengths between them."""
    steps = np.maximum(np.linalg.norm(np.diff(points, axis=0), axis=1), 1e-3)
    knots = np.concatenate([[0], np.cumsum(steps)])
    return CubicSpline(knots, points)(np.linspace(0, knots[-1], POINTS))


def curved_line(points):
    """Points (8 N - 7, 2) of the curve of Catmull and Rom through landmarks (N, 2), as drawing programs have it."""
    ends = 2 * points[[0, -1]] - points[[1, -2]]
    before, start, end, after = (np.vstack([ends[:1], points, ends[1:]])[k : len(points) - 1 + k] for k in range(4))
    t = np.linspace(0, 1, PIECES, endpoint=False)[:, None, None]
    bend = (2 * before - 5 * start + 4 * end - after) + t * (3 * (start - end) + after - before)
    pieces = start + t / 2 * (end - before + t * bend)
    return np.vstack([pieces.transpose(1, 0, 2).reshape(-1, 2), points[-1:]])


def landmark_sketch(points, size, kind):
    """The Sketch of 68 landmarks (68, 2).

    kind: of KINDS: "polylines" has them as the points of its strokes, "curves" between every two of them eight points,
    the others are smooth, their points as dense everywhere; "nameless" strokes say not what they draw, and every second
    one goes backwards.
    """
    line = {"polylines": np.asarray, "curves": curved_line}.get(kind, smooth_line)
    strokes = [
        Stroke(
            line(points[list(ids)]),
            StrokeKind.SILHOUETTE if name == "silhouette" else StrokeKind.FEATURE,
            name,
        )
        for name, ids in LINES.items()
    ]
    if kind == "nameless":
        strokes = [
            replace(stroke.moved(stroke.points[:: -1 if k % 2 else 1]), kind=StrokeKind.UNKNOWN, curve=None)
            for k, stroke in enumerate(strokes)
        ]
    return Sketch(tuple(strokes), size)


def edge_sketch(image):
    """The dark lines of a picture: a difference of Gaussians (2 and 3.2 of 512 pixels), thinned, the longest ones."""
    height, width = image.shape[:2]
    zoom = SIDE / max(height, width)
    gray = resize(rgb2gray(image), (round(height * zoom), round(width * zoom)), anti_aliasing=True)
    lines = trace_lines(gaussian(gray, 3.2) - gaussian(gray, 2.0) > 0.015, 0.03 * SIDE)[:100]
    return Sketch(tuple(Stroke((line.points + 0.5) / zoom - 0.5) for line in lines), (width, height))


def nme(landmarks, points):
    """Mean distance in percent of the diagonal of the points (68, 2)."""
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    return 100 * float(np.linalg.norm(landmarks[:68] - points, axis=1).mean() / diagonal)


def rightly_named(sketch, named):
    """Share of the strokes of LINES that are named rightly, and in one."""
    told = {stroke.points.tobytes(): stroke.curve for stroke in named.strokes}
    drawn = zip(LINES, sketch.strokes, strict=True)
    return float(np.mean([told.get(stroke.points.tobytes()) == curve for curve, stroke in drawn]))


def reconstruction_of(options):
    """The SketchReconstruction that was asked for."""
    model = load_model(options.model, DEFAULT_LATENT)
    encoder = elastic_encoder(model)
    read = partial(read_strokes, network=load_strokes())
    if options.coarse == "network":
        from caricli.methods.sketch.see_sketch import see_sketch
        from caricli.store.sketch_networks import load_sketch_pair

        network, basis = load_sketch_pair(options.network)
        see = partial(see_sketch, network=network, basis=basis)
        return SketchReconstruction.of(encoder, see, read)
    return SketchReconstruction.of(encoder, read=read)


def main():
    """Reconstruct all drawings of the folder and write what came of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of N.jpg and N.txt")
    parser.add_argument("--out", type=Path, required=True, help="JSON of the errors")
    parser.add_argument("--sheets", type=Path, help="a folder for a picture of every face")
    parser.add_argument("--coarse", choices=["network", "model"], default="network")
    parser.add_argument("--network", type=Path)
    parser.add_argument("--model", type=Path)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    options = parser.parse_args()
    reconstruction = reconstruction_of(options)
    rows = {}
    for path in sorted(options.data.glob("*.txt")):
        image = read_image(path.with_suffix(".jpg"))
        points = read_landmarks(path).points
        size = (image.shape[1], image.shape[0])
        rows[path.stem] = {}
        for kind in options.kinds:
            sketch = edge_sketch(image) if kind == "edges" else landmark_sketch(points, size, kind)
            try:
                fits = {share: reconstruction.reconstruct(sketch, share) for share in (0.0, 1.0)}
            except InputError as error:
                print(path.stem, kind, "refused:", error, flush=True)
                continue
            rows[path.stem][kind] = {
                "nme": nme(fits[0.0].face.landmarks, points),
                "nme_followed": nme(fits[1.0].face.landmarks, points),
                "line_error": fits[1.0].errors["all"],
                "flipped": fits[1.0].flipped,
                "unsure": fits[1.0].unsure,
            }
            if kind != "edges":
                rows[path.stem][kind]["rightly_named"] = rightly_named(sketch, fits[1.0].sketch)
            print(path.stem, kind, rows[path.stem][kind], flush=True)
            if options.sheets:
                options.sheets.mkdir(exist_ok=True)
                fit = fits[1.0]
                head = whole_head(fit.face, reconstruction.model.template)
                sheet = sketch_sheet(fit.face, head, fit.sketch, fit.curves, image)
                write_png(options.sheets / f"{path.stem}-{kind}.png", sheet)
    means = {kind: mean_figures([row[kind] for row in rows.values() if kind in row]) for kind in options.kinds}
    options.out.write_text(json.dumps({"coarse": options.coarse, "means": means, "drawings": rows}, indent=1) + "\n")
    print(json.dumps(means, indent=1))


def mean_figures(rows):
    """Means of the figures of drawings, and how many they are."""
    return {"drawings": len(rows)} | {
        key: float(np.mean([row[key] for row in rows])) for key in (rows[0] if rows else ())
    }


if __name__ == "__main__":
    main()
