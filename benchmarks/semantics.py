"""Semantic directions and caricatures, measured on faces of people that no model has seen.

Usage: python benchmarks/semantics.py DATASET [MODEL [DIRECTIONS]]. DATASET is made by `caricli dataset build`
(testset/draws: configs/testset.yaml); MODEL is a bundled kind or a file (default: kernel). Everybody counts but whom
model and directions were trained with. The last line is JSON.

Labels: cross-validated AUC; the share of 100 test faces on which -2, 0 and +2 standard deviations measure in rising
order; and how much of the change of the attribute that changes most beside the label is left with --keep. Caricatures:
100 regular faces of these people, drawn again without what was exaggerated; whether the measured exaggeration rises
over the strengths 0 to 2, and whether the caricature is nearest to the neutral face of its own person among all.
"""

import json
import sys
from pathlib import Path

import numpy as np

from caricli.data.attributes import measure_attributes
from caricli.data.dataset import read_dataset
from caricli.data.regular_face import regular_faces
from caricli.data.unseen import unseen_data
from caricli.errors import InputError
from caricli.methods.edit.caricaturize_face import LABEL, caricaturize_face, exaggeration
from caricli.methods.edit.edit_semantic import SemanticEdit, edit_semantic, label_direction
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.nearest_identity import nearest_identity
from caricli.store.directions import load_directions
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.structures import Face

FACES = 100
FAR = 2.0
"""Standard deviations that faces are edited by."""
STRENGTHS = (0.0, 0.5, 1.0, 1.5, 2.0)
ALIKE = 0.7
"""Cosine of two labels from which on they say the same: then one cannot sensibly be kept while the other changes."""


class Attributes:
    """What can be measured on faces of a model, before and after edits."""

    def __init__(self, data, model, directions):
        """data: Dataset. model: ShapeModel. directions: Directions of the model."""
        self.model = model
        self.directions = directions
        measurable = measure_attributes(model.template.vertices, model.template)
        self.names = [name for name in data.attributes if name in measurable]
        columns = [data.attributes.index(name) for name in self.names]
        self.spread = data.measures.std(0)[columns]
        self.faces = [encoded(data.vertices[row], model) for row in spread_rows(data.rows("test"), FACES)]
        self.start = self.table(self.faces)

    def table(self, faces):
        """(N, A) measures of faces."""
        rows = (measure_attributes(face.vertices, self.model.template) for face in faces)
        return np.array([[row[name] for name in self.names] for row in rows])

    def moved(self, name, strength, keep=()):
        """(N, A) measures of the faces after an edit by one label."""
        edit = SemanticEdit(self.directions, {name: strength}, keep)
        return self.table([edit_semantic(face, self.model, edit) for face in self.faces])

    def rising(self, name):
        """Share of faces on which a label measures in rising order from -FAR to FAR, and what --keep does to it."""
        low = self.moved(name, -FAR)
        high = self.moved(name, FAR)
        own = self.names.index(name)
        ordered = ((low < self.start) & (self.start < high))[:, own]
        return {"rising": float(ordered.mean())} | self.keeping(name, (high - self.start) / self.spread)

    def keeping(self, name, change):
        """How the attribute that changes most beside a label changes, without and with --keep.

        change: (N, A) without, in standard deviations.
        """
        own = self.names.index(name)
        for other in np.argsort(-np.abs(change).mean(0)):
            kept = self.names[other]
            if not self.can_be_kept(name, kept):
                continue
            after = (self.moved(name, FAR, [kept]) - self.start) / self.spread
            return {
                "keep": kept,
                "beside": float(np.abs(change[:, other]).mean()),
                "kept": float(np.abs(after[:, other]).mean()),
                "label_left": float(np.abs(after[:, own]).mean() / np.abs(change[:, own]).mean()),
            }
        return {}

    def can_be_kept(self, name, kept):
        """Whether a label can change while another is kept, and is not its opposite or its other name."""
        if kept == name or kept not in self.directions.names:
            return False
        try:
            label_direction(self.directions, name, [kept])
        except InputError:
            return False
        rows = [self.directions.normals[self.directions.names.index(label)] for label in (name, kept)]
        return abs(float(rows[0] @ rows[1])) <= ALIKE


