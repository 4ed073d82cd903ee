"""A SIREN that deforms the template, its weights made from a latent by a hypernetwork (deformable paper, section 3)."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import torch
from scipy.sparse import csr_matrix

from caricli.errors import NumericsError
from caricli.geometry.gauss_newton import Damping
from caricli.models.deformable.config import NetworkSize
from caricli.models.deformable.networks import HyperSiren, siren
from caricli.models.model_id import NamedByWeights
from caricli.models.prior import Prior
from caricli.structures import SeenPeople
from caricli.structures.checks import are_apart, coordinate_problem
from caricli.template.template import Template

_NARROWEST = 1e-9
"""Least standard deviation of a latent beside the others: far below what any training leaves."""

_CHUNK = 8192
"""Points decoded at once: pieces that stay in the processor's cache are several times faster than all together."""


@dataclass(frozen=True)
class EncoderSettings:
    """How a shape is encoded.

    vertices: how many stand for all where derivatives are needed. faces: random ones that the first guess is fitted to,
    batch: of them at once. noise: of that fit, a share of the mean variance, because what the network does is not
    linear. rounds: at most. ridge: weight of the whitened latent, for a target of mean square displacement one.
    tolerance: the share by which a step must lower the cost for another one to follow. damping: to begin with, divided
    by ease after a step that lowered the cost and multiplied by tighten after another.
    """

    vertices: int = 256
    faces: int = 1024
    batch: int = 64
    noise: float = 0.1
    rounds: int = 25
    ridge: float = 1e-5
    tolerance: float = 3e-3
    damping: float = 1.0
    ease: float = 5.0
    tighten: float = 10.0


_ENCODER = EncoderSettings()


class UnitBox:
    """The network's coordinates: template points centred and scaled into [-1, 1].

    points: (V, 3) metres, the template with its lips apart, because the network tells points apart by position alone.
    Raises ValueError when they lie in one place or are no coordinates.
    """

    def __init__(self, points: np.ndarray) -> None:
        if coordinate_problem("points", points) or not are_apart(points):
            raise ValueError("the points of its template are no finite ones that are apart")
        low = points.min(0)
        high = points.max(0)
        self.points = points
        self.centre = (low + high) / 2
        self.scale = 2 / float((high - low).max())

    def normalise(self, points: np.ndarray) -> np.ndarray:
        """Metres to [-1, 1]."""
        return (points - self.centre) * self.scale


