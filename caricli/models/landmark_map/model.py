"""A map between the landmarks of normal faces and of caricatures (expressions paper, section 3.2.1)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.structures import SeenPeople
from caricli.structures.landmarks import COUNT, EYE_LEFT, EYE_RIGHT, MOUTH, SCHEMES

SCHEMA = "caricli.landmark-map/1"
DOMAINS = ("normal", "caricature")
GENERATOR_WEIGHTS = ("linear", "first", "first_bias", "second", "second_bias", "last", "last_bias")
"""Names of a generator's arrays, see ``generate``."""

_SCHEME = SCHEMES[COUNT]
_EYES_AND_MOUTH = tuple(slice(part.start, part.stop) for part in (EYE_RIGHT, EYE_LEFT, MOUTH))

_SLOPE = 0.2
"""Of the generators' leaky ReLU below zero."""

_PLACES = np.array([-0.5, 0.5, 1j])
"""Where the centres of the eyes and of the mouth go, x + 1j y; y down."""

_SMALLEST = 1e-6
"""Least size of eyes and mouth together, in units of their places: below it a face has no direction."""


@dataclass(frozen=True, eq=False)
class Domain:
    """Principal components of one domain's landmarks.

    mean: (136,) aligned landmarks. basis: (D, 136), orthogonal components times their standard deviations.
    """

    mean: np.ndarray
    basis: np.ndarray

    def encode(self, aligned: np.ndarray) -> np.ndarray:
        """Aligned landmarks (..., 68, 2) to codes (..., D) of variance one."""
        rows = np.asarray(aligned).reshape(*np.shape(aligned)[:-2], -1) - self.mean
        return rows @ (self.basis / np.square(self.basis).sum(1, keepdims=True)).T

    def decode(self, codes: np.ndarray) -> np.ndarray:
        """Codes (..., D) to aligned landmarks (..., 68, 2)."""
        return (codes @ self.basis + self.mean).reshape(*codes.shape[:-1], -1, 2)


@dataclass(frozen=True, eq=False)
class LandmarkMap:
    """A map in both directions.

    domains: Domain by DOMAINS. generators: arrays by GENERATOR_WEIGHTS by the domain that they lead to. seen: see
    ShapeModel.
    """

    domains: dict[str, Domain]
    generators: dict[str, dict[str, np.ndarray]]
    seen: SeenPeople | None = None

    def map_aligned(self, aligned: np.ndarray, to: str) -> np.ndarray:
        """Aligned landmarks (..., 68, 2) of the other domain to those of the domain ``to``."""
        codes = self.domains[other(to)].encode(aligned)
        return self.domains[to].decode(generate(self.generators[to], codes))

    def map(self, points: np.ndarray, to: str) -> np.ndarray:
        """Landmarks (..., 68, 2) of the other domain, in pixels, to those of ``to``: eyes and mouth keep their place.

        Raises InputError where eyes and mouth lie in one place.
        """
        aligned, scale, shift = align(points)
        return place(self.map_aligned(aligned, to), scale, shift)

    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name."""
        own = {f"{name}.{key}": getattr(domain, key) for name, domain in self.domains.items() for key in vars(domain)}
        own |= {f"to_{name}.{key}": value for name, net in self.generators.items() for key, value in net.items()}
        return {name: value.astype(np.float32) for name, value in own.items()}


def other(name: str) -> str:
    """The other one of DOMAINS."""
    return DOMAINS[1 - DOMAINS.index(name)]


def generate(weights: Mapping[str, Any], codes: Any) -> Any:
    """Codes (..., D) of a domain to codes of the other: a linear map and what a small network adds to it.

    weights: arrays or tensors by GENERATOR_WEIGHTS; codes alike.
    """
    hidden = _rectified(codes @ weights["first"] + weights["first_bias"])
    hidden = _rectified(hidden @ weights["second"] + weights["second_bias"])
    return codes @ weights["linear"] + hidden @ weights["last"] + weights["last_bias"]


def _rectified(values: Any) -> Any:
    # Alike, and of the same precision, for arrays and tensors.
    return _SLOPE * values + (1 - _SLOPE) * values * (values > 0)


def align(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
    if not (np.abs(scale) * np.sqrt(size) > _SMALLEST).all():
        raise InputError("expected eyes and mouth of a face, found them in one place")
    return _pairs((flat - shift[..., None]) * scale[..., None] + _PLACES.mean()), scale, shift


def place(aligned: np.ndarray, scale: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Undo ``align``."""
    flat = (np.asarray(aligned) @ [1, 1j] - _PLACES.mean()) / scale[..., None] + shift[..., None]
    return _pairs(flat)


