"""Laughing faces from their 68 landmarks, with truth: depth errors of cheeks, chin, neck and lips.

Usage: python benchmarks/laughing.py [SEED [COUNT]]. COUNT people (default: 24) of SEED (default: that of the
published test set), whom no bundled model was trained on, with open-jawed smiles drawn at random instead of the 25
named expressions, in three groups: as they come; boldly, all weights times 1 to 2, and exaggerated by curvature; and
exaggerated by random changes of parts, whose share in depth no landmark shows. Each is seen once in a random pose (30
degrees of yaw, 12 of pitch and roll). Errors are in millimetres after the best similarity of the face: depth is the
face's own z, distance that of vertices. The last line is JSON.
"""

import json
import sys
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation
from tested_people import tested_seed
from threadpoolctl import threadpool_limits

from caricli.data.build_dataset import PRIOR_DIMENSION, PRIOR_SHAPES
from caricli.data.build_settings import DRAW, EXPONENTS, BuildSettings
from caricli.data.exaggerate_parts import exaggerate_parts
from caricli.data.expressions import expand_sides
from caricli.data.mesh_source import MeshSource
from caricli.data.move_parts import random_hand, random_part_changes
from caricli.data.regular_face import regular_face
from caricli.errors import InputError
from caricli.geometry.alignment.similarity import similarity
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.repair.untangle import untangle
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.intrinsic.model import IntrinsicModel
from caricli.render.views import TO_PICTURE
from caricli.store.models import load_model, load_morphable

TRAINED_ON = 0
LAUGH = {
    "jawOpen": (0.3, 1.0),
    "mouthSmile": (0.3, 1.0),
    "cheekSquint": (0.0, 0.9),
    "eyeSquint": (0.0, 0.6),
    "mouthUpperUp": (0.0, 0.7),
    "mouthLowerDown": (0.0, 0.7),
    "mouthStretch": (0.0, 0.4),
    "browOuterUp": (0.0, 0.5),
}
"""Actions with the least and the greatest weight."""
BOLD = (1.0, 2.0)
CURVATURE = (0.1, 0.3)
POSE = np.radians([30, 12, 12])
PIXELS = 1000.0
REGIONS = {
    "cheeks": ("cheek_left", "cheek_right"),
    "chin": ("chin",),
    "neck": ("neck",),
    "lips": ("lips",),
    "face": ("face",),
}


class Laughter:
    """Makes laughing people by their numbers."""

    def __init__(self, seed, count):
        self.seed = seed
        self.source = MeshSource(BuildSettings(count=count, identities=count, seed=seed))
        self.template = self.source.template

    @cached_property
    def prior(self):
        """IntrinsicModel that parts are exaggerated with."""
        shapes = np.concatenate([self.source.prior_shape(k) for k in range(PRIOR_SHAPES)])
        return IntrinsicModel.train(self.template, shapes, IntrinsicConfig(PRIOR_DIMENSION, self.seed))

    def faces(self, number):
        """Vertices (V, 3) by group."""
        laughing, caricature, generator = self.laughs(number)
        groups = {"laughing": laughing, "caricature": caricature, "parts": self._parts(laughing, generator)}
        return {name: self.template.cavities.tuck(vertices) for name, vertices in groups.items()}

    def laughs(self, number):
        """Laughing face and caricature (V, 3), cavities as they are, and the generator for what comes after them."""
        generator = np.random.default_rng([self.seed, number])
        drawn = {name: generator.uniform(*limits) for name, limits in LAUGH.items()}
        weights = expand_sides(drawn, self.source.head.action_names)
        person = self.source.person(number)
        plain = regular_face(person, weights, self.source.head)
        factor = generator.uniform(*BOLD)
        bold = regular_face(person, {name: factor * weight for name, weight in weights.items()}, self.source.head)
        exponents = [generator.uniform(*CURVATURE)]
        caricature = exaggerate_curvature(bold, self.template.faces, exponents, self.source.hold)[0]
        return plain, caricature, generator

    def _parts(self, plain, generator):
        """The face exaggerated as a dataset's are, by parts and half of the time by curvature before them."""
        strength = generator.uniform(*DRAW.strength)
        face = self.source.face
        for _ in range(DRAW.tries):
            vertices = plain
            if generator.random() < 0.5:
                exponent = generator.choice(EXPONENTS[1:])
                vertices = exaggerate_curvature(plain, self.template.faces, [exponent], self.source.hold)[0]
            changes = random_part_changes(generator, strength)
            hand = random_hand(vertices[self.template.annotation.landmarks], generator, min(strength, 1.0))
            moved = exaggerate_parts(vertices, changes, hand, self.prior)
            scale, rotation, translation = similarity(moved[face], vertices[face])
            moved = untangle(scale * moved @ rotation.T + translation, self.template.gradients)
            if flipped_triangles(moved, self.template.gradients).mean() <= DRAW.max_flipped:
                break
            strength *= DRAW.milder
        return moved

    def view(self, vertices, number):
        """Rotation (3, 3) of a random camera, and the vertices (68,) that landmarks stand on in it."""
        generator = np.random.default_rng([self.seed, number, 1])
        rotation = TO_PICTURE @ Rotation.from_euler("yxz", POSE * generator.uniform(-1, 1, 3)).as_matrix()
        return rotation, landmark_vertices(vertices, rotation, self.template, 68)

    def landmarks(self, vertices, number):
        """(68, 2) pixels, as the random camera sees them."""
        rotation, ids = self.view(vertices, number)
        return PIXELS * vertices[ids] @ rotation[:2].T


