"""Damped Gauss-Newton steps on the energy of a morphable model against one picture."""

import numpy as np
import torch

from caricli.errors import InputError
from caricli.geometry.alignment.head_rotation import head_angles, head_rotation
from caricli.geometry.gauss_newton import Damping
from caricli.methods.morphable.picture_window import PictureWindow
from caricli.methods.morphable.pixel_rows import VertexRows, pixel_rows, vertex_rows
from caricli.methods.morphable.renderer import MorphableRenderer, Patch, Posed, Sight
from caricli.methods.morphable.settings import PhotometricSettings
from caricli.methods.reconstruct.landmark_fit import Observation
from caricli.methods.reconstruct.settings import DampingSettings, LatentSettings
from caricli.methods.texture.estimate_light import GAMMA
from caricli.models.morphable.model import MorphableModel
from caricli.structures import Camera, Face

_DAMPING = DampingSettings()
_HOLES = ("eye_socket_left", "eye_socket_right", "inner_mouth", "nostril_left", "nostril_right")


class PhotometricSearch:
    """Where a fit is, and what it sees there.

    x: (D,) coefficients, the pose in pixels of the window. sight: Sight of the pixels that are compared. weights: (N,)
    of them, one together. anchors: (K,) vertices that the known landmarks stand on. trust: (K,) of these.
    """

    def __init__(
        self, model: MorphableModel, observation: Observation, window: PictureWindow, settings: PhotometricSettings
    ) -> None:
        """observation: of the landmarks of the window's picture."""
        self.observation = observation
        self.window = window
        self.settings = settings
        self.renderer = MorphableRenderer(model)
        self.layout = self.renderer.layout
        self.patch, self.vertex, self.triangle = skin_patch(model)
        self.noise = LatentSettings().noise
        self.diagonal = observation.diagonal * window.zoom
        self.points = window.to_window(observation.points * observation.diagonal + observation.centre)

    def begin(self, face: Face) -> None:
        """Start with a face that was fitted to the landmarks, in the mean colours and even light."""
        self.x = np.zeros(self.layout.size)
        parts = self.layout.parts(self.x)
        camera = face.require_camera()
        self.x[: self.layout.shape] = face.require_latent()
        middle = self.window.to_window(camera.project(face.vertices.mean(0)))
        parts["pose"][:] = [*head_angles(camera.rotation), *middle, camera.scale * self.window.zoom]
        parts["light"][0] = np.sqrt(4 * np.pi)
        self.look()
        drawn = self._painted(self.x)
        parts["light"][0] *= (self._shown().mean() / drawn.mean()) ** GAMMA
        self.look()

    def run(self, prices: np.ndarray, free: np.ndarray) -> None:
        """Take steps, first on colours and light alone. prices: (D,) of squared coefficients. free: (D,) bool."""
        colours = free.copy()
        colours[: self.layout.shape] = False
        colours[-len(self.layout.parts(self.x)["pose"]) :] = False
        for chosen, rounds in ((colours, self.settings.colours), (free, self.settings.rounds)):
            damping = Damping(_DAMPING.start, _DAMPING.ease, _DAMPING.tighten)
            for _ in range(rounds):
                gain = self._descend(prices, np.flatnonzero(chosen), damping)
                self.look()
                if gain < self.settings.settled:
                    break

    def look(self) -> None:
        """Find what is seen, where landmarks stand, and how far both are trusted."""
        with torch.no_grad():
            posed = self.renderer.pose(self._tensor(self.x)[None])
        height, width = self.window.image.shape[:2]
        sight = self.renderer.look(posed, height, width)
        sure = torch.as_tensor(self.window.sure)[sight.row, sight.column]
        kept = (self.triangle[sight.face] >= 0) & (sure > 0.5)
        if int(kept.sum()) < self.settings.least:
            raise InputError("expected skin of the face in the picture where the landmarks are, found hardly any")
        own = self.triangle[sight.face[kept]]
        self.sight = Sight(sight.picture[kept], sight.row[kept], sight.column[kept], own)
        anchors = self.renderer.anchors(posed, self.observation.count)[0].numpy()[self.observation.ids]
        self.anchors = self.vertex[anchors]
        placed = posed.placed[0].numpy()[anchors, :2]
        distances = np.linalg.norm(placed - self.points, axis=1)
        self.trust = self.observation.weights(distances / self.diagonal)
        rest = np.linalg.norm(self._painted(self.x) - self._shown(), axis=1)
        usual = self.settings.outlier * max(float(np.median(rest)), self.settings.floor)
        weights = sure[kept].numpy() / (1 + (rest / usual) ** 2) ** 2
        self.weights = weights / weights.sum()

    def difference(self) -> float:
        """Root mean square difference of a channel to the picture, over all pixels that are compared."""
        return float(np.sqrt(((self._painted(self.x) - self._shown()) ** 2).mean()))

    def camera(self) -> Camera:
        """The Camera of the given picture."""
        parts = self.layout.parts(self.x)
        rotation = head_rotation(parts["pose"][:3])
        middle = self.renderer.model.decode(self.x[: self.layout.shape]).mean(0)
        scale = float(parts["pose"][5] / self.window.zoom)
        return Camera(scale, rotation, self.window.to_picture(parts["pose"][3:5]) - scale * rotation[:2] @ middle)

    def _descend(self, prices: np.ndarray, chosen: np.ndarray, damping: Damping) -> float:
        """Take a step of the chosen coefficients that lowers the energy, if one of a few does.

        Returns the share by which it lowers it.
        """
        vertices = vertex_rows(self.patch, self.x)
        system, right = self._normal_equations(vertices, prices)
        system = system[np.ix_(chosen, chosen)]
        before = self._cost(self.x, prices)
        for _ in range(_DAMPING.tries):
            moved = self.x.copy()
            moved[chosen] += damping.step(system, right[chosen])
            after = self._cost(moved, prices)
            if after < before:
                self.x = moved
                damping.accept()
                return 1 - after / before
            damping.reject()
        return 0.0

    def _normal_equations(self, vertices: VertexRows, prices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gauss-Newton system (D, D) and right side of half the energy."""
        colours, rows = pixel_rows(self.patch, vertices, self.sight)
        scale = np.sqrt(self.settings.photometric * self.weights).astype(np.float32)[:, None]
        rows = (rows * scale[..., None]).reshape(-1, len(self.x))
        gaps = (scale * (self._shown() - colours)).ravel()
        marks = self._pulled(vertices.jacobian[self.anchors, 3:].astype(float)).reshape(-1, len(self.x))
        misses = self._pulled(self.points - vertices.placed[self.anchors]).ravel()
        system = (rows.T @ rows).astype(float) + marks.T @ marks + np.diag(prices)
        return system, rows.T @ gaps + marks.T @ misses - prices * self.x

    def _cost(self, x: np.ndarray, prices: np.ndarray) -> float:
        """The energy for what is seen as it is."""
        posed = self._posed(x)
        rest = self._paint(posed) - self._shown()
        marks = (self._pulled(posed.placed[0].numpy()[self.anchors, :2] - self.points) ** 2).sum()
        photometric = (self.weights * (rest**2).sum(1)).sum()
        return float(marks + self.settings.photometric * photometric + prices @ x**2)

    def _pulled(self, values: np.ndarray) -> np.ndarray:
        """Values (K, 2, ...) of the landmarks, pixels, in standard deviations and by their trust."""
        trust = np.sqrt(self.trust).reshape(-1, *[1] * (values.ndim - 1))
        return self.observation.whitened(trust * values, self.noise) / (self.noise * self.diagonal)

    def _painted(self, x: np.ndarray) -> np.ndarray:
        return self._paint(self._posed(x))

    def _paint(self, posed: Posed) -> np.ndarray:
        """(N, 3) sRGB of the pixels that are compared."""
        return self.patch.paint(posed, self.sight).numpy()

    def _posed(self, x: np.ndarray) -> Posed:
        with torch.no_grad():
            return self.patch.pose(self._tensor(x)[None])

    def _shown(self) -> np.ndarray:
        """(N, 3) sRGB of the picture at the pixels that are compared."""
        return self.window.image[self.sight.row.numpy(), self.sight.column.numpy()]

    def _tensor(self, x: np.ndarray) -> torch.Tensor:
        return torch.as_tensor(x, dtype=self.renderer.mean.dtype)


def skin_patch(model: MorphableModel) -> tuple[Patch, np.ndarray, torch.Tensor]:
    """The Patch of a face's bare skin with the triangles around it, and what landmarks stand on.

    Returns it, (V,) numbers of the model's vertices in it, and (F,) int64 numbers of triangles that are skin, -1 else.
    """
    template = model.template
    faces = template.faces
    region = np.isin(np.arange(len(template.vertices)), template.region("face"))
    around = region[faces].any(1)
    skin = region & ~template.mask(*(name for name in _HOLES if name in template.annotation.regions))
    ids = np.union1d(faces[around], template.annotation.anchor_ids())
    vertex = np.full(len(template.vertices), -1)
    vertex[ids] = np.arange(len(ids))
    triangle = np.full(len(faces), -1)
    triangle[around] = np.where(skin[faces[around]].all(1), np.arange(around.sum()), -1)
    patch = Patch(model, ids, vertex[faces[around]], torch.float32)
    return patch, vertex, torch.as_tensor(triangle)
