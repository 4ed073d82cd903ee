"""A map between the landmarks of normal faces and of caricatures (expressions paper, section 3.2.1)."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError

SCHEMA = "caricli.landmark-map/1"
SCHEME, COUNT = "ibug68", 68
DOMAINS = ("normal", "caricature")
WEIGHTS = ("linear", "first", "first_bias", "second", "second_bias", "last", "last_bias")

_EYES_AND_MOUTH = (slice(36, 42), slice(42, 48), slice(48, 68))
_PLACES = np.array([-0.5, 0.5, 1j])


@dataclass(frozen=True)
class Domain:
    """mean (136,) aligned landmarks; basis (D, 136), orthogonal components times their standard deviations."""

    mean: np.ndarray
    basis: np.ndarray

    def encode(self, aligned):
        """Aligned landmarks (..., 68, 2) to codes (..., D) of variance one."""
        rows = np.asarray(aligned).reshape(*np.shape(aligned)[:-2], -1) - self.mean
        return rows @ (self.basis / np.square(self.basis).sum(1, keepdims=True)).T

    def decode(self, codes):
        """Codes (..., D) to aligned landmarks (..., 68, 2)."""
        return (codes @ self.basis + self.mean).reshape(*codes.shape[:-1], -1, 2)


@dataclass(frozen=True)
class LandmarkMap:
    """domains: Domain by DOMAINS. generators: weights by the domain that they lead to, as ``generate`` takes them."""

    domains: dict
    generators: dict

    def map_aligned(self, aligned, to):
        """Aligned landmarks (..., 68, 2) of the other domain to those of the domain ``to``."""
        codes = self.domains[other(to)].encode(aligned)
        return self.domains[to].decode(generate(self.generators[to], codes))

    def map(self, points, to):
        """Landmarks (..., 68, 2) of the other domain, in pixels, to those of ``to``: eyes and mouth keep their place.

        Raises InputError where eyes and mouth lie in one place.
        """
        aligned, scale, shift = align(points)
        return place(self.map_aligned(aligned, to), scale, shift)

    def tensors(self):
        """Arrays by name."""
        own = {f"{name}.{key}": getattr(domain, key) for name, domain in self.domains.items() for key in vars(domain)}
        own |= {f"to_{name}.{key}": value for name, net in self.generators.items() for key, value in net.items()}
        return {name: value.astype(np.float32) for name, value in own.items()}


def other(name):
    """The other one of DOMAINS."""
    return DOMAINS[1 - DOMAINS.index(name)]


def generate(weights, codes):
    """Codes (..., D) of a domain to codes of the other: a linear map and what a small network adds to it.

    weights: arrays or tensors by WEIGHTS; codes alike.
    """
    hidden = _rectified(codes @ weights["first"] + weights["first_bias"])
    hidden = _rectified(hidden @ weights["second"] + weights["second_bias"])
    return codes @ weights["linear"] + hidden @ weights["last"] + weights["last_bias"]


def _rectified(values):
    # Alike, and of the same precision, for arrays and tensors.
    return 0.2 * values + 0.8 * values * (values > 0)


def align(points):
    """Turn, scale and move landmarks so that the centres of eyes and mouth come as near as can be to a fixed place.

    points: (..., 68, 2). Returns aligned (..., 68, 2), and scale (...) and shift (...), complex, as ``place`` takes
    them. Raises InputError where eyes and mouth lie in one place.
    """
    flat = np.asarray(points, np.float64) @ [1, 1j]
    centres = np.stack([flat[..., part].mean(-1) for part in _EYES_AND_MOUTH], axis=-1)
    shift = centres.mean(-1)
    spread = centres - shift[..., None]
    size = np.square(np.abs(spread)).sum(-1)
    scale = (spread.conj() @ (_PLACES - _PLACES.mean())) / np.where(size > 0, size, 1)
    if not (np.abs(scale) * np.sqrt(size) > 1e-6).all():
        raise InputError("expected eyes and mouth of a face, found them in one place")
    return _pairs((flat - shift[..., None]) * scale[..., None] + _PLACES.mean()), scale, shift


def place(aligned, scale, shift):
    """Undo ``align``."""
    flat = (np.asarray(aligned) @ [1, 1j] - _PLACES.mean()) / scale[..., None] + shift[..., None]
    return _pairs(flat)


def _pairs(flat):
    return np.stack([flat.real, flat.imag], axis=-1)


def map_to_checkpoint(landmark_map, recipe):
    """A map as (tensors, metadata). recipe: JSON value, how it was trained."""
    return landmark_map.tensors(), {"schema": SCHEMA, "scheme": SCHEME, "recipe": recipe}


def map_from_checkpoint(tensors, metadata, where):
    """Rebuild a LandmarkMap.

    tensors, metadata: of ``map_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when it is something else, of another scheme, or something is missing or does not fit.
    """
    if metadata.get("schema") != SCHEMA:
        raise InputError(f"{where}: expected a map of schema {SCHEMA!r}, found {str(metadata.get('schema'))[:60]!r}")
    if metadata.get("scheme") != SCHEME:
        found = str(metadata.get("scheme"))[:60]
        raise InputError(f"{where}: expected a map of the landmark scheme {SCHEME!r}, found {found!r}")
    expected = _shapes(tensors)
    for name, shape in expected.items():
        found = tensors[name].shape if name in tensors else "none"
        if found != shape:
            raise InputError(f"{where}: {name}: expected the shape {shape}, found {found}")
        if tensors[name].dtype.kind != "f":
            raise InputError(f"{where}: {name}: expected floating point, found {tensors[name].dtype}")
    own = {name: value.astype(np.float64) for name, value in tensors.items()}
    domains = {name: Domain(own[f"{name}.mean"], own[f"{name}.basis"]) for name in DOMAINS}
    if any((np.square(domain.basis).sum(1) == 0).any() for domain in domains.values()):
        raise InputError(f"{where}: expected principal components, found one of length zero")
    return LandmarkMap(domains, {name: {key: own[f"to_{name}.{key}"] for key in WEIGHTS} for name in DOMAINS})


def _shapes(tensors):
    """What shape every tensor of a map has, with the sizes that its tensors claim."""
    sizes = {name: (*np.shape(tensors.get(f"{name}.basis")), 0)[0] for name in DOMAINS}
    expected = {f"{name}.mean": (2 * COUNT,) for name in DOMAINS}
    expected |= {f"{name}.basis": (sizes[name], 2 * COUNT) for name in DOMAINS}
    for name in DOMAINS:
        width, start, end = (*np.shape(tensors.get(f"to_{name}.first_bias")), 0)[0], sizes[other(name)], sizes[name]
        shapes = (start, end), (start, width), (width,), (width, width), (width,), (width, end), (end,)
        expected |= {f"to_{name}.{key}": shape for key, shape in zip(WEIGHTS, shapes, strict=True)}
    return expected