def _pairs(flat: np.ndarray) -> np.ndarray:
    return np.stack([flat.real, flat.imag], axis=-1)


def map_to_checkpoint(landmark_map: LandmarkMap, recipe: Any) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A map as (tensors, metadata). recipe: JSON value, how it was trained."""
    return landmark_map.tensors(), {"schema": SCHEMA, "scheme": _SCHEME, "recipe": recipe}


def map_from_checkpoint(tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object) -> LandmarkMap:
    """Rebuild a LandmarkMap.

    tensors, metadata: of ``map_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when it is something else, of another scheme, or something is missing or does not fit.
    """
    with naming(where):
        if metadata.get("schema") != SCHEMA:
            raise InputError(f"expected a map of schema {SCHEMA!r}, found {shown(metadata.get('schema'), 60)!r}")
        if metadata.get("scheme") != _SCHEME:
            scheme = shown(metadata.get("scheme"), 60)
            raise InputError(f"expected a map of the landmark scheme {_SCHEME!r}, found {scheme!r}")
        for name, shape in _shapes(tensors).items():
            _check_tensor(name, tensors.get(name), shape)
        arrays = {name: value.astype(np.float64) for name, value in tensors.items()}
        domains = {name: Domain(arrays[f"{name}.mean"], arrays[f"{name}.basis"]) for name in DOMAINS}
        if any((np.square(domain.basis).sum(1) == 0).any() for domain in domains.values()):
            raise InputError("expected principal components, found one of length zero")
    generators = {name: {key: arrays[f"to_{name}.{key}"] for key in GENERATOR_WEIGHTS} for name in DOMAINS}
    with naming(where):
        return LandmarkMap(domains, generators, SeenPeople.of_recipe(metadata.get("recipe")))


def _check_tensor(name: str, tensor: np.ndarray | None, shape: tuple[int, ...]) -> None:
    if tensor is None or tensor.shape != shape:
        given = "none" if tensor is None else tensor.shape
        raise InputError(f"{name}: expected the shape {shape}, found {given}")
    if tensor.dtype.kind != "f":
        raise InputError(f"{name}: expected floating point, found {tensor.dtype}")


def _shapes(tensors: Mapping[str, np.ndarray]) -> dict[str, tuple[int, ...]]:
    """What shape every tensor of a map has, with the sizes that its tensors claim."""
    sizes = {name: _claimed_size(tensors, f"{name}.basis") for name in DOMAINS}
    expected: dict[str, tuple[int, ...]] = {f"{name}.mean": (2 * COUNT,) for name in DOMAINS}
    expected |= {f"{name}.basis": (sizes[name], 2 * COUNT) for name in DOMAINS}
    for name in DOMAINS:
        width = _claimed_size(tensors, f"to_{name}.first_bias")
        shapes = generator_shapes(sizes[other(name)], width, sizes[name])
        expected |= {f"to_{name}.{key}": shape for key, shape in shapes.items()}
    return expected


def generator_shapes(start: int, width: int, end: int) -> dict[str, tuple[int, ...]]:
    """Shapes of a generator's arrays. start, end: dimensions of the codes. width: of the hidden layers."""
    return {
        "linear": (start, end),
        "first": (start, width),
        "first_bias": (width,),
        "second": (width, width),
        "second_bias": (width,),
        "last": (width, end),
        "last_bias": (end,),
    }


def _claimed_size(tensors: Mapping[str, np.ndarray], name: str) -> int:
    """First length of a tensor, 0 where there is none."""
    tensor = tensors.get(name)
    return 0 if tensor is None or tensor.ndim == 0 else len(tensor)
