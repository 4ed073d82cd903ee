"""Portraits of known faces, to measure reconstructions with."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.data.albedo import mesh_painter
from caricli.data.appearance import random_appearance
from caricli.geometry.alignment.head_rotation import TURNS, head_rotation
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.render.pixels.blend import over
from caricli.render.shade import Look, shade
from caricli.render.sky import mesh_sky
from caricli.structures import Camera, Landmarks
from caricli.structures.detection import FacePicture
from caricli.structures.landmarks import COUNT
from caricli.template.fine_mesh import fine_mesh
from caricli.template.template import Template


@dataclass(frozen=True)
class StudioSettings:
    """How portraits are set and lit.

    filled: least and largest share of the picture's side that a head takes. aside: share of the side that its middle is
    off, at most, on either axis. plain: share of the backgrounds that are of one colour. clouds: sRGB levels by which
    the others vary, at most, between clouds: cells on a side. grain: sRGB levels, standard deviation of a pixel.
    """

    filled: tuple[float, float] = (0.7, 0.85)
    aside: float = 0.03
    plain: float = 0.5
    clouds: float = 80
    cells: int = 6
    grain: float = 12


@dataclass(frozen=True, eq=False)
class Portrait:
    """A picture with landmarks, and where it is known what it shows.

    name: of the file or the mesh.
    image: (H, W, 3) uint8.
    points: (L, 2) pixels, NaN where unknown.
    mask: (H, W) bool, the head, or None.
    truth: (V, 3) metres, the face, or None.
    camera: Camera that it is seen with, or None.
    """

    name: str
    image: np.ndarray
    points: np.ndarray
    mask: np.ndarray | None = None
    truth: np.ndarray | None = None
    camera: Camera | None = None

    @property
    def picture(self) -> FacePicture:
        """The picture with its landmarks, as fits take it."""
        height, width = self.image.shape[:2]
        return FacePicture(Landmarks(self.points, (width, height)), self.image)


class PortraitStudio:
    """Pictures of known faces: random colours in soft light before a random background."""

    def __init__(self, template: Template, size: int, settings: StudioSettings | None = None) -> None:
        """template: of the faces. size: pixels, width and height of a picture."""
        self.template = template
        self.size = size
        self.settings = settings or StudioSettings()
        self.fine = fine_mesh(template, 1)
        self.painter = mesh_painter(template, self.fine.weights, self.fine.mesh.faces)

    def portray(self, name: str, vertices: np.ndarray, generator: np.random.Generator, noise: float = 0.0) -> Portrait:
        """Draw a face from a random side, its landmarks where its vertices are seen, those of the jaw on the outline.

        name: of the Portrait. vertices: (V, 3) metres. noise: standard deviation of the landmarks' coordinates, percent
        of their diagonal.
        """
        camera = self._camera(vertices, generator)
        drawn = self._drawn(vertices, camera, 255 * self.painter.draw(random_appearance(generator)))
        points = camera.project(vertices[landmark_vertices(vertices, camera.rotation, self.template, COUNT)])
        points += noise / 100 * np.linalg.norm(np.ptp(points, axis=0)) * generator.normal(size=points.shape)
        image = over(drawn, self._background(generator))
        return Portrait(name, image, points, drawn[..., 3] > 127, vertices, camera)

    def _drawn(self, vertices: np.ndarray, camera: Camera, colours: np.ndarray) -> np.ndarray:
        """(H, W, 4) uint8 the head in colours (W, 3) of the finer mesh's vertices."""
        faces = self.template.faces
        visibility = self.fine.weights @ mesh_sky(vertices, faces)
        balls = place_eyeballs(self.template.with_vertices(vertices), self.template.annotation)
        look = Look(
            vertex_colours=colours,
            eyeballs=[(camera.place(centre), camera.scale * radius) for centre, radius in balls],
            gaze=camera.rotation[:, 2],
            visibility=visibility.astype(np.float32),
            rotation=camera.rotation,
        )
        placed = self.fine.weights @ camera.place(vertices)
        return shade(placed, self.fine.mesh.faces, self.size, self.size, look)

    def _camera(self, vertices: np.ndarray, generator: np.random.Generator) -> Camera:
        rotation = head_rotation(generator.uniform(-1, 1, 3) * TURNS)
        flat = vertices @ rotation[:2].T
        scale = generator.uniform(*self.settings.filled) * self.size / np.ptp(flat, axis=0).max()
        middle = self.size * (0.5 + generator.uniform(-self.settings.aside, self.settings.aside, 2))
        return Camera(float(scale), rotation, middle - scale * (flat.min(0) + flat.max(0)) / 2)

    def _background(self, generator: np.random.Generator) -> np.ndarray:
        """Plain, or cloudy and grainy."""
        settings = self.settings
        plain = np.broadcast_to(generator.uniform(0, 255, 3), (self.size, self.size, 3))
        if generator.random() < settings.plain:
            return np.round(plain).astype(np.uint8)
        coarse = generator.uniform(-settings.clouds, settings.clouds, (settings.cells, settings.cells, 3))
        clouds = cv2.resize(coarse, (self.size, self.size), interpolation=cv2.INTER_CUBIC)
        grains = generator.normal(0, settings.grain, plain.shape)
        return np.clip(np.round(plain + clouds + grains), 0, 255).astype(np.uint8)
