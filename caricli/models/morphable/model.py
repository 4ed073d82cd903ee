"""A linear morphable model: identity, expression and albedo in bases of their own."""

import numpy as np
import scipy.sparse as sp
from sklearn.utils.extmath import randomized_svd

from caricli.models.pca.model import PcaModel
from caricli.models.principal_components import MIN_SHARE, principal_components
from caricli.models.prior import Prior

NEUTRAL = 0
"""The number of the expression that is none, where the data show it."""
_ROUNDS = 3  # of the variances, which hardly change after the second


class MorphableModel(PcaModel):
    """vertices = mean + identity and expression bases (portrait paper, equation 1); colours likewise (equation 2).

    A latent is the identity's coefficients, then the expression's, all in standard deviations.
    """

    kind = "morphable"

    def __init__(self, template, mean, identity, expression, albedo_mean, albedo, noise, model_id=""):
        """Mean (V, 3) and bases (I, V, 3), (E, V, 3) metres; albedo (V, 3), (A, V, 3) sRGB from 0 to 1.

        noise: metres, how far a coordinate is expected from what the bases make of it.
        """
        self.template, self.mean, self.model_id = template, mean, model_id
        self.identity, self.expression, self.noise = identity, expression, noise
        self.albedo_mean, self.albedo = albedo_mean, albedo
        self.basis = np.concatenate([identity, expression])
        self.prior = Prior.standard(len(self.basis))
        flat = self.basis.reshape(len(self.basis), -1)
        # The bases overlap; without the prior a large expression and its opposite identity would share one shape.
        self._encoder = np.linalg.solve(flat @ flat.T + noise**2 * np.eye(len(flat)), flat)

    @classmethod
    def train(
        cls, template, shapes, people, shown, albedos, identity=80, expression=64, albedo=80, noise=0.012, seed=0
    ):
        """Separate who from what (see ``separate``) and take principal components of each.

        template: Template. shapes: (N, V, 3). people, shown: (N,) ints, who and which expression. albedos: (M, V, 3)
        uint8 sRGB. identity, expression, albedo: dimensions; fewer where the data have fewer. noise: as a share of the
        template's height. seed: of the randomised decompositions.
        Raises NumericsError when all shapes, or all albedos, are the same.
        """
        size = template.vertices.shape
        faces, offsets = separate(shapes.reshape(len(shapes), -1), people, shown, identity, seed)
        mean, who, _ = principal_components(faces, identity, seed)
        colour, paint, _ = principal_components(albedos.reshape(len(albedos), -1) / 255.0, albedo, seed)
        parts = (mean, who, _directions(offsets, expression, seed), colour, paint)
        mean, who, what, colour, paint = (part.astype(float).reshape(*part.shape[:-1], *size) for part in parts)
        return cls(template, mean, who, what, colour, paint, noise * template.height)

    @classmethod
    def from_tensors(cls, template, tensors, model_id):
        """Rebuild from ``tensors()``. Raises ValueError when they do not fit each other and the template."""
        dimensions = {"mean": 2, "identity": 3, "expression": 3, "albedo_mean": 2, "albedo": 3}
        values = {name: tensors[name].astype(float) for name in dimensions}
        for name, value in values.items():
            if value.ndim != dimensions[name] or value.shape[-2:] != template.vertices.shape:
                raise ValueError(f"{name} {value.shape} for {len(template.vertices)} vertices")
        noise = float(tensors["noise"])
        if noise <= 0:
            raise ValueError(f"noise {noise}")
        return cls(template, **values, noise=noise, model_id=model_id)

    def tensors(self):
        """See ShapeModel."""
        whole = {name: getattr(self, name).astype(np.float32) for name in ("mean", "albedo_mean")}
        half = {name: getattr(self, name).astype(np.float16) for name in ("identity", "expression", "albedo")}
        return whole | half | {"noise": np.array(self.noise, np.float32)}

    def encode(self, vertices):
        """See ShapeModel: the likeliest latent, ``|vertices - decode(z)|^2 / noise^2 + |z|^2`` at its smallest."""
        return super().encode(vertices)

    def parts(self, latents):
        """The identity's (..., I) and the expression's coefficients (..., E) of latents."""
        return latents[..., : len(self.identity)], latents[..., len(self.identity) :]

    def colours(self, coefficients):
        """Colours (..., V, 3) sRGB from 0 to 1 of albedo coefficients (..., A) (equation 2)."""
        return np.clip(self.albedo_mean + np.tensordot(coefficients, self.albedo, 1), 0, 1)


