"""Landmark fits inside a model as the deformable paper publishes them: equation 3 by Adam (section 5.1, supplement 5).

A rival of ``fit_landmarks_latent``, for the deformable and the kernel model. Four rounds of the pose, with the jaw on
the outline of it, and of the latent, which Adam takes to the least of

    mean_k |s R[:2] p_k(z) + t - b_k|^2 + reg / M |z|^2

at the published rate of 1e-4, a hundredth of the latents' deviation, until the loss no longer falls by 1e-10 of itself.
No landmark loses weight, and latents are not whitened. What the paper leaves open: reg is the symbol of its equation 1,
where it is 1e6, and pictures have some size in pixels.

Usage: python -m benchmarks.adam_fit [FOLDER] of landmark files (default: $CARICLI_REAL_DATA, else the astronaut). Both
models, beside ``fit_landmarks_latent``. The last line is JSON.
"""

import json
import sys
import time

import numpy as np
import torch

from benchmarks.landmarks import landmark_files
from caricli.io.landmarks import read_landmarks
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.landmark_fit import Observation
from caricli.methods.reconstruct.settings import LatentSettings
from caricli.store.models import load_model
from caricli.structures import Face

PUBLISHED = 1e6
"""The weight of the latent, landmarks in pixels, for latents of the deviation DEVIATION."""

DEVIATION = 0.01
RATE = 1e-4
BETAS = (0.9, 0.999)
ROUNDS = 4
LEAST_FALL = 1e-10
MOST_STEPS = 5000
"""Of a round; none of six drawings needed so many."""


def fit_landmarks_adam(points, model):
    """Fit landmarks (L, 2), pixels. Returns LandmarkFit and how many steps Adam took."""
    observation = Observation(points, model.template)
    spread = float(np.sqrt(np.square(model.prior.factor).sum(1).mean()))
    weight = PUBLISHED / len(model.prior.mean) * (DEVIATION / spread / observation.diagonal) ** 2
    latent = model.prior.mean
    rotation = None
    steps = 0
    for _ in range(ROUNDS):
        camera, anchors = observation.settle(model.decode(latent), None, rotation)
        rotation = camera.rotation
        loss = _loss(observation, model, camera, anchors[observation.ids], weight)
        latent, taken = descend(loss, latent, RATE * spread / DEVIATION)
        steps += taken
    face = Face(model.template.with_vertices(model.decode(latent)), camera, latent=latent, model_id=model.model_id)
    return observation.measure(face, model, observation.trust, LatentSettings()), steps


def descend(loss, start, rate):
    """Adam from a latent (D,), until the loss no longer falls. Returns where it ends, and the steps."""
    latent = torch.tensor(start, dtype=torch.float64, requires_grad=True)
    adam = torch.optim.Adam([latent], rate, BETAS)
    before = np.inf
    steps = 0
    while steps < MOST_STEPS:
        adam.zero_grad()
        value = loss(latent)
        now = float(value.detach())
        if not before - now >= LEAST_FALL * now:
            break
        before = now
        value.backward()
        adam.step()
        steps += 1
    return latent.detach().numpy().copy(), steps


def _loss(observation, model, camera, ids, weight):
    """Equation 3 for a pose and anchors (K,), in units of the landmarks' diagonal."""
    place = _deformable(model, ids) if model.kind == "deformable" else _kernel(model, ids)
    turn = torch.from_numpy(camera.scale * camera.rotation[:2].T)
    gap = torch.from_numpy(camera.translation - observation.points)
    return lambda latent: (place(latent) @ turn + gap).square().sum(1).mean() + weight * latent.square().sum()


def _deformable(model, ids):
    """Positions (K, 3) of vertices as a function of the latent."""
    points = model.box.points[ids]
    places = torch.from_numpy(model.box.normalise(points).astype(np.float32))
    own = torch.from_numpy(points)
    return lambda latent: model.network.displacements(latent.float(), places).double() / model.box.scale + own


def _kernel(model, ids):
    process = model.process
    scale, centres, weights = (torch.from_numpy(each) for each in (process.scale, process.centres, process.weights))
    mean, basis = (torch.from_numpy(each) for each in (model.mean[ids], model.basis[:, ids]))

    def place(latent):
        likeness = torch.exp(-(latent * scale - centres).square().sum(1) / 2)
        return mean + torch.tensordot(torch.cat([latent, likeness @ weights]), basis, 1)

    return place


def gauss_newton(points, model):
    """``fit_landmarks_latent`` at the prior weight 1, and its steps."""
    fit = fit_landmarks(points, model, "latent")
    return fit, fit.rounds


WAYS = {
    "Gauss-Newton": gauss_newton,
    "Adam, as published": fit_landmarks_adam,
}
KINDS = ("deformable", "kernel")


def measure(name, way, model, marks):
    """A row: means over landmark sets."""
    fits = []
    taken = []
    seconds = []
    for points in marks:
        start = time.process_time()
        fit, steps = way(points, model)
        seconds.append(time.process_time() - start)
        fits.append(fit)
        taken.append(steps)
        print(
            f"{model.kind}, {name}: {fit.describe()}, {steps} steps, {seconds[-1]:.2f} s", file=sys.stderr, flush=True
        )
    return {
        "name": f"{name} (`{model.kind}`)",
        "nme": float(np.mean([fit.nme for fit in fits])),
        "nme_worst": max(fit.nme for fit in fits),
        "prior_rms": float(np.mean([fit.prior_rms for fit in fits])),
        "flipped_percent": 100 * float(np.mean([fit.flipped for fit in fits])),
        "steps": float(np.median(taken)),
        "processor_seconds": float(np.median(seconds)),
    }


def main():
    """Print the JSON line."""
    torch.set_num_threads(1)
    marks = [read_landmarks(path).points for path in landmark_files()]
    models = [load_model(kind=kind) for kind in KINDS]
    for model in models:
        gauss_newton(marks[0], model)
    print(json.dumps([measure(name, way, model, marks) for name, way in WAYS.items() for model in models]))


if __name__ == "__main__":
    main()
