"""Ears found in pictures of caricatures, with truth: errors of the ear landmarks with the picture and without.

Usage: python benchmarks/ears.py [SEED [COUNT]]. COUNT people (default: 60) of SEED (default: that of the
published test set), whom no bundled model was trained on, with ears that are drawn anew: from small to giant, lying on
the head or standing out, pointed or round, with long lobes. They are exaggerated in two ways in turn: by curvature, and
by random changes of parts. Each is seen once in a random pose (30 degrees of yaw, 12 of pitch and roll), bald or with
painted hair, soft or in the flat colours of a cartoon, every third with lines of ink, in a random light before a random
background, which is often nearly of the colour of the skin. The 68 landmarks have errors of 0.3 % of their diagonal.

Errors are mean distances of the six ear landmarks from the truth: in the picture, in percent of the diagonal of the 68;
and in space, in millimetres after the best similarity of the face. An ear is worse where its error in the picture grew
by more than one percent. The forehead's three landmarks and the crown are measured in the picture, too. Seconds are
medians of processor time for one fit. The last line is JSON.
"""

import json
import statistics
import sys
import time

import cv2
import numpy as np
from tested_people import tested_seed
from threadpoolctl import threadpool_limits

from caricli.data.build_settings import DRAW, BuildSettings
from caricli.data.exaggerate_parts import exaggerate_parts
from caricli.data.identities import ASYMMETRY
from caricli.data.mesh_source import MeshSource
from caricli.data.move_parts import random_hand, random_part_changes
from caricli.data.regular_face import align_person, regular_face
from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.methods.evaluate.portrait_studio import PortraitStudio
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.rasterise import rasterise
from caricli.store.face_pictures import FaceReader
from caricli.store.models import load_model
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import EAR_LEFT, EAR_RIGHT, FOREHEAD

TRAINED_ON = 0
EARS = {
    "ear-scale-incr": (-1.0, 2.0),
    "ear-scale-vert-incr": (-0.5, 0.8),
    "ear-wing-incr": (-0.5, 2.5),
    "ear-flap-incr": (0.0, 1.0),
    "ear-shape-triangle": (-0.5, 1.0),
    "ear-lobe-incr": (-0.5, 1.0),
    "ear-trans-up": (-1.0, 1.0),
}
"""Least and greatest weight of the head's own changes of an ear."""

CURVATURE = (0.05, 0.25)
SIZE = 512
NOISE = 0.3
TURNED = 12.0
"""Degrees from which on a face has a near ear and a far one."""

WORSE = 1.0
STRANGERS = 120
"""Shapes of the prior that parts are moved with."""

LIKE_SKIN = 0.7
"""Greatest share of the head's mean colour in a background."""

LIGHT = (0.35, 0.75)
"""Share of the light that comes from all sides, at least and at most."""

INK = 0.03
"""Of the depth of the head: what is farther behind its neighbour is behind a line."""


class EarStudio(PortraitStudio):
    """Portraits in a random light, some with lines, before backgrounds that may look like skin."""

    lines = False

    def _drawn(self, vertices, camera, colours):
        generator = np.random.default_rng([int(colours.sum()) % 2**32, 1])
        light = generator.normal(size=3) - [0, 0.3, 1.0]
        light /= np.linalg.norm(light)
        normals = smooth_normals(vertices, self.template.faces) @ camera.rotation.T
        ambient = generator.uniform(*LIGHT)
        received = ambient + (1 - ambient) * 1.6 * np.maximum(normals @ light, 0)
        tint = 1 + generator.uniform(-0.15, 0.15, 3)
        colours = np.clip(colours * (self.fine.weights @ received**0.6)[:, None] * tint, 0, 255)
        drawn = super()._drawn(vertices, camera, colours)
        self.tone = drawn[drawn[..., 3] > 0][:, :3].mean(0)
        if self.lines:
            drawn[self._jumps(vertices, camera)] = (25, 20, 20, 255)
        return drawn

    def _background(self, generator):
        picture = super()._background(generator)
        share = LIKE_SKIN * max(generator.uniform(-1, 1), 0)
        return np.round(picture + share * (self.tone - picture)).astype(np.uint8)

    def _jumps(self, vertices, camera):
        """(H, W) bool: where depth jumps."""
        placed = camera.place(vertices)
        depth = rasterise(placed, self.template.faces, self.size, self.size).depth
        far = placed[:, 2].max() + np.ptp(placed[:, 2])
        depth = np.where(np.isfinite(depth), depth, far)
        jump = cv2.dilate(depth, np.ones((3, 3))) - cv2.erode(depth, np.ones((3, 3)))
        return cv2.dilate((jump > INK * np.ptp(placed[:, 2])).astype(np.uint8), np.ones((2, 2))) > 0