def separate(rows, people, shown, dimension, seed=0):
    """Divide faces into the face without its expression and the expression.

    Least squares of ``face = person + expression`` give what an expression does to everyone. What it does to one face
    alone is part of the rest that ``dimension`` components of the faces without it leave: at every number the share by
    which this rest varies more than on neutral faces.

    rows: (N, M). people, shown: (N,) ints, who and which expression; where nobody is ``NEUTRAL`` the commonest is none.
    Returns (faces (N, M), offsets (N, M), or (0, M) where all show the same), single precision; their sum is the rows.
    """
    _, people = np.unique(people, return_inverse=True)
    names, shown = np.unique(shown, return_inverse=True)
    rows = rows.astype(np.float32)
    if len(names) == 1:
        return rows, rows[:0]
    none = int(np.flatnonzero(names == NEUTRAL)[0]) if NEUTRAL in names else int(np.bincount(shown).argmax())
    effect = _effects(rows - rows.mean(0), people, shown)
    effect -= effect[none]
    faces = rows - effect[shown]
    mean, basis, _ = principal_components(faces, dimension, seed)
    rest = faces - mean
    rest -= np.linalg.solve(basis @ basis.T, basis @ rest.T).T @ basis
    calm = shown == none
    usual, moved = rest[calm].var(0), rest[~calm].var(0)
    own = rest * np.clip(1 - usual / np.maximum(moved, 1e-20), 0, 1) * ~calm[:, None]
    return faces - own, effect[shown] + own


def _effects(rows, people, shown):
    """Least squares of ``row = person + expression`` with random people. rows: centred. Returns (E, M) float32.

    A person weighs ``n / (n + ratio)`` for n rows, where the ratio is that of the variances within and between people.
    """
    person, expression = _indicators(people), _indicators(shown)
    together, counts = (expression.T @ person).toarray(), person.sum(0)
    sums, ratio = (expression.T @ rows, person.T @ rows), 1.0
    spare = len(rows) - together.shape[0] - together.shape[1]
    for _ in range(_ROUNDS):
        # The people are eliminated: what is left has as many unknowns as expressions.
        share = together / (counts + ratio)
        system = np.diag(expression.sum(0)) - share @ together.T
        effect = np.linalg.solve(system, sums[0] - share @ sums[1]).astype(np.float32)
        if spare <= 0:
            break
        mean = (sums[1] - together.T @ effect) / counts[:, None]
        within = ((rows - effect[shown] - mean[people]) ** 2).sum() / spare
        between = np.average((mean**2).sum(1), weights=counts) - within * len(counts) / len(rows)
        ratio = float(np.clip(within / max(between, 1e-30), 1e-4, 1e2))
    return effect


def _indicators(groups):
    """(N, G): one where a row belongs to a group."""
    return sp.csr_array((np.ones(len(groups), np.float32), (np.arange(len(groups)), groups)))


def _directions(offsets, dimension, seed):
    """Principal directions (E, M) of offsets (N, M) from zero, each one standard deviation long."""
    if not offsets.any():
        return offsets[:0]
    _, sizes, directions = randomized_svd(offsets, min(dimension, *offsets.shape), n_iter=7, random_state=seed)
    kept = sizes**2 > MIN_SHARE * (sizes**2).sum()
    return (sizes[:, None] * directions / np.sqrt(len(offsets)))[kept]
