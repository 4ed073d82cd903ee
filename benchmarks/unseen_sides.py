"""Colours of what a picture does not show, against truth.

Usage: python benchmarks/unseen_sides.py [SEED [COUNT]]. COUNT people (default: 50) of SEED (default: that of the
published test set), whom no model was trained on, half of them exaggerated by curvature, in random colours, from a
random side, before a random background. One wide light stands anywhere before the head or above it, warm or cold,
beside a sky and a ground of their own, with shadows; it is exposed as by an incident light meter beside the face, 15 %
wrong at random. One of five pictures has the same light from everywhere, as flat drawings have. Light is nowhere given:
shape, camera and mask are.

The error is the mean difference of sRGB from the colours without light, percent of full scale, over the surface that
the camera does not see, by its area, without the insides of mouth, nostrils and eye sockets. `balanced` is the same
after one factor for each channel has made the seen part as bright as its truth: it leaves out how bright the picture
was taken. `smooth` is without the grain of unseen skin. The last line is JSON.
"""

import json
import sys
from dataclasses import dataclass

import numpy as np
from tested_people import tested_seed

from caricli.data.appearance import random_appearance
from caricli.data.build_settings import BuildSettings
from caricli.data.mesh_source import MeshSource
from caricli.data.regular_face import regular_face
from caricli.data.texture_painter import TexturePainter
from caricli.geometry.alignment.head_rotation import TURNS, head_rotation
from caricli.geometry.deformation.exaggerate_curvature import exaggerate_curvature
from caricli.methods.texture.picture_view import Sight
from caricli.methods.texture.settings import TextureSettings
from caricli.methods.texture.texture_face import texture_face
from caricli.render.pixels.sample_texture import sample_texture
from caricli.render.sky import DIRECTIONS, light_received, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.rasterise import rasterise
from caricli.render.visibility.uv_map import uv_map
from caricli.structures import Camera
from caricli.template.annotation import CAVITIES

SIDE = 512
TEXTURE = 512
TRUTH = 1024
FILLED = 0.8
FLAT = 0.2
CURVATURE = 0.3
EXPOSED = 0.15
INSIDE = (*CAVITIES, "nostril_left", "nostril_right")
NECK = ("neck",)
PARTS = {"ears": ("ear_left", "ear_right"), "neck": NECK, "scalp": ("scalp",), "face": ("face",)}
_SMALL = 1e-9


@dataclass(frozen=True, eq=False)
class Sitter:
    """A head with its colours, a picture of it, and where its texels are.

    head: Template. camera: Camera. image: (H, W, 3) uint8. mask: (H, W) bool. truth: (S, S, 3) uint8 sRGB, without
    light. unseen: (N,) square metres of every texel that the camera does not see. seen: (N,) the same of the others.
    parts: (N,) from 0 to 1 by the keys of PARTS.
    """

    head: object
    camera: Camera
    image: np.ndarray
    mask: np.ndarray
    truth: np.ndarray
    unseen: np.ndarray
    seen: np.ndarray
    parts: dict


class Studio:
    """Draws people by their numbers."""

    def __init__(self, seed, count):
        self.seed = seed
        self.source = MeshSource(BuildSettings(count=count, identities=count, seed=seed))
        self.template = self.source.template
        self.painter = TexturePainter(self.template, TRUTH)
        self.face, self.weights = uv_map(self.template, TEXTURE)

    def sitter(self, number):
        """The Sitter of a number."""
        generator = np.random.default_rng([self.seed, number])
        vertices = regular_face(self.source.person(number), {}, self.source.head)
        if generator.random() < 0.5:
            exponents = [generator.uniform(0, CURVATURE)]
            vertices = exaggerate_curvature(vertices, self.template.faces, exponents, self.source.hold)[0]
        vertices = self.template.cavities.tuck(vertices)
        head = self.template.with_vertices(vertices)
        camera = _camera(vertices, generator)
        truth = self.painter.draw(random_appearance(generator))
        light = _light(head, camera, generator)
        image, mask = _picture(head, camera, truth, light, generator)
        areas, seen = self._texels(head, camera)
        texel_parts = {name: self._share(head, names) for name, names in PARTS.items()}
        counted = areas * (self._share(head, INSIDE) < 0.1)
        return Sitter(head, camera, image, mask, truth, counted * ~seen, counted * seen, texel_parts)

    def _share(self, head, names):
        covered = self.face >= 0
        corners = head.faces[self.face[covered]]
        return (self.weights[covered] * head.mask(*names)[corners]).sum(1)

    def _texels(self, head, camera):
        """Areas (N,) of texels on the head, and which the camera sees."""
        covered = self.face >= 0
        faces = self.face[covered]
        corners = head.vertices[head.faces[faces]]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        texels = np.bincount(faces, minlength=len(head.faces))[faces]
        areas = np.linalg.norm(across, axis=1) / 2 / texels
        places = np.einsum("nk,nkc->nc", self.weights[covered], corners)
        way = -camera.rotation[2]
        towards = smooth_normals(head.vertices, head.faces)[head.faces[faces]]
        facing = np.einsum("nk,nkc,c->n", self.weights[covered], towards, way) > 0.1
        placed = camera.place(head.vertices)
        raster = rasterise(placed, head.faces, SIDE, SIDE)
        at = camera.place(places)
        column, row = np.clip(np.round(at[:, :2]).astype(int), 0, SIDE - 1).T
        behind = at[:, 2] - raster.depth[row, column]
        return areas, facing & (behind < 0.01 * camera.scale * head.height)


