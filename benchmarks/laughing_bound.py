"""How well depth can be told from 68 landmarks at all: the best linear predictors for laughing faces, with truth.

Usage: python benchmarks/laughing_bound.py [SEED [COUNT]]. COUNT people (default: 24) of SEED (default: that of the
published test set) laugh as in laughing.py, seen by the same cameras. Predictors are given what no fit has: the
vertices that landmarks stand on, and the derivatives at the true pose; "known" ones the pose itself, too. "bundled" is
the Gaussian prior of the bundled principal components, "own group" that of 1,000 other people (seed 1303) who laugh and
are exaggerated in just the same way. Landmarks carry normal errors of a share of their diagonal, which the predictor
knows. Errors are those of laughing.py: millimetres of depth after the best similarity of the face. The last line is
JSON.
"""

import json
import sys

import numpy as np
from laughing import REGIONS, Laughter, errors
from tested_people import tested_seed
from threadpoolctl import threadpool_limits

from caricli.methods.reconstruct.camera_rows import CAMERA, camera_rows
from caricli.models.pca.config import PcaConfig
from caricli.models.pca.model import PcaModel
from caricli.store.models import load_model
from caricli.structures import Camera

OTHERS = 1303
PEOPLE = 1000
DIMENSION = 200
GROUPS = ("laughing", "caricature")
ERRORS = (0.001, 0.003, 0.01)
"""Standard deviations of a landmark's coordinates, shares of the diagonal."""
FIRM = 1e9  # per square radian: a pose that is known


def predict(model, truth, view, error, known):
    """Posterior mean (V, 3) for a face (V, 3). view: rotation (3, 3), ids (L,) and errors (L, 2) in deviations."""
    rotation, ids, noise = view
    positions = truth[ids] @ rotation[:2].T
    deviation = error * np.linalg.norm(np.ptp(positions, axis=0))
    _, jacobian = model.points_jacobian(model.prior.mean, ids)
    rows = camera_rows(truth[ids], jacobian, Camera(1.0, rotation, np.zeros(2))).reshape(2 * len(ids), -1)
    gaps = (positions - model.mean[ids] @ rotation[:2].T + deviation * noise).ravel()
    # A shift is free either way; turn and scale are where the pose is not known.
    camera = np.where(known & (np.arange(CAMERA) < 4), FIRM, 1e-9)
    prior = np.diag(np.r_[camera, np.ones(len(model.basis))])
    latent = np.linalg.solve(rows.T @ rows / deviation**2 + prior, rows.T @ gaps / deviation**2)[CAMERA:]
    return model.decode(latent)


@threadpool_limits.wrap(limits=1)
def main():
    """Print the table and the JSON line."""
    seed, count = (int(value) for value in (sys.argv[1:] + [tested_seed(), 24][len(sys.argv) - 1 :])[:2])
    tested = Laughter(seed, count)
    others = Laughter(OTHERS, PEOPLE)
    people = [tested.laughs(number) for number in range(count)]
    trained = [others.laughs(number) for number in range(PEOPLE)]
    bundled = load_model(kind="pca")
    print(f"{'group':10} {'prior':25} {'pose':5} {'landmarks':>9}  depth: {', '.join(REGIONS)}")
    rows = {}
    for column, group in enumerate(GROUPS):
        shapes = np.array([faces[column] for faces in trained], np.float32)
        own = PcaModel.train(tested.template, shapes, PcaConfig(DIMENSION))
        truths = [faces[column] for faces in people]
        views = [observe(tested, truth, number) for number, truth in enumerate(truths)]
        blind = [errors(own.mean, truth, tested.template) for truth in truths]
        add_row(rows, group, ("own group, its mean face", "", "none"), blind)
        for name, model in (("bundled", bundled), ("own group", own)):
            for known in (False, True):
                for error in ERRORS:
                    measured = [
                        errors(predict(model, truth, seen, error, known), truth, tested.template)
                        for truth, seen in zip(truths, views, strict=True)
                    ]
                    add_row(rows, group, (name, "known" if known else "free", f"{100 * error:g} %"), measured)
    print(json.dumps([*rows.values()]))


def observe(laughter, truth, number):
    """Rotation, vertices of the landmarks, and their errors in standard deviations."""
    rotation, ids = laughter.view(truth, number)
    return rotation, ids, np.random.default_rng([laughter.seed, number, 2]).normal(size=(len(ids), 2))


def add_row(rows, group, names, measured):
    """Print one line of means of a group, and add them to the row of their prior, pose and landmarks."""
    depth = np.mean(measured, axis=0)[: len(REGIONS)].tolist()
    prior, pose, landmarks = names
    print(f"{group:10} {prior:25} {pose:5} {landmarks:>9}", *(f"{value:6.2f}" for value in depth), flush=True)
    row = rows.setdefault(names, {"name": " ".join(names), "prior": prior, "pose": pose, "landmarks": landmarks})
    row[group] = dict(zip(REGIONS, depth, strict=True))


if __name__ == "__main__":
    main()