class Eared:
    """Makes people with ears of all sizes by their numbers."""

    def __init__(self, seed, count):
        self.seed = seed
        self.source = MeshSource(BuildSettings(count=count, identities=count, seed=seed))
        self.template = self.source.template
        shapes = np.concatenate([self.source.prior_shape(k) for k in range(STRANGERS)])
        self.prior = IntrinsicModel.train(self.template, shapes, IntrinsicConfig(STRANGERS // 2, seed))
        self.studio = EarStudio(self.template, SIZE)

    def vertices(self, number):
        """(V, 3) metres."""
        generator = np.random.default_rng([self.seed, number])
        strength = 1.0
        for _ in range(DRAW.tries):
            vertices = self._draw(number, generator, strength)
            if flipped_triangles(vertices, self.template.gradients).mean() <= 2 * DRAW.max_flipped:
                break
            strength *= DRAW.milder
        return self.template.cavities.tuck(vertices)

    def _draw(self, number, generator, strength):
        identity = self.source.person(number).identity
        changes = dict(identity.changes)
        for name, limits in EARS.items():
            weight = strength * generator.uniform(*limits)
            changes[f"l-{name}"] = weight
            changes[f"r-{name}"] = weight + ASYMMETRY * generator.normal()
        identity = type(identity)(identity.gender, identity.age, identity.weight, changes)
        person = align_person(identity, self.source.head.evaluate(**vars(identity)), self.template)
        actions = self.source.actions[generator.integers(len(self.source.actions))]
        vertices = regular_face(person, actions, self.source.head)
        if number % 2:
            exponents = [strength * generator.uniform(*CURVATURE)]
            return exaggerate_curvature(vertices, self.template.faces, exponents, self.source.hold)[0]
        moves = random_part_changes(generator, strength)
        hand = random_hand(vertices[self.template.annotation.landmarks], generator, min(strength, 1.0))
        moved = exaggerate_parts(vertices, moves, hand, self.prior)
        face = self.source.face
        scale, rotation, translation = similarity(moved[face], vertices[face])
        return untangle(scale * moved @ rotation.T + translation, self.template.gradients)

    def portrait(self, number):
        """The Portrait of a person."""
        generator = np.random.default_rng([self.seed, number, 1])
        self.studio.lines = number % 3 == 2
        return self.studio.portray(str(number), self.vertices(number), generator, NOISE)


def ears_of(vertices, template):
    """(6, 3) metres."""
    return vertices[template.annotation.landmarks[[*EAR_RIGHT, *EAR_LEFT]]]


def errors(face, portrait, template):
    """Errors (6,) of the ear landmarks in the picture, percent, and in space, millimetres."""
    true = portrait.camera.project(ears_of(portrait.truth, template))
    seen = np.linalg.norm(face.camera.project(ears_of(face.vertices, template)) - true, axis=1)
    region = template.region("face")
    scale, rotation, translation = similarity(face.vertices[region], portrait.truth[region])
    moved = scale * ears_of(face.vertices, template) @ rotation.T + translation
    distances = np.linalg.norm(moved - ears_of(portrait.truth, template), axis=1)
    return 100 * seen / np.linalg.norm(np.ptp(portrait.points, axis=0)), 1000 * distances


def skull_errors(face, portrait, template):
    """Mean errors of the forehead's landmarks, and that of the crown, in the picture, percent."""
    ids = [*template.annotation.landmarks[list(FOREHEAD)], int(template.vertices[:, 1].argmax())]
    gaps = face.camera.project(face.vertices[ids]) - portrait.camera.project(portrait.truth[ids])
    shares = 100 * np.linalg.norm(gaps, axis=1) / np.linalg.norm(np.ptp(portrait.points, axis=0))
    return shares[:-1].mean(), shares[-1]


def measure(portrait, model, reader):
    """Figures of one portrait without its picture and with it, and how its ears are turned away (6,) in degrees."""
    figures = []
    parsed = ParsedPicture(portrait.image, reader.given(portrait.image, portrait.points).regions)
    for picture in (None, parsed):
        start = time.process_time()
        fit = fit_landmarks(portrait.points, model, picture=picture)
        seconds = time.process_time() - start
        skull = skull_errors(fit.face, portrait, model.template)
        figures.append((*errors(fit.face, portrait, model.template), fit.nme, 100 * fit.flipped, *skull, seconds))
    rotation = portrait.camera.rotation
    yaw = np.degrees(np.arctan2(rotation[2, 0], -rotation[2, 2]))
    return figures, yaw * np.repeat([-1, 1], len(EAR_LEFT))


def table(measured):
    """Rows of figures by groups of ears, and figures of the fits alone and with the picture."""
    seen, space = (np.array([[figure[k] for figure in figures] for figures, _ in measured]) for k in (0, 1))
    away = np.array([turns for _, turns in measured])
    groups = {"all": np.isfinite(away), "front": abs(away) < TURNED, "near": away <= -TURNED, "far": away >= TURNED}
    rows = {}
    for name, group in groups.items():
        picture = [float(seen[:, k][group].mean()) for k in (0, 1)]
        depth = [float(space[:, k][group].mean()) for k in (0, 1)]
        fall = 100 * (1 - picture[1] / picture[0])
        rows[name] = {"ears": int(group.sum() / len(EAR_LEFT)), "picture": picture, "fall": fall, "space": depth}
    ears = seen.reshape(len(seen), 2, 2, -1).mean(-1)
    fits = np.array([[figure[2:] for figure in figures] for figures, _ in measured])
    summary = {}
    for k, name in enumerate(("alone", "with the picture")):
        means = dict(zip(("nme", "flipped_percent", "forehead", "crown"), fits[:, k, :4].mean(0).tolist(), strict=True))
        summary[name] = means | {"seconds": statistics.median(fits[:, k, 4].tolist())}
    summary["with the picture"]["worse_ears"] = int((ears[:, 1] > ears[:, 0] + WORSE).sum())
    return rows, summary


@threadpool_limits.wrap(limits=1)
def main():
    """Print the table and the JSON line."""
    seed, count = (int(value) for value in (sys.argv[1:] + [tested_seed(), 60][len(sys.argv) - 1 :])[:2])
    if seed == TRAINED_ON:
        raise InputError(f"the bundled models were trained on people of seed {TRAINED_ON}: take another")
    model = load_model(kind="intrinsic")
    model.prepare()
    people = Eared(seed, count)
    reader = FaceReader()
    measure(people.portrait(0), model, reader)
    rows, summary = table([measure(people.portrait(number), model, reader) for number in range(count)])
    print(f"{'ears':6} {'number':>6}  picture: alone, with it, fall   space: alone, with it")
    for name, row in rows.items():
        picture, space = row["picture"], row["space"]
        print(f"{name:6} {row['ears']:6d}  {picture[0]:5.2f} % {picture[1]:5.2f} % {row['fall']:5.1f} %", end="")
        print(f"  {space[0]:5.1f} mm {space[1]:5.1f} mm")
    print(json.dumps({"seed": seed, "people": count, "ears": rows, "fits": summary}))


if __name__ == "__main__":
    main()
