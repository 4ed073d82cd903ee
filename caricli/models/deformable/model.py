"""A SIREN that deforms the template, its weights made from a latent by a hypernetwork (deformable paper, section 3)."""

from functools import cached_property
from math import prod, sqrt

import numpy as np
import torch
from torch import nn

from caricli.models.config import NetworkSize
from caricli.models.prior import Prior

_CHUNK = 8192
_SAMPLED, _DRAWN, _BATCH = 256, 1024, 64
_ROUNDS, _RIDGE, _TOLERANCE = 25, 1e-5, 3e-3


def siren(points, parameters, frequency, precision=torch.float32):
    """Displacements of template points: sine layers, then a linear one (section 3.2).

    points: (..., N, 3) in [-1, 1]. parameters: weights (..., out, in) and biases (..., out) in turn. precision: of the
    hidden layers; the first, whose phases are large, and the last stay as they are.
    Returns (..., N, 3).
    """
    first, *hidden = zip(parameters[:-2:2], parameters[1:-2:2], strict=True)
    x = torch.sin(_affine(points, frequency * first[0], frequency * first[1])).to(precision)
    for weight, bias in hidden:
        x = torch.sin(_affine(x, (frequency * weight).to(precision), (frequency * bias).to(precision)))
    return _affine(x.to(points.dtype), *parameters[-2:])


class HyperSiren(nn.Module):
    """Latents to displacements: for every tensor of the SIREN one ReLU MLP, latent -> hidden -> hidden -> numel.

    The last layers start a hundred times smaller than Kaiming's initialisation and their biases hold a SIREN's, so that
    training starts near the template (supplement 2; SIREN: Sitzmann et al. 2020).
    """

    def __init__(self, size, generator, precision=torch.float32):
        """size: NetworkSize. generator: torch.Generator of the initial weights. precision: see ``siren``."""
        super().__init__()
        self.size, self.precision, shapes = size, precision, size.shapes()
        self.first = Affine(size.latent, size.hidden, generator, count=len(shapes))
        self.second = Affine(size.hidden, size.hidden, generator, count=len(shapes))
        self.last = nn.ModuleList(Affine(size.hidden, prod(shape), generator, scale=0.01) for shape in shapes)
        for layer, start in zip(self.last, siren_start(size, generator), strict=True):
            layer.bias.data = start.flatten()

    def weights(self, latents):
        """Latents (..., D) to the SIREN's weights and biases with the same leading dimensions."""
        flat = latents.reshape(1, -1, latents.shape[-1])
        hidden = torch.relu(self.second(torch.relu(self.first(flat))))
        shapes = self.size.shapes()
        return [layer(hidden[k]).reshape(*latents.shape[:-1], *shapes[k]) for k, layer in enumerate(self.last)]

    def forward(self, latents, points):
        """Latents (..., D) and Points on the template to displacements (..., n, 3)."""
        return self.displacements(latents, points.positions)

    def displacements(self, latents, positions):
        """Latents (..., D) and positions (..., N, 3) in [-1, 1] to displacements (..., N, 3)."""
        return siren(positions, self.weights(latents), self.size.frequency, self.precision)


class Affine(nn.Module):
    """An affine layer, initialised after Kaiming; with count, that many side by side on inputs (count or 1, B, in)."""

    def __init__(self, inputs, outputs, generator, count=None, scale=1.0):
        super().__init__()
        leading = () if count is None else (count,)
        weight = torch.empty(*leading, outputs, inputs).normal_(0, scale * sqrt(2 / inputs), generator=generator)
        self.weight, self.bias = nn.Parameter(weight), nn.Parameter(torch.zeros(*leading, outputs))

    def forward(self, x):
        """(..., in) to (..., out)."""
        return _affine(x, self.weight, self.bias)


def siren_start(size, generator):
    """The initial weights and biases of a SIREN (Sitzmann et al. 2020, section 3.2)."""
    for k, shape in enumerate(size.shapes()):
        inputs = size.shapes()[k - k % 2][1]
        bound = 1 / inputs if k == 0 else 1 / sqrt(inputs) if k % 2 else sqrt(6 / inputs) / size.frequency
        yield torch.empty(shape).uniform_(-bound, bound, generator=generator)


def _affine(x, weight, bias):
    return x @ weight.mT + bias.unsqueeze(-2)