def errors(vertices, truth, template):
    """Millimetres: depth errors of REGIONS without the mouth's inside, then distances."""
    face = template.region("face")
    scale, rotation, translation = similarity(vertices[face], truth[face])
    difference = 1000 * (scale * vertices @ rotation.T + translation - truth)
    regions = [template.mask(*names) & ~template.mask("inner_mouth") for names in REGIONS.values()]
    depth = [np.abs(difference[region, 2]).mean() for region in regions]
    return depth + [np.linalg.norm(difference[region], axis=1).mean() for region in regions]


def methods():
    """Functions from landmarks (68, 2) to a LandmarkFit, by name."""
    intrinsic, kernel, pca = (load_model(kind=kind) for kind in ("intrinsic", "kernel", "pca"))
    morphable = load_morphable()
    return {
        "intrinsic": lambda points: fit_landmarks(points, intrinsic),
        "latent (`kernel`)": lambda points: fit_landmarks(points, kernel, "latent"),
        "latent (`pca`)": lambda points: fit_landmarks(points, pca, "latent"),
        "`fit-morphable`": lambda points: fit_morphable(points, morphable),
    }


def rows(laughter, count):
    """Yield a row of means for each group and method."""
    people = [laughter.faces(number) for number in range(count)]
    for group in people[0]:
        for name, fit in methods().items():
            fits = [fit(laughter.landmarks(faces[group], number)) for number, faces in enumerate(people)]
            measured = [
                errors(fit.face.vertices, faces[group], laughter.template)
                for fit, faces in zip(fits, people, strict=True)
            ]
            depth, distance = np.mean(measured, axis=0).reshape(2, -1).tolist()
            yield {
                "name": f"{group}, {name}",
                "nme": float(np.mean([fit.nme for fit in fits])),
                "flipped_percent": float(100 * np.mean([fit.flipped for fit in fits])),
                "depth": dict(zip(REGIONS, depth, strict=True)),
                "distance": dict(zip(REGIONS, distance, strict=True)),
            }


@threadpool_limits.wrap(limits=1)
def main():
    """Print the table and the JSON line."""
    seed, count = (int(value) for value in (sys.argv[1:] + [tested_seed(), 24][len(sys.argv) - 1 :])[:2])
    if seed == TRAINED_ON:
        raise InputError(f"the bundled models were trained on people of seed {TRAINED_ON}: take another")
    table = []
    print(f"{'group, method':26} {'NME':>5} {'flipped':>7}  depth, then distance: {', '.join(REGIONS)}")
    for row in rows(Laughter(seed, count), count):
        table.append(row)
        depth, distance = (" ".join(f"{value:6.2f}" for value in row[key].values()) for key in ("depth", "distance"))
        print(f"{row['name']:26} {row['nme']:5.3f} {row['flipped_percent']:7.3f}  {depth} |{distance}")
    print(json.dumps(table))


if __name__ == "__main__":
    main()
