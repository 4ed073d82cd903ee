"""Handle edits of the deformable paper's figure 11: how far handles go, where the movement is, flips and time.

Usage: python benchmarks/editing.py [FOLDER [KIND]]. FOLDER holds landmark files (default: $CARICLI_REAL_DATA, else the
astronaut); their faces are reconstructed first. KIND is a bundled model (default: that of latents). Handles move by 5 %
of the face's height. The last line is JSON. The paper (section 5.5) needs about 20 ms an edit on a Titan Xp.
"""

import json
import statistics
import sys
import time

import numpy as np
from landmarks import ASTRONAUT, landmark_files
from scipy.spatial import KDTree

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.self_intersections import self_intersections
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
    codes = [encode_face(face.without_latent(), model) for face in faces]
    for name, (parts, asked) in EDITS.items():
        part = np.concatenate([template.region(region) for region in parts])
        distance, _ = KDTree(template.vertices[part]).query(template.vertices)
        outside = distance > NEIGHBOURHOOD * template.height
        rows = []
        seconds = []
        for code in codes:
            handles = handle_points(asked, [], template.with_vertices(code.vertices))
            edit, times = timed(code, model, handles)
            seconds += times
            rows.append(figures(code, edit, template.gradients, outside))
        reached, outside_share, fresh, crossing = np.array(rows).T
        yield {
            "edit": name,
            "reached": float(reached.min()),
            "outside": float(outside_share.max()),
            "new_flips": int(fresh.sum()),
            "new_crossing_pairs": crossing.astype(int).tolist(),
            "median_seconds": statistics.median(seconds),
        }


def timed(code, model, handles):
    """The edit, and the seconds that every repeat took after a warm-up."""
    seconds = []
    for _ in range(1 + REPEATS):
        start = time.perf_counter()
        edit = edit_handles(code, model, handles)
        seconds.append(time.perf_counter() - start)
    return edit, seconds[1:]


def figures(before, edit, gradients, outside):
    """Least share that was reached, energy outside (V,) bool, new flips, and new crossing pairs of triangles."""
    after = edit.face
    energy = ((after.vertices - before.vertices) ** 2).sum(1)
    flipped = [flipped_triangles(face.vertices, gradients) for face in (before, after)]
    pairs = [set(map(tuple, self_intersections(face.vertices, face.faces).tolist())) for face in (before, after)]
    share = energy[outside].sum() / energy.sum()
    return edit.reached.min(), share, (flipped[1] & ~flipped[0]).sum(), len(pairs[1] - pairs[0])


def main():
    """Print the table and the JSON line."""
    # The astronaut always; a dictionary keeps each file once.
    files = list(dict.fromkeys([ASTRONAUT.resolve() / "landmarks.json", *landmark_files()]))
    kind = sys.argv[2] if len(sys.argv) > 2 else DEFAULT_LATENT
    intrinsic = load_model(kind="intrinsic")
    model = load_model(kind=kind)
    faces = [fit_landmarks(read_landmarks(path).points, intrinsic, "intrinsic").face for path in files]
    rows = list(edited(faces, model))
    print(f"{len(faces)} faces, {model.kind} model, percent; reached: the least; outside: the largest share of energy")
    print(f"{'edit':14} {'reached':>8} {'outside':>8} {'new flips':>9} {'median s':>8}  new crossing pairs of a face")
    for r in rows:
        print(
            f"{r['edit']:14} {100 * r['reached']:8.1f} {100 * r['outside']:8.1f} {r['new_flips']:9} "
            f"{r['median_seconds']:8.2f}  {r['new_crossing_pairs']}"
        )
    print(json.dumps({"editing": rows}))


if __name__ == "__main__":
    main()
