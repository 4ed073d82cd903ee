"""Teeth, tongue and lashes in faces: are they where they belong, and do they stay behind the skin?

Usage: python benchmarks/parts.py [FACE.npz ...] [--json OUT.json] [--workers N]. Attached parts are compared with where
the identity targets of the open head put them, on 100 generated people and on 100 caricatures of others. A caricature
is exaggerated by curvature, which says nothing of what is not skin; the truth is the person's own parts, carried by the
deformation that the skin makes of the space inside: the smoothest field (biharmonic, affine part apart) that moves the
skin of the person to the caricature's. Then parts are moved with all 52 expressions at weights 1/4 to 1 (mouthClose on
top of jawOpen, as it is meant) on 50 generated faces of the highest level of exaggeration, each with an expression of
its own, and on the faces that are given; how deep a vertex of a part lies in the flesh is told by the winding number.
tongueOut is drawn from the front, and what is seen of the tongue counted. All people are of the seed of the published
test set, on whom nothing was chosen. Shares are of the head's height. The last line is JSON.
"""

import json
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import igl
import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import KDTree
from tested_people import tested_seed
from threadpoolctl import threadpool_limits

from caricli.data.build_settings import EXPONENTS, BuildSettings
from caricli.data.mesh_source import MeshSource
from caricli.geometry.alignment.axis_similarity import axis_similarity
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.repair.components import mesh_components
from caricli.io.face import read_face
from caricli.methods.parts.attachment import open_head_attachment
from caricli.methods.parts.bones import UNEVEN
from caricli.methods.parts.lids import Lids
from caricli.methods.rig.head_expressions import open_head_expressions
from caricli.methods.rig.transfer_rig import transfer_rig
from caricli.render.visibility.rasterise import rasterise
from caricli.structures.arkit import alone, uses
from caricli.template.annotation import DELICATE
from caricli.template.head import load_head
from caricli.template.lash_hairs import SIDES, lash_hairs

PEOPLE, CARICATURES, FACES, RUNS = 100, 100, 50, 7
WEIGHTS = (0.25, 0.5, 0.75, 1.0)
PIXELS = 2000  # of a picture of the height of the head
EVERY = 3  # vertices of the skin that tell the field inside a caricature
NEAREST = 8
"""Vertices of a part that tell how making room moves a point of the base mesh."""
DEEP = 0.003


def main():
    """Print the tables and the JSON line."""
    arguments = sys.argv[1:]
    out = None
    if "--json" in arguments:
        at = arguments.index("--json")
        out = arguments[at + 1]
        del arguments[at : at + 2]
    workers = 1
    if "--workers" in arguments:
        at = arguments.index("--workers")
        workers = int(arguments[at + 1])
        del arguments[at : at + 2]
    figures = {"attachment": placed(), "milliseconds": timed(), "depth": {}}
    print(json.dumps(figures, indent=1), flush=True)
    sets = {f"{FACES} generated faces": generated()} | {
        f"{len(arguments)} given faces": [read_face(Path(name)).vertices.astype(float) for name in arguments]
    }
    with ProcessPoolExecutor(workers) as pool:
        for name, faces in sets.items():
            figures["depth"][name] = summary([*pool.map(depths, faces)])
            print(name, json.dumps(figures["depth"][name], indent=1), flush=True)
    if out:
        Path(out).write_text(json.dumps(figures, indent=1) + "\n")
    print(json.dumps(figures))


def placed():
    """Mean distances from the truth by part and set, mean and largest over heads, percent of the height."""
    source = MeshSource(BuildSettings(seed=tested_seed()))
    errors = {"people": [], "caricatures": []}
    for kind, numbers in (("people", range(PEOPLE)), ("caricatures", range(PEOPLE, PEOPLE + CARICATURES))):
        for number in numbers:
            skin, truth = person(source, number)
            if kind == "caricatures":
                skin, truth = exaggerated(skin, truth, EXPONENTS[1 + number % (len(EXPONENTS) - 1)])
            errors[kind].append(distances(skin, truth))
    return {name: {kind: mean_and_largest(rows, name) for kind, rows in errors.items()} for name in errors["people"][0]}


def mean_and_largest(rows, name):
    """Of the values of a name."""
    values = [row[name] for row in rows]
    return {"mean": float(np.mean(values)), "largest": float(max(values))}


def person(source, number):
    """The skin of a person of a MeshSource and, by name, the parts of the base mesh."""
    head = source.head
    identity = vars(source.person(number).identity)
    return head.evaluate(**identity), {name: part.evaluate(**identity) for name, part in head.parts.items()}


