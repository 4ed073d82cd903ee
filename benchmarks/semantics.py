"""Semantic directions and caricatures, measured on faces of people that no model has seen.

Usage: python benchmarks/semantics.py DATASET [MODEL [DIRECTIONS]]. DATASET is the one of pipelines/bundled_models, made
by `caricli dataset build`; MODEL is a bundled kind or a file (default: kernel). The last line is JSON.

Labels: cross-validated AUC; the share of 100 test faces on which -2, 0 and +2 standard deviations measure in rising
order; and how much of the change of the attribute that changes most beside the label is left with --keep. Caricatures:
100 regular faces of test people, drawn again without what was exaggerated; whether the measured exaggeration rises over
the strengths 0 to 2, and whether the caricature is nearest to the neutral face of its own person among all test people.
"""

import json
import sys
from pathlib import Path

import numpy as np

from caricli.data.attributes import measure_attributes
from caricli.data.dataset import read_dataset
from caricli.data.expressions import expand_sides
from caricli.errors import InputError
from caricli.geometry.similarity import similarity
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.methods.edit.caricaturize_face import LABEL, caricaturize_face, exaggeration
from caricli.methods.edit.edit_semantic import edit_semantic, label_direction
from caricli.methods.evaluate.evaluate_shape import spread_rows
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.faces.nearest_identity import nearest_identity
from caricli.store.directions import directions_path, load_directions
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.template.head import load_head

FACES, FAR = 100, 2.0
STRENGTHS = (0.0, 0.5, 1.0, 1.5, 2.0)


def labels(data, model, directions):
    """Yield a row for every label."""
    faces = [encode_face(data.vertices[row], model) for row in spread_rows(data.rows("test"), FACES)]
    known = measure_attributes(model.template.vertices, model.template)
    measured = [k for k, name in enumerate(data.attributes) if name in known]
    spread = data.measures[data.rows("train")].std(0)[measured]
    names = [data.attributes[k] for k in measured]
    start = table(faces, names, model.template)
    for k, name in enumerate(directions.names):
        row = {"label": name, "auc": float(directions.auc[k]), "positives": int(directions.positives[k])}
        if name in names:
            low, high = (moved(faces, model, directions, name, names, strength) for strength in (-FAR, FAR))
            own = names.index(name)
            row["rising"] = float(((low < start) & (start < high))[:, own].mean())
            row |= keeping(faces, model, directions, name, names, (high - start) / spread, start, spread)
        yield row


def keeping(faces, model, directions, name, names, change, start, spread):
    """How the attribute that changes most beside a label changes, without and with --keep, in standard deviations."""
    for other in np.argsort(-np.abs(change).mean(0)):
        kept = names[other]
        if kept == name or kept not in directions.names:
            continue
        try:
            label_direction(directions, name, [kept])
        except InputError:
            continue
        # An opposite, or the same thing under another name, cannot sensibly be kept.
        if abs(cosine(directions, name, kept)) > 0.7:
            continue
        after = (moved(faces, model, directions, name, names, FAR, [kept]) - start) / spread
        sizes = np.abs(change[:, other]).mean(), np.abs(after[:, other]).mean()
        left = np.abs(after[:, names.index(name)]).mean() / np.abs(change[:, names.index(name)]).mean()
        return {"keep": kept, "beside": float(sizes[0]), "kept": float(sizes[1]), "label_left": float(left)}
    return {}


def cosine(directions, first, second):
    """Between the normals of two labels."""
    rows = [directions.normals[directions.names.index(name)] for name in (first, second)]
    return float(rows[0] @ rows[1])


def table(faces, names, template):
    """(N, A) measures of faces."""
    rows = (measure_attributes(face.vertices, template) for face in faces)
    return np.array([[row[name] for name in names] for row in rows])


def moved(faces, model, directions, name, names, strength, keep=()):
    """The same of faces that were edited."""
    edited = [edit_semantic(face, model, directions, {name: strength}, keep) for face in faces]
    return table(edited, names, model.template)


def caricatures(data, model, directions):
    """Yield a row for every mode."""
    head, template = load_head(), data.template
    actions = list(read_yaml(asset_path("expressions.yaml")).values())
    place, changes = template.region("face"), data.manifest["changes"]

    def regular(row, expression):
        known = {name: float(data.factors[name][row]) for name in ("gender", "age", "weight")}
        known["changes"] = dict(zip(changes, data.factors["changes"][row].astype(float).tolist(), strict=True))
        neutral = head.evaluate(**known)
        acting = head.evaluate(**known, actions=expand_sides(actions[expression], head.action_names))
        scale, rotation, translation = similarity(neutral[place], template.vertices[place])
        return template.cavities.tuck(scale * acting @ rotation.T + translation)

    test = np.flatnonzero(data.rows("test"))
    people, first = np.unique(data.identity[test], return_index=True)
    # Expression 0 of the table is the neutral one.
    neutrals = np.array([whitened(encode_face(regular(row, 0), model), model) for row in test[first]])
    rows = spread_rows(data.rows("test"), FACES)
    faces = [encode_face(regular(row, data.expression[row]), model) for row in rows]
    owners = np.searchsorted(people, data.identity[rows])
    for mode in ("direction", "own"):
        degrees = [[caricaturize_face(face, model, s, mode, directions) for s in STRENGTHS] for face in faces]
        found = [[exaggeration(each, model, directions) for each in series] for series in degrees]
        caricature, distance = (np.array([[getattr(e, key) for e in row] for row in found]) for key in
                                ("caricature", "distance"))  # fmt: skip
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
    directions = load_directions(directions_path(Path(sys.argv[3]) if len(sys.argv) > 3 else None, model), model)
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
