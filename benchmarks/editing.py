"""Handle edits of the deformable paper's figure 11: how far handles go, where the movement is, flips and time.

Usage: python benchmarks/editing.py [FOLDER [KIND]]. FOLDER holds landmark files (default: $CARICLI_REAL_DATA, else the
astronaut); their faces are reconstructed first. KIND is a bundled model (default: that of latents). Handles move by 5 %
of the head's height. The last line is JSON. The paper (section 5.5) needs about 20 ms an edit on a Titan Xp.
"""

import json
import statistics
import sys
import time

import numpy as np
from landmarks import ASTRONAUT, landmark_files
from scipy.spatial import cKDTree

from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.self_intersections import self_intersections
from caricli.io.landmarks import read_landmarks
from caricli.methods.edit.edit_handles import edit_handles
from caricli.methods.edit.handle_points import handle_points
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.store.models import DEFAULT_LATENT, load_model

REPEATS = 5
NEIGHBOURHOOD = 0.1  # of the head's height around a part
EDITS = {
    "nose forward": (["nose"], [("nose_tip", [0, 0, "5%"])]),
    "chin down": (["chin"], [("chin", [0, "-5%", 0])]),
    "cheekbones": (
        ["cheek_left", "cheek_right"],
        [("cheekbone_left", ["5%", 0, 0]), ("cheekbone_right", ["-5%", 0, 0])],
    ),
    "ears": (["ear_left", "ear_right"], [("ear_left", ["5%", 0, 0]), ("ear_right", ["-5%", 0, 0])]),
}


def edited(faces, model):
    """Yield one row for each edit, over all faces."""
    template = model.template
    codes = [encode_face(vertices, model) for vertices in faces]
    for name, (parts, asked) in EDITS.items():
        handles, displacements, _ = handle_points(asked, [], template)
        part = np.concatenate([template.region(region) for region in parts])
        distance, _ = cKDTree(template.vertices[part]).query(template.vertices)
        outside = distance > NEIGHBOURHOOD * template.height
        rows, seconds = [], []
        for code in codes:
            for _ in range(1 + REPEATS):
                start = time.perf_counter()
                edit = edit_handles(code, model, handles, displacements)
                seconds.append(time.perf_counter() - start)
            del seconds[-1 - REPEATS]  # the warm-up
            before, after = code.vertices, edit.face.vertices
            energy = ((after - before) ** 2).sum(1)
            fresh = flipped_triangles(after, template.gradients) & ~flipped_triangles(before, template.gradients)
            known = set(map(tuple, self_intersections(before, template.faces).tolist()))
            crossing = set(map(tuple, self_intersections(after, template.faces).tolist())) - known
            reached = (edit.achieved * displacements).sum(1) / (displacements**2).sum(1)
            rows.append((reached.min(), energy[outside].sum() / energy.sum(), fresh.sum(), len(crossing)))
        reached, outside_share, fresh, crossing = np.array(rows).T
        yield {
            "edit": name,
            "reached": float(reached.min()),
            "outside": float(outside_share.max()),
            "new_flips": int(fresh.sum()),
            "new_crossing_pairs": crossing.astype(int).tolist(),
            "median_seconds": statistics.median(seconds),
        }


def main():
    """Print the table and the JSON line."""
    # The astronaut always; a dictionary keeps each file once.
    files = list(dict.fromkeys([ASTRONAUT.resolve() / "landmarks.json", *landmark_files()]))
    kind = sys.argv[2] if len(sys.argv) > 2 else DEFAULT_LATENT
    intrinsic, model = load_model(kind="intrinsic"), load_model(kind=kind)
    faces = [fit_landmarks(read_landmarks(path).points, intrinsic, "intrinsic").vertices for path in files]
    rows = list(edited(faces, model))
    print(f"{len(faces)} faces, {model.kind} model, percent; reached: the least; outside: the largest share of energy")
    print(f"{'edit':14} {'reached':>8} {'outside':>8} {'new flips':>9} {'median s':>8}  new crossing pairs of a face")
    for r in rows:
        print(
            f"{r['edit']:14} {100 * r['reached']:8.1f} {100 * r['outside']:8.1f} {r['new_flips']:9} "
            f"{r['median_seconds']:8.2f}  {r['new_crossing_pairs']}"
        )
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