def exaggerated(skin, truth, exponent):
    """A caricature of a person, and its parts."""
    template = load_head().template()
    hold = template.mask(*DELICATE).astype(float)
    caricature = exaggerate_curvature(skin, template.faces, [exponent], hold)[0]
    field = RBFInterpolator(skin[::EVERY], (caricature - skin)[::EVERY], kernel="linear", degree=1)
    return caricature, {name: points + field(points) for name, points in truth.items()}


def distances(skin, truth):
    """Percent of the height, by part: what the base mesh's own vertices miss, before and after parts make room for the
    wall of the mouth, through which true ones go; of lashes what their roots miss."""
    head = load_head()
    attachment = open_head_attachment()
    height = np.ptp(skin[:, 1])
    stands = {part.name: part.mesh.vertices for part in attachment.attach(head.template().with_vertices(skin))}
    missed = {}
    for hold in attachment.holds:
        name = hold.part.name
        if isinstance(hold, Lids):
            strips = head.parts["lashes"]
            hairs = lash_hairs(strips.mesh())
            aims = hairs.mesh.vertices + hairs.weights @ (truth[name] - strips.evaluate())
            roots = rooted(hairs.mesh)
            missed["lashes' roots"] = centres(stands[name] - aims, roots)
        else:
            scales, rotation, shift = axis_similarity(hold.frames.points, hold.weights @ skin[hold.around], UNEVEN)
            points = hold.frames.points * scales @ rotation.T + shift
            missed[name] = np.linalg.norm(points - truth[name], axis=1).mean()
            moved = stands[name] - (hold.shape * scales @ rotation.T + shift)
            near = KDTree(hold.shape).query(hold.frames.points, k=NEAREST)[1]
            missed[f"{name} with room"] = np.linalg.norm(points + moved[near].mean(1) - truth[name], axis=1).mean()
    return {name: 100 * float(value / height) for name, value in missed.items()}


def rooted(mesh):
    """(L, SIDES) the ring of every lash that is in the lid."""
    labels = mesh_components(mesh.vertices, mesh.faces).labels
    return np.array([np.flatnonzero(labels == k)[:SIDES] for k in range(labels.max() + 1)])


def centres(errors, rings):
    """Mean length of the errors (W, 3) of rings' centres."""
    return np.linalg.norm(errors[rings].mean(1), axis=1).mean()


@threadpool_limits.wrap(limits=1)
def timed():
    """Milliseconds of processor time, on one thread: attaching parts to generated faces, and with 52 expressions."""
    templates = open_head_expressions()
    attachment = open_head_attachment()
    names = templates.names
    milliseconds = {"attach": [], "with 52 expressions": []}
    for number, face in enumerate(generated()):
        mesh = templates.mesh.with_vertices(face)
        # The second time is what a face takes once everything is loaded.
        milliseconds["attach"].append([processor_time(lambda mesh=mesh: attachment.attach(mesh)) for _ in range(2)][1])
        if number < RUNS:
            deltas = transfer_rig(templates, face)
            way = processor_time(lambda mesh=mesh, deltas=deltas: attachment.animate(mesh, alone(names), deltas))
            milliseconds["with 52 expressions"].append(way)
    return {name: {"median": statistics.median(rows), "largest": max(rows)} for name, rows in milliseconds.items()}


def processor_time(function):
    """Milliseconds that it takes the processor."""
    start = time.process_time()
    function()
    return 1000 * (time.process_time() - start)


def generated():
    """Faces of the highest level, each another person with another expression."""
    source = MeshSource(BuildSettings(identities=FACES, seed=tested_seed()))
    count = len(source.actions)
    return [np.asarray(source.levels(k, k % count)[-1].columns["vertices"], float) for k in range(FACES)]


def depths(face):
    """Percent of the height that parts are in the flesh, by part and expression, at the worst weight, and the tongue.

    Of this: the percent of the height squared that is seen of it from the front when it is out.
    """
    templates = open_head_expressions()
    attachment = open_head_attachment()
    mesh = templates.mesh.with_vertices(face)
    names = templates.names
    deltas = attachment.let_out(mesh, alone(names), transfer_rig(templates, face))
    parts = attachment.animate(mesh, alone(names), deltas)
    flesh = Flesh(mesh.faces)
    reach = [Reach(mesh, flesh, part) for part in parts]
    by_part = {part.name: {"rest": 100 * float(flesh.depth(face, part.mesh.vertices).max())} for part in parts}
    for name, amounts in zip(names, uses(names), strict=True):
        skin = np.tensordot(amounts, deltas, 1)
        own = [np.tensordot(amounts, part.deltas, 1) for part in parts]
        near = [one.asked(skin, way) for one, way in zip(reach, own, strict=True)]
        starts = np.concatenate([part.mesh.vertices[ids] for part, ids in zip(parts, near, strict=True)])
        ways = np.concatenate([way[ids] for way, ids in zip(own, near, strict=True)])
        ends = np.cumsum([len(ids) for ids in near])[:-1]
        depth = np.max([flesh.depth(face + a * skin, starts + a * ways) for a in WEIGHTS], axis=0)
        for part, rows in zip(parts, np.split(depth, ends), strict=True):
            by_part[part.name][name] = 100 * float(rows.max(initial=0.0))
    by_part = {name: {key: value / mesh.height for key, value in rows.items()} for name, rows in by_part.items()}
    k = names.index("tongueOut")
    return by_part | {"seen": seen(mesh.with_vertices(face + deltas[k]), parts, k)}


