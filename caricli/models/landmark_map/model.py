"""A map between the landmarks of normal faces and of caricatures (expressions paper, section 3.2.1)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from caricli.errors import InputError, naming, shown
from caricli.structures import SeenPeople
from caricli.structures.landmarks import COUNT, EYE_LEFT, EYE_RIGHT, MOUTH, SCHEMES

SCHEMA = "caricli.landmark-map/2"
DOMAINS = ("normal", "caricature")

_SCHEME = SCHEMES[COUNT]
_EYES_AND_MOUTH = tuple(slice(part.start, part.stop) for part in (EYE_RIGHT, EYE_LEFT, MOUTH))

_PLACES = np.array([-0.5, 0.5, 1j])
"""Where the centres of the eyes and of the mouth go, x + 1j y; y down."""

_SMALLEST = 1e-6
"""Least size of eyes and mouth together, in units of their places: below it a face has no direction."""


@dataclass(frozen=True, eq=False)
class LandmarkMap:
    """What caricatures add to normal faces, as a distribution.

    A caricature c is taken for a normal face n with something added that has nothing to do with who it is,
    ``c = n + shift + e``, both Gaussian. So the normal face that goes with a caricature is the likeliest one,
    ``mean n + (c - mean c) to_normal``, and one normal face has many caricatures.

    normal, caricature: (136,) mean landmarks, aligned; their difference is the shift. to_normal: (136, 136).
    styles: (D, 136) the largest principal components of e, one standard deviation each. seen: see ShapeModel.
    """

    normal: np.ndarray
    caricature: np.ndarray
    to_normal: np.ndarray
    styles: np.ndarray
    seen: SeenPeople | None = None

    def map_aligned(self, aligned: np.ndarray, to: str, style: np.ndarray | None = None) -> np.ndarray:
        """Aligned landmarks (..., 68, 2) of the other domain to those of the domain ``to``.

        style: (..., D) of a caricature, normally distributed, or None for the likeliest.
        """
        rows = np.asarray(aligned, np.float64).reshape(*np.shape(aligned)[:-2], -1)
        if to == "normal":
            mapped = self.normal + (rows - self.caricature) @ self.to_normal
        else:
            mapped = rows + self.caricature - self.normal + (0 if style is None else style @ self.styles)
        return mapped.reshape(*mapped.shape[:-1], -1, 2)

    def map(self, points: np.ndarray, to: str, style: np.ndarray | None = None) -> np.ndarray:
        """Landmarks (..., 68, 2) of the other domain, in pixels, to those of ``to``: eyes and mouth keep their place.

        style: as ``map_aligned`` takes it. Raises InputError where eyes and mouth lie in one place.
        """
        aligned, scale, shift = align(points)
        return place(self.map_aligned(aligned, to, style), scale, shift)

    def draw_styles(self, generator: np.random.Generator, count: int) -> np.ndarray:
        """Styles (N, D) of as many caricatures, for ``map``."""
        return generator.standard_normal((count, len(self.styles)))

    def own_style(self, points: np.ndarray) -> np.ndarray:
        """The style (D,) that makes more of what is unusual about a normal face (68, 2), as strong as usual styles.

        Raises InputError where eyes and mouth lie in one place.
        """
        unusual = align(points)[0].ravel() - self.normal
        code = self.styles @ unusual / np.square(self.styles).sum(1)
        return code * len(code) ** 0.5 / max(np.linalg.norm(code), 1e-12)

    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name."""
        return {name: getattr(self, name).astype(np.float32) for name in _TENSORS}


_TENSORS = ("normal", "caricature", "to_normal", "styles")
_FIXED = ((2 * COUNT,), (2 * COUNT,), (2 * COUNT, 2 * COUNT))
"""Shapes of all but the last."""


def other(name: str) -> str:
    """The other one of DOMAINS."""
    return DOMAINS[1 - DOMAINS.index(name)]


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
        styles = tensors.get("styles", np.empty((0, 0)))
        shapes = dict(zip(_TENSORS, (*_FIXED, (np.size(styles, 0) if styles.ndim else 0, 2 * COUNT)), strict=True))
        for name, shape in shapes.items():
            _check_tensor(name, tensors.get(name), shape)
        arrays = {name: tensors[name].astype(np.float64) for name in _TENSORS}
        if not np.square(arrays["styles"]).sum(1).all():
            raise InputError("expected styles, found one that changes nothing")
        if not len(styles):
            raise InputError("expected styles, found none")
        return LandmarkMap(**arrays, seen=SeenPeople.of_recipe(metadata.get("recipe")))


def _check_tensor(name: str, tensor: np.ndarray | None, shape: tuple[int, ...]) -> None:
    if tensor is None or tensor.shape != shape:
        given = "none" if tensor is None else tensor.shape
        raise InputError(f"{name}: expected the shape {shape}, found {given}")
    if tensor.dtype.kind != "f":
        raise InputError(f"{name}: expected floating point, found {tensor.dtype}")
