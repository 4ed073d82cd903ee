"""Pieces of a head beside its skin."""

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from caricli.structures.checks import coordinate_problem, refuse, shape_problem
from caricli.structures.materials import Material, material_problem
from caricli.structures.mesh import Mesh

Hold = Literal["skull", "jaw", "lids", "scalp", "neck"]
"""What a part may hang on."""


@dataclass(frozen=True, eq=False)
class Part:
    """One piece of a head beside its skin, such as a row of teeth, and what it hangs on.

    name: in files. mesh: Mesh of W vertices, metres, in the frame of the head, with UVs.
    materials: (P,) int32, a Material for every polygon. hangs_on: what it moves with.
    names: (K,) of expressions. deltas: (K, W, 3) metres, what they do to it, its bond included.
    Raises InputError when they do not fit each other or hold what is not finite.
    """

    name: str
    mesh: Mesh
    materials: np.ndarray
    hangs_on: Hold
    names: tuple[str, ...]
    deltas: np.ndarray

    def __post_init__(self) -> None:
        """Check that all fits."""
        if self.hangs_on not in get_args(Hold):
            refuse(f"{self.name}: expected it to hang on {', '.join(get_args(Hold))}, found {self.hangs_on!r}")
        expected = (len(self.names), *self.mesh.vertices.shape)
        deltas = np.asarray(self.deltas)
        if deltas.shape != expected:
            refuse(f"{self.name}: expected deltas of the shape {expected}, found {deltas.shape}")
        refuse(coordinate_problem(self.name, deltas), material_problem(self.materials, len(self.mesh.polygons)))

    def placed(self, vertices: np.ndarray, deltas: np.ndarray) -> "Part":
        """The same part in another place (W, 3), moved by the same expressions in another way (K, W, 3)."""
        return replace(self, mesh=self.mesh.with_vertices(vertices), deltas=deltas)


@dataclass(frozen=True, eq=False)
class Hair:
    """A shell of hair that stands on the skin of one face, whatever becomes of this.

    shell: Mesh of H vertices with UVs, metres, in the frame of the face.
    roots: (H, 3) int32, vertices of the skin. weights: (H, 3), of the roots; rows sum to one.
    Raises InputError when they do not fit each other.
    """

    shell: Mesh
    roots: np.ndarray
    weights: np.ndarray

    def __post_init__(self) -> None:
        """Check that all fits."""
        expected = (len(self.shell.vertices), 3)
        roots = np.asarray(self.roots)
        if roots.shape != expected or roots.dtype.kind not in "iu" or roots.min() < 0:
            refuse(f"hair_roots: expected {expected} vertices, found {roots.shape} {roots.dtype}")
        weights = np.asarray(self.weights)
        refuse(shape_problem("hair_weights", weights, expected))
        if self.shell.uvs is None:
            refuse("hair_uvs: expected a place in a picture for the hair, found none")

    def footing(self, vertices: np.ndarray) -> np.ndarray:
        """(H, 3) where hair stands on a skin (V, 3), metres."""
        return np.einsum("hk,hkc->hc", self.weights, vertices[self.roots])

    @property
    def part(self) -> Part:
        """The hair as a Part, which no expression moves."""
        materials = np.full(len(self.shell.polygons), Material.HAIR, np.int32)
        return Part("hair", self.shell, materials, "scalp", (), np.zeros((0, *self.shell.vertices.shape)))

    def moved(self, before: np.ndarray, after: np.ndarray) -> "Hair":
        """The hair of a skin (V, 3) on the same skin in another shape (V, 3)."""
        shift = self.footing(after) - self.footing(before)
        return replace(self, shell=self.shell.with_vertices(self.shell.vertices + shift))