def seen(mesh, parts, k):
    """Percent of the height squared that a picture from the front shows of the tongue, in expression k."""
    meshes = [mesh, *(part.mesh.with_vertices(part.mesh.vertices + part.deltas[k]) for part in parts)]
    starts = np.cumsum([0, *(len(one.vertices) for one in meshes)])
    points = np.concatenate([one.vertices for one in meshes])
    faces = np.concatenate([one.faces + start for one, start in zip(meshes, starts, strict=False)])
    scale = PIXELS / mesh.height
    places = scale * (points - points.min(0)) * [1, -1, -1] + [0, PIXELS, 0]
    shown = rasterise(places, faces, PIXELS, PIXELS).face
    tongue = 1 + next(i for i, part in enumerate(parts) if part.name == "tongue")
    first = sum(len(one.faces) for one in meshes[:tongue])
    return float(100 * ((shown >= first) & (shown < first + len(meshes[tongue].faces))).mean())


class Reach:
    """Which points of a part skin can come over: those outside that it cannot reach on its way need no looking at."""

    def __init__(self, mesh, flesh, part):
        points = part.mesh.vertices
        edges = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, axis=1)]
        self.edge = np.linalg.norm(edges, axis=-1).max()
        self.to_part = KDTree(points).query(mesh.vertices)[0]
        free = np.sqrt(igl.point_mesh_squared_distance(points, mesh.vertices, flesh.faces)[0])
        self.free = np.where(flesh.depth(mesh.vertices, points) > 0, 0.0, free)

    def asked(self, skin, own):
        """Ids of points that move as (W, 3) where the skin does as (V, 3), on straight ways."""
        moved, ways = (np.linalg.norm(move, axis=1) for move in (skin, own))
        # A triangle that comes to the part has a corner that is not farther than this.
        close = self.to_part <= ways.max() + moved.max() + self.edge
        return np.flatnonzero(self.free <= ways + moved[close].max(initial=0.0))


class Flesh:
    """What the skin encloses, closed at the neck."""

    def __init__(self, faces):
        edges = igl.boundary_facets(faces)[0]
        self.rim = np.unique(edges)
        self.faces = np.asarray(faces, np.int64)
        fan = np.column_stack([edges[:, ::-1], np.full(len(edges), faces.max() + 1)])
        self.closed = np.concatenate([self.faces, fan])

    def depth(self, vertices, points):
        """(N,) metres that points (N, 3) are in it."""
        closed = np.concatenate([vertices, vertices[self.rim].mean(0, keepdims=True)])
        inside = igl.fast_winding_number(closed, self.closed, points) > 0.5
        depth = np.zeros(len(points))
        if inside.any():
            depth[inside] = np.sqrt(igl.point_mesh_squared_distance(points[inside], vertices, self.faces)[0])
        return depth


def summary(faces):
    """By part: the deepest of all, by expression where it is deep, and how many faces have none deeper.

    And how much of the tongue is seen when it is out: of the face that shows the least, and the median.
    """
    if not faces:
        return {}
    shown = [face["seen"] for face in faces]
    result = {"tongue seen": {"least": round(min(shown), 3), "median": round(statistics.median(shown), 3)}}
    for part in faces[0].keys() - {"seen"}:
        worst = {}
        for face in faces:
            for name, value in face[part].items():
                worst[name] = max(worst.get(name, 0.0), value)
        deep = {name: round(value, 3) for name, value in sorted(worst.items()) if value > 100 * DEEP}
        sound = sum(max(face[part].values()) <= 100 * DEEP for face in faces)
        result[part] = {
            "deepest": round(max(worst.values()), 3),
            "beyond 0.3 %": deep,
            "faces within": f"{sound} of {len(faces)}",
        }
    return dict(sorted(result.items()))


if __name__ == "__main__":
    main()
