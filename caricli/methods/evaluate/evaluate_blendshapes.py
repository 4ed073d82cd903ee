"""Blendshapes of caricatures whose true expressions are known (expressions paper, section 4.2.1)."""

import time
from dataclasses import dataclass, replace

import numpy as np

from caricli.data.expressions import NEUTRAL, expand_sides
from caricli.errors import InputError
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.head_rotation import TURNS, head_rotation
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.methods.expressions.build_blendshapes import build_blendshapes
from caricli.methods.expressions.measure_blendshapes import measure_blendshapes
from caricli.structures import Camera

RIVALS = {
    "full": ("full", False),
    "initial": ("initial", False),
    "initial, latent": ("initial", True),
    "transfer": ("transfer", False),
}
"""What is compared: methods of ``build_blendshapes``, and whether a latent is fitted to the landmarks."""

_SIZE = 400.0


@dataclass(frozen=True, eq=False)
class KnownCaricature:
    """identity and level of a caricature in a dataset; truth (K, V, 3) metres, with every expression, neutral first."""

    identity: int
    level: int
    truth: np.ndarray


def dataset_expressions(data, action_names):
    """The named expressions of a generated Dataset, neutral first: dict from names to dicts of actions and weights.

    Raises InputError where the names are not those of the bundled table, or the neutral one is missing.
    """
    table, names = read_yaml(asset_path("expressions.yaml")), data.manifest.get("expressions", [])
    if NEUTRAL not in names or not set(names) <= set(table):
        raise InputError("expected a dataset of caricli dataset build, with a neutral expression, found another")
    order = [NEUTRAL, *(name for name in names if name != NEUTRAL)]
    return {name: expand_sides(table[name], action_names) for name in order}


def known_caricatures(data, people):
    """KnownCaricatures of a Dataset: exaggerated people (iterable of ints) of whom every expression is there."""
    names, columns = data.manifest["expressions"], (data.identity, data.level, data.expression)
    rows = {key: row for row, key in enumerate(zip(*(column.tolist() for column in columns), strict=True))}
    order = sorted(range(len(names)), key=lambda k: names[k] != NEUTRAL)
    found = []
    for identity in people:
        for level in sorted(set(data.level[data.identity == identity].tolist()) - {1}):
            keys = [(identity, level, k) for k in order]
            if all(key in rows for key in keys):
                truth = data.vertices[[rows[key] for key in keys]].astype(np.float64)
                found.append(KnownCaricature(int(identity), int(level), truth))
    return found


def random_pose(generator, height):
    """A Camera in which a head of a height in metres is seen, turned a little."""
    rotation = head_rotation(generator.uniform(-1, 1, 3) * TURNS)
    return Camera(_SIZE / height, rotation, np.array([_SIZE, _SIZE]))


def compare_blendshapes(truth, given, pose, templates, morphable, landmark_map, latent):
    """Build the expressions of a known caricature by every method and measure them.

    truth: (K, V, 3) metres. given: number of the expression that the picture shows. pose: Camera. templates:
    ExpressionTemplates of the same expressions. latent: ShapeModel of latents.
    Returns (figures by rival, Blendshapes by rival), both with "truth" first. Figures: error, drift, strength, excess
    (K,), in percent of the head's height, of the normal face's and of its mean displacement, NaN for the given one;
    structure; flipped, percent of triangles, at most; seconds.
    """
    vertices, made, seconds = truth[given], {}, {}
    known = vertices, pose, templates, morphable, landmark_map
    for name, (method, in_latent) in RIVALS.items():
        start = time.perf_counter()
        made[name] = build_blendshapes(*known, method, model=latent if in_latent else None)
        seconds[name] = {"seconds": time.perf_counter() - start}
    made = {"truth": replace(made["transfer"], shapes=truth)} | made
    others, gradients = np.arange(len(truth)) != given, morphable.template.gradients
    figures = {name: _figures(found, truth, vertices, others, gradients) for name, found in made.items()}
    return {name: own | seconds.get(name, {}) for name, own in figures.items()}, made


def _figures(found, truth, vertices, others, gradients):
    """Figures of one rival's Blendshapes."""
    height = np.ptp(vertices[:, 1])
    seen = measure_blendshapes(found.shapes - vertices, found.normal - found.normal_given)
    each = {
        "error": 100 * np.linalg.norm(found.shapes - truth, axis=2).mean(1) / height,
        "drift": 100 * seen.drift / height,
        "strength": seen.strength,
        "excess": 100 * seen.excess,
    }
    flipped = 100 * max(flipped_triangles(shape, gradients).mean() for shape in found.shapes)
    figures = {key: np.where(others, values, np.nan) for key, values in each.items()}
    return figures | {"structure": seen.structure, "flipped": flipped}


def mean_comparison(figures):
    """Means over caricatures of ``compare_blendshapes`` figures (list): by rival, whole and by expression.

    Returns (dict by rival of floats, dict by rival of (K,) mean errors, (K,) on how many caricatures "full" is
    nearest to the truth of all, (K,) how many were compared).
    """
    whole, errors = {}, {name: np.array([f[name]["error"] for f in figures]) for name in RIVALS}
    for name, first in figures[0].items():
        whole[name] = {key: float(np.nanmean([f[name][key] for f in figures])) for key in first}
    best = np.min([errors[name] for name in RIVALS if name != "full"], axis=0)
    nearest, compared = (errors["full"] < best).sum(0), np.isfinite(best).sum(0)
    means = {name: np.where(compared, np.nansum(e, 0) / np.maximum(compared, 1), np.nan) for name, e in errors.items()}
    return whole, means, nearest, compared