class Frame:
    """The network's coordinates: template points centred and scaled into [-1, 1].

    points: (V, 3) metres, the template with its lips apart, because the network tells points apart by position alone.
    """

    def __init__(self, points):
        low, high = points.min(0), points.max(0)
        self.points, self.centre, self.scale = points, (low + high) / 2, 2 / float((high - low).max())

    def normalise(self, points):
        """Metres to [-1, 1]."""
        return (points - self.centre) * self.scale


class DeformableModel:
    """vertices = points + S(points; H(latent)), a continuous function of the template's surface.

    A latent has no unit; ``prior`` knows how the training latents are spread.
    """

    kind = "deformable"

    def __init__(self, template, network, points, prior, model_id=""):
        """template: Template. network: HyperSiren. points: (V, 3) metres, see Frame. prior: Prior of the latents."""
        self.template, self.prior, self.model_id = template, prior, model_id
        self.frame, self.network = Frame(points), network.eval().requires_grad_(False)

    @classmethod
    def from_tensors(cls, template, tensors, model_id):
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        weights = {name.removeprefix("network."): t for name, t in tensors.items() if name.startswith("network.")}
        count, hidden, latent = weights["first.weight"].shape
        width, layers = weights["last.0.weight"].shape[0] // 3, count // 2 - 1
        size = NetworkSize(latent, width, layers, hidden, tensors["frequency"].item())
        points, mean, factor = (tensors[name].astype(float) for name in ("points", "prior_mean", "prior_factor"))
        if count % 2 or points.shape != template.vertices.shape or mean.shape != (latent,):
            raise ValueError(f"{count} tensors, points {points.shape}, prior {mean.shape} for latents of {latent}")
        if factor.shape != (latent, latent) or np.triu(factor, 1).any() or not (np.diag(factor) > 0).all():
            raise ValueError("its prior is not a lower triangular factor")
        network = HyperSiren(size, torch.Generator())
        own = network.state_dict()
        if own.keys() != weights.keys() or any(own[name].shape != t.shape for name, t in weights.items()):
            raise ValueError("the shapes of its weights do not fit each other")
        network.load_state_dict({name: torch.from_numpy(t.astype(np.float32)) for name, t in weights.items()})
        return cls(template, network, points, Prior(mean, factor), model_id)

    def tensors(self):
        """See ShapeModel: weights in half precision, biases whole, because they hold the SIREN of the mean face."""
        tensors = {
            "points": self.frame.points.astype(np.float64),
            "frequency": np.float32([self.network.size.frequency]),
            "prior_mean": self.prior.mean.astype(np.float32),
            "prior_factor": self.prior.factor.astype(np.float32),
        }
        for name, value in self.network.state_dict().items():
            array = value.cpu().numpy()
            tensors[f"network.{name}"] = array.astype(np.float32 if name.endswith("bias") else np.float16)
        return tensors

    def prepare(self):
        """See ShapeModel: the fits need nothing beyond what is here."""

    def decode(self, latents):
        """See ShapeModel."""
        return self.decode_at(latents, self.frame.points)

    def decode_on(self, latents, matrix):
        """See ShapeModel: the continuous function there, not between the vertices' positions (section 4.3)."""
        return self.decode_at(latents, matrix @ self.frame.points)

    def decode_at(self, latents, points):
        """Latents (..., D) and points (K, 3) of the network's template, in metres, to positions (..., K, 3)."""
        latents = np.asarray(latents)
        flat = torch.from_numpy(latents.reshape(-1, latents.shape[-1]).astype(np.float32))
        places = torch.from_numpy(self.frame.normalise(points).astype(np.float32))
        shapes = np.empty((len(flat), len(points), 3))
        for latent, shape in zip(flat, shapes, strict=True):
            weights = self.network.weights(latent)
            # Pieces that stay in the processor's cache are several times faster than all points at once.
            for start in range(0, len(points), _CHUNK):
                piece = siren(places[start : start + _CHUNK], weights, self.network.size.frequency)
                shape[start : start + _CHUNK] = piece.numpy()
        return (shapes / self.frame.scale + points).reshape(*latents.shape[:-1], -1, 3)

    def decode_points(self, latent, points):
        """See ShapeModel."""
        return self.decode_at(latent, self.frame.points[points])

    def points_jacobian(self, latent, points):
        """See ShapeModel: forward mode through hypernetwork and SIREN at the points asked for."""
        chosen = self.frame.points[points]
        places = torch.from_numpy(self.frame.normalise(chosen).astype(np.float32))
        latent = torch.from_numpy(np.asarray(latent, dtype=np.float32))
        moved, jacobian = _forward_mode(self.network, latent, places)
        jacobian = jacobian.permute(1, 2, 0).numpy().astype(np.float64)
        return moved.numpy() / self.frame.scale + chosen, jacobian / self.frame.scale

    def encode(self, vertices):
        """See ShapeModel: the auto-decoder inverted (section 3).

        Minimises ``mean_v |v(z) - t_v|^2 + ridge |whitened z|^2`` by damped Gauss-Newton steps, whose gradient is that
        of all vertices and whose matrix is estimated at some of them. Begins with the best linear guess.
        """
        shapes = vertices.reshape(-1, *vertices.shape[-2:])
        return np.array([self._encode_one(shape) for shape in shapes]).reshape(*vertices.shape[:-2], -1)

    @cached_property
    def _sample(self):
        """Ids of the vertices that stand for all."""
        return np.sort(np.random.default_rng(0).permutation(len(self.template.vertices))[:_SAMPLED])

    @cached_property
    def _linear_encoder(self):
        """Mean displacements (M,) of the sample, and the matrix (M, D) that best makes whitened latents of the rest."""
        drawn = np.random.default_rng(1).normal(size=(_DRAWN, self.network.size.latent))
        latents = torch.from_numpy(self.prior.colour(drawn).astype(np.float32))
        places = self._places()[self._sample]
        moved = torch.cat([self.network.displacements(batch, places).flatten(1) for batch in latents.split(_BATCH)])
        mean = moved.mean(0).numpy()
        rest = moved.numpy().astype(float) - mean
        moments = rest.T @ rest
        # A tenth of the mean variance as noise: what the network does is not linear.
        moments += 0.1 * np.trace(moments) / len(moments) * np.eye(len(moments))
        return mean, np.linalg.solve(moments, rest.T @ drawn)

    def _places(self):
        return torch.from_numpy(self.frame.normalise(self.frame.points).astype(np.float32))

    def _encode_one(self, vertices):
        places, sample, dimension = self._places(), self._sample, self.network.size.latent
        target = torch.from_numpy(((vertices - self.frame.points) * self.frame.scale).astype(np.float32))
        ridge = _RIDGE * float(target.square().sum(-1).mean())
        mean, encoder = self._linear_encoder
        trial = whitened = (target[sample].flatten().numpy() - mean) @ encoder
        cost, damping, gradient, system = np.inf, 1.0, None, None
        for _ in range(_ROUNDS):
            latent = torch.from_numpy(self.prior.colour(trial).astype(np.float32)).requires_grad_()
            error = (self.network.displacements(latent, places) - target).square().sum(-1).mean()
            value = float(error.detach()) + ridge * np.square(trial).sum()
            if value < cost:
                finished = value > (1 - _TOLERANCE) * cost
                whitened, cost, damping = trial, value, damping / 5
                if finished:
                    break
                error.backward()
                gradient = latent.grad.numpy() @ self.prior.factor + 2 * ridge * trial
                _, rows = _forward_mode(self.network, latent.detach(), places[sample])
                rows = rows.flatten(1).numpy().T @ self.prior.factor
                system = 2 * (rows.T @ rows / len(sample) + ridge * np.eye(dimension))
            else:
                damping *= 10
            trial = whitened - np.linalg.solve(system + damping * np.diag(np.diag(system)), gradient)
        return self.prior.colour(whitened)


@torch.no_grad()
def _forward_mode(network, latent, points):
    """Displacements (N, 3) of points (N, 3), and their derivatives (D, N, 3) by the latent (D,)."""
    frequency = network.size.frequency
    layers = network.weights(latent), _weights_derivatives(network, latent)
    x, dx = points, torch.zeros(len(latent), *points.shape)
    for k in range(0, len(layers[0]), 2):
        (weight, bias), (dweight, dbias) = (part[k : k + 2] for part in layers)
        derivative = x @ dweight.mT + dx @ weight.mT + dbias.unsqueeze(-2)
        value = _affine(x, weight, bias)
        if k == len(layers[0]) - 2:
            return value, derivative
        x, dx = torch.sin(frequency * value), frequency * torch.cos(frequency * value) * derivative


def _weights_derivatives(network, latent):
    """Derivatives (D, *shape) of the SIREN's weights and biases."""
    first = network.first(latent[None])
    dfirst = (first > 0).mT * network.first.weight
    second = network.second(torch.relu(first))
    dsecond = (second > 0).mT * (network.second.weight @ dfirst)
    shapes = network.size.shapes()
    return [(layer.weight @ dsecond[k]).mT.reshape(-1, *shapes[k]) for k, layer in enumerate(network.last)]