def labels(data, model, directions):
    """Yield a row for every label."""
    attributes = Attributes(data, model, directions)
    for k, name in enumerate(directions.names):
        row = {"label": name, "auc": float(directions.auc[k]), "positives": int(directions.positives[k])}
        yield row | (attributes.rising(name) if name in attributes.names else {})


def caricatures(data, model, directions):
    """Yield a row for every mode."""

    def regular(row, expression=None):
        return data.template.cavities.tuck(regular_faces(data, [row], expression)[0])

    test = np.flatnonzero(data.rows("test"))
    people, first = np.unique(data.identity[test], return_index=True)
    # Expression 0 of the table is the neutral one.
    neutrals = np.array([whitened(encoded(regular(row, 0), model), model) for row in test[first]])
    rows = spread_rows(data.rows("test"), FACES)
    faces = [encoded(regular(row), model) for row in rows]
    owners = np.searchsorted(people, data.identity[rows])
    for mode in ("direction", "own"):
        degrees = [[caricaturize_face(face, model, s, mode, directions) for s in STRENGTHS] for face in faces]
        measured = [[exaggeration(each, model, directions) for each in series] for series in degrees]
        caricature = np.array([[each.caricature for each in row] for row in measured])
        distance = np.array([[each.distance for each in row] for row in measured])
        latents = np.array([[whitened(each, model) for each in series] for series in degrees])
        own = [float((nearest_identity(latents[:, k], neutrals) == owners).mean()) for k in range(len(STRENGTHS))]
        yield {
            "mode": mode,
            "strengths": STRENGTHS,
            "caricature": caricature.mean(0).tolist(),
            "caricature_rising": float((np.diff(caricature) > 0).all(1).mean()),
            "distance": distance.mean(0).tolist(),
            "distance_rising": float((np.diff(distance) > 0).all(1).mean()),
            "prior_rms": np.sqrt((latents**2).mean(-1)).mean(0).tolist(),
            "own_identity": own,
            "people": len(people),
        }


def encoded(vertices, model):
    """The EncodedFace of vertices (V, 3)."""
    return encode_face(Face(model.template.with_vertices(vertices)), model)


def whitened(face, model):
    """(D,) latent of an EncodedFace in standard deviations, found again from its mesh."""
    return model.prior.whiten(model.encode(face.vertices))


def main():
    """Print the tables and the JSON line."""
    if not 2 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    data = read_dataset(Path(sys.argv[1]))
    kind = sys.argv[2] if len(sys.argv) > 2 else DEFAULT_LATENT
    model = load_model(Path(kind)) if Path(kind).is_file() else load_model(kind=kind)
    directions = load_directions(model, Path(sys.argv[3]) if len(sys.argv) > 3 else None)
    unseen = unseen_data(data, {"model": model.seen, "directions": directions.seen}, everyone=True)
    data = unseen.data
    print(f"{unseen.test} of {unseen.of} people")
    rows, modes = [], []
    print(f"{'label':16}{'AUC':>7}{'rising':>8}   change of another by +{FAR:g}: without and with --keep")
    for row in labels(data, model, directions):
        beside = f"{row['keep']:16}{row['beside']:6.2f}{row['kept']:6.2f}" if "keep" in row else ""
        print(f"{row['label']:16}{row['auc']:7.3f}{row.get('rising', np.nan):8.2f}   {beside}", flush=True)
        rows.append(row)
    if LABEL in directions.names:
        for mode in caricatures(data, model, directions):
            for key in ("caricature", "distance", "prior_rms", "own_identity"):
                print(f"{mode['mode']:10}{key:14}", *(f"{value:7.3f}" for value in mode[key]))
            rising = mode["caricature_rising"], mode["distance_rising"]
            print(f"{mode['mode']:10}rising on a share of {rising[0]:.2f} (caricature), {rising[1]:.2f} (distance)")
            modes.append(mode)
    print(json.dumps({"model": model.kind, "labels": rows, "caricatures": modes}))


if __name__ == "__main__":
    main()