class DeformableModel(NamedByWeights):
    """vertices = points + S(points; H(latent)), a continuous function of the template's surface.

    A latent has no unit; ``prior`` knows how the training latents are spread.
    """

    kind = "deformable"
    seen: SeenPeople | None = None

    def __init__(self, template: Template, network: HyperSiren, points: np.ndarray, prior: Prior) -> None:
        """points: (V, 3) metres, see UnitBox. prior: of the latents."""
        self.template = template
        self.prior = prior
        self.box = UnitBox(points)
        self.network = network.eval().requires_grad_(False)

    @classmethod
    def from_tensors(cls, template: Template, tensors: Mapping[str, np.ndarray]) -> Self:
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        weights = {name.removeprefix("network."): t for name, t in tensors.items() if name.startswith("network.")}
        count, hidden, latent = weights["first.weight"].shape
        width = weights["last.0.weight"].shape[0] // 3
        size = NetworkSize(latent, width, count // 2 - 1, hidden, tensors["frequency"].item())
        points, mean, factor = (tensors[name].astype(float) for name in ("points", "prior_mean", "prior_factor"))
        if count % 2 or points.shape != template.vertices.shape or mean.shape != (latent,):
            raise ValueError(f"{count} tensors, points {points.shape}, prior {mean.shape} for latents of {latent}")
        if factor.shape != (latent, latent) or np.triu(factor, 1).any() or not (np.diag(factor) > _NARROWEST).all():
            raise ValueError("its prior is not a lower triangular factor")
        # Without memory for the weights until it is known that they fit.
        with torch.device("meta"):
            network = HyperSiren(size, torch.Generator())
        own = network.state_dict()
        if own.keys() != weights.keys() or any(own[name].shape != t.shape for name, t in weights.items()):
            raise ValueError("the shapes of its weights do not fit each other")
        given = {name: torch.from_numpy(t.astype(np.float32)) for name, t in weights.items()}
        network.load_state_dict(given, assign=True)
        return cls(template, network, points, Prior(mean, factor))

    def tensors(self) -> dict[str, np.ndarray]:
        """See ShapeModel: weights in half precision, biases whole, because they hold the SIREN of the mean face."""
        tensors: dict[str, np.ndarray] = {
            "points": self.box.points.astype(np.float64),
            "frequency": np.array([self.network.size.frequency], np.float32),
            "prior_mean": self.prior.mean.astype(np.float32),
            "prior_factor": self.prior.factor.astype(np.float32),
        }
        for name, value in self.network.state_dict().items():
            array = value.cpu().numpy()
            tensors[f"network.{name}"] = array.astype(np.float32 if name.endswith("bias") else np.float16)
        return tensors

    def prepare(self) -> None:
        """See ShapeModel: the fits need nothing beyond what is here."""

    def decode(self, latents: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return self.decode_at(latents, self.box.points)

    def decode_on(self, latents: np.ndarray, matrix: csr_matrix) -> np.ndarray:
        """See ShapeModel: the continuous function there, not between the vertices' positions (section 4.3)."""
        return self.decode_at(latents, matrix @ self.box.points)

    def decode_at(self, latents: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Latents (..., D) and points (K, 3) of the network's template, in metres, to positions (..., K, 3)."""
        latents = np.asarray(latents)
        flat = torch.from_numpy(latents.reshape(-1, latents.shape[-1]).astype(np.float32))
        places = self._places(points)
        shapes = np.empty((len(flat), len(points), 3))
        for latent, shape in zip(flat, shapes, strict=True):
            weights = self.network.weights(latent)
            for start in range(0, len(points), _CHUNK):
                piece = siren(places[start : start + _CHUNK], weights, self.network.size.frequency)
                shape[start : start + _CHUNK] = piece.numpy()
        return (shapes / self.box.scale + points).reshape(*latents.shape[:-1], -1, 3)

    def decode_points(self, latent: np.ndarray, points: np.ndarray) -> np.ndarray:
        """See ShapeModel."""
        return self.decode_at(latent, self.box.points[points])

    def points_jacobian(self, latent: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See ShapeModel: forward mode through hypernetwork and SIREN at the points asked for."""
        chosen = self.box.points[points]
        given = torch.from_numpy(np.asarray(latent, dtype=np.float32))
        moved, derivative = self.network.displacements_jacobian(given, self._places(chosen))
        jacobian = derivative.permute(1, 2, 0).numpy().astype(np.float64)
        return moved.numpy() / self.box.scale + chosen, jacobian / self.box.scale

    def encode(self, vertices: np.ndarray) -> np.ndarray:
        """See ShapeModel: the auto-decoder inverted (section 3).

        Minimises ``mean_v |v(z) - t_v|^2 + ridge |whitened z|^2`` by damped Gauss-Newton steps, whose gradient is that
        of all vertices and whose matrix is estimated at some of them. Begins with the best linear guess.
        """
        shapes = vertices.reshape(-1, *vertices.shape[-2:])
        return np.array([self._encode_one(shape) for shape in shapes]).reshape(*vertices.shape[:-2], -1)

    @cached_property
    def _sample(self) -> np.ndarray:
        """Ids of the vertices that stand for all."""
        return np.sort(np.random.default_rng(0).permutation(len(self.template.vertices))[: _ENCODER.vertices])

    @cached_property
    def _linear_encoder(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean displacements (M,) of the sample, and the matrix (M, D) that best makes whitened latents of the rest."""
        whitened = np.random.default_rng(1).normal(size=(_ENCODER.faces, self.network.size.latent))
        latents = torch.from_numpy(self.prior.colour(whitened).astype(np.float32))
        places = self._places(self.box.points)[self._sample]
        batches = latents.split(_ENCODER.batch)
        moved = torch.cat([self.network.displacements(batch, places).flatten(1) for batch in batches])
        mean = moved.mean(0).numpy()
        rest = moved.numpy().astype(float) - mean
        moments = rest.T @ rest
        moments += _ENCODER.noise * np.trace(moments) / len(moments) * np.eye(len(moments))
        try:
            return mean, np.linalg.solve(moments, rest.T @ whitened)
        except np.linalg.LinAlgError as error:
            raise NumericsError("the network's latents make no two shapes: none can be found for a face") from error

    def _places(self, points: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(self.box.normalise(points).astype(np.float32))

    def _encode_one(self, vertices: np.ndarray) -> np.ndarray:
        fit = _LatentFit(self, torch.from_numpy(((vertices - self.box.points) * self.box.scale).astype(np.float32)))
        mean, encoder = self._linear_encoder
        trial = (fit.target[self._sample].flatten().numpy() - mean) @ encoder
        whitened = trial
        cost = np.inf
        damping = Damping(_ENCODER.damping, _ENCODER.ease, _ENCODER.tighten)
        for _ in range(_ENCODER.rounds):
            state = fit.at(trial)
            if state.cost < cost:
                settled = state.cost > (1 - _ENCODER.tolerance) * cost
                whitened = trial
                cost = state.cost
                damping.accept()
                if settled:
                    break
                system, gradient = fit.equations(state)
            elif np.isfinite(cost):
                damping.reject()
            else:
                raise NumericsError("expected a model of finite shapes, found one whose error is not finite")
            trial = whitened - damping.step(system, gradient)
        return self.prior.colour(whitened)


@dataclass(frozen=True, eq=False)
class _FitState:
    """Where a fit is.

    whitened: (D,). latent: (D,), the same as the network takes it. error: mean square distance, differentiable by the
    latent. cost: with the whitened latent's share.
    """

    whitened: np.ndarray
    latent: torch.Tensor
    error: torch.Tensor
    cost: float


class _LatentFit:
    """Cost and derivatives at whitened latents for one target."""

    def __init__(self, model: DeformableModel, target: torch.Tensor) -> None:
        """target: (V, 3) displacements in the network's coordinates."""
        self.network = model.network
        self.factor = model.prior.factor
        self.colour = model.prior.colour
        self.places = model._places(model.box.points)
        self.sample = model._sample
        self.target = target
        self.ridge = _ENCODER.ridge * float(target.square().sum(-1).mean())

    def at(self, whitened: np.ndarray) -> _FitState:
        """The state with a whitened latent (D,)."""
        latent = torch.from_numpy(self.colour(whitened).astype(np.float32)).requires_grad_()
        error = (self.network.displacements(latent, self.places) - self.target).square().sum(-1).mean()
        cost = float(error.detach()) + self.ridge * np.square(whitened).sum()
        return _FitState(whitened, latent, error, cost)

    def equations(self, state: _FitState) -> tuple[np.ndarray, np.ndarray]:
        """Gauss-Newton's matrix (D, D) of the cost, estimated at the sample, and its gradient (D,), that of all."""
        (slope,) = torch.autograd.grad(state.error, state.latent)
        gradient = slope.numpy() @ self.factor + 2 * self.ridge * state.whitened
        _, derivative = self.network.displacements_jacobian(state.latent.detach(), self.places[self.sample])
        rows = derivative.flatten(1).numpy().T @ self.factor
        system = 2 * (rows.T @ rows / len(self.sample) + self.ridge * np.eye(len(state.whitened)))
        return system, gradient