def _camera(vertices, generator):
    rotation = head_rotation(generator.uniform(-1, 1, 3) * TURNS)
    flat = vertices @ rotation[:2].T
    scale = FILLED * SIDE / np.ptp(flat, axis=0).max()
    return Camera(float(scale), rotation, SIDE / 2 - scale * (flat.min(0) + flat.max(0)) / 2)


def _light(head, camera, generator):
    """(V, 3) linear light that arrives at the vertices."""
    normals = smooth_normals(head.vertices, head.faces)
    dome = _dome()
    if generator.random() < FLAT:
        here = np.ones((len(normals), 3))
        beside = np.ones((len(dome), 3))
    else:
        angles = np.radians([generator.uniform(-90, 90), generator.uniform(-15, 75)])
        way = np.array(
            [np.sin(angles[0]) * np.cos(angles[1]), -np.sin(angles[1]), -np.cos(angles[0]) * np.cos(angles[1])]
        )
        key = generator.uniform(0.4, 1.4) * _tint(generator)
        sky = generator.uniform(0.2, 0.8) * _tint(generator)
        ground = generator.uniform(0.1, 0.6) * _tint(generator)
        visibility = sky_visibility(head.vertices, head.faces, normals)
        reached = light_received(visibility, normals, DIRECTIONS, (way @ camera.rotation, None))
        here = _arriving(normals @ camera.rotation.T, way, key, sky, ground, reached)
        beside = _arriving(dome, way, key, sky, ground, np.ones((len(dome), 2)))
    metered = beside[dome[:, 2] < 0].mean(axis=(0, 1))
    return here / metered * np.exp(generator.normal(0, EXPOSED))


def _arriving(normals, way, key, sky, ground, reached):
    """Light (N, 3) at normals (N, 3) in the picture's frame."""
    up = (1 - normals[:, 1:2]) / 2
    around = (up * sky + (1 - up) * ground) * reached[:, 1:2]
    return around + np.maximum(normals @ way, 0)[:, None] * reached[:, :1] * key


def _tint(generator):
    """(3,) warm or cold, of mean one."""
    warm = generator.normal(0, 0.12)
    tint = np.array([1 + warm, 1, 1 - warm])
    return tint / tint.mean()


def _dome(count=200):
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    turn = np.pi * (1 + np.sqrt(5)) * k
    return np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], 1)


def _picture(head, camera, albedo, light, generator):
    """The picture (H, W, 3) uint8 and the mask (H, W) bool, from one twice as large."""
    placed = 2 * camera.place(head.vertices) + [0.5, 0.5, 0]
    raster = rasterise(placed, head.faces, 2 * SIDE, 2 * SIDE)
    shown = raster.face >= 0
    weights = raster.barycentric[shown].astype(float)
    faces = raster.face[shown]
    uvs = np.einsum("nk,nkc->nc", weights, head.uvs[head.uv_faces[faces]])
    lit = linear(sample_texture(albedo, uvs)) * np.einsum("nk,nkc->nc", weights, light[head.faces[faces]])
    canvas = np.broadcast_to(linear(generator.uniform(0, 255, 3)), (2 * SIDE, 2 * SIDE, 3)).copy()
    canvas[shown] = lit
    halves = canvas.reshape(SIDE, 2, SIDE, 2, 3).mean((1, 3))
    mask = shown.reshape(SIDE, 2, SIDE, 2).mean((1, 3)) > 0.5
    return np.round(srgb(halves)).astype(np.uint8), mask


def linear(colours):
    """From sRGB, 0 to 255, to linear light."""
    x = np.asarray(colours, float) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def srgb(light):
    """From linear light to sRGB, 0 to 255."""
    x = np.clip(light, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def errors(sitter, studio, settings, generator=None):
    """Percent by what is measured."""
    sight = Sight(sitter.camera, sitter.image, sitter.mask)
    texture = texture_face(sitter.head, sight, TEXTURE, settings, generator).image
    covered = studio.face >= 0
    row, column = np.nonzero(covered)
    uvs = np.stack([(column + 0.5) / TEXTURE, 1 - (row + 0.5) / TEXTURE], 1)
    truth = sample_texture(sitter.truth, uvs)
    painted = texture[covered].astype(float)
    wrong = np.abs(painted - truth).mean(1) / 2.55
    linear_truth = linear(truth)
    linear_painted = linear(painted)
    factor = (sitter.seen @ linear_truth) / np.maximum(sitter.seen @ linear_painted, _SMALL)
    balanced = np.abs(srgb(linear_painted * factor) - truth).mean(1) / 2.55
    figures = {"unseen": _mean(wrong, sitter.unseen), "balanced": _mean(balanced, sitter.unseen)}
    for name, share in sitter.parts.items():
        figures[name] = _mean(wrong, sitter.unseen * share)
    return figures | {"seen": _mean(wrong, sitter.seen)}


def _mean(values, weights):
    return float(values @ weights / max(weights.sum(), _SMALL))


def main():
    """Print the table and the JSON line."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else tested_seed()
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 50
    studio = Studio(seed, count)
    usual = TextureSettings()
    ways = {"without light": (usual, 0), "smooth": (usual, None), "kept light": (TextureSettings(keep_light=True), 0)}
    rows = {name: [] for name in ways}
    for number in range(count):
        sitter = studio.sitter(number)
        for name, (settings, grain) in ways.items():
            generator = None if grain is None else np.random.default_rng(grain)
            rows[name].append(errors(sitter, studio, settings, generator))
    figures = {}
    for name, found in rows.items():
        figures[name] = {key: round(float(np.mean([row[key] for row in found])), 3) for key in found[0]}
        print(name, *(f"{key} {value:.2f}" for key, value in figures[name].items()))
    print(json.dumps({"seed": seed, "people": count, "percent": figures}))


if __name__ == "__main__":
    main()
