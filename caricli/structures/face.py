"""One face."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from caricli.errors import InputError
from caricli.structures.camera import Camera
from caricli.structures.checks import refuse, shape_problem
from caricli.structures.landmarks import fitted_problem
from caricli.structures.materials import material_problem
from caricli.structures.mesh import Mesh
from caricli.structures.parts import Hair
from caricli.structures.pictures import Pictures

FEATURES = 9
"""Deformation-gradient features of a vertex: rotation vector (3), symmetric stretch minus one (6)."""


@dataclass(frozen=True, eq=False)
class Face:
    """A mesh, the camera of its picture, and what a shape model says of it. What is None is not known.

    mesh: Mesh, in the face's own frame, never posed.
    camera: Camera of the picture that the face was fitted to.
    landmarks: (68, 2) or (81, 2) pixels, where the fit left its landmarks in the picture; edits leave them there.
    latent: (D,), whatever its model means.
    residual: (V, 9) deformation-gradient features beyond those of the latent.
    model_id: SHA-256 of the model that the latent belongs to.
    pictures: Pictures that it wears, none unless it is painted; they lie on the UVs of the mesh.
    materials: (P,) int32, a Material for every polygon; all skin where there are none.
    hair: Hair that stands on the mesh.
    teeth: (2,) metres, how far its picture shows upper teeth below the rim of the upper lip, and lower ones above that
    of the lower lip; 0 where it shows none.
    Raises InputError when an array has another shape or holds what is not finite or beyond the caps.
    """

    mesh: Mesh
    camera: Camera | None = None
    landmarks: np.ndarray | None = None
    latent: np.ndarray | None = None
    residual: np.ndarray | None = None
    model_id: str | None = None
    pictures: Pictures = Pictures()  # noqa: RUF009 (frozen)
    materials: np.ndarray | None = None
    hair: Hair | None = None
    teeth: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check that the parts fit each other."""
        shapes = {"latent": (None,), "residual": (len(self.mesh.vertices), FEATURES)}
        for key, shape in shapes.items():
            value = getattr(self, key)
            if value is not None:
                refuse(shape_problem(key, np.asarray(value), shape))
        if self.landmarks is not None:
            refuse(fitted_problem(np.asarray(self.landmarks)))
        if self.teeth is not None:
            refuse(shape_problem("teeth", np.asarray(self.teeth), (2,)))
            if np.min(self.teeth) < 0:
                refuse(f"teeth: expected lengths, found {np.min(self.teeth)}")
        refuse(material_problem(self.materials, len(self.mesh.polygons)))
        if self.pictures and self.mesh.uvs is None:
            refuse("uvs: expected them on a face with pictures, found none")
        if self.hair is not None and np.max(self.hair.roots) >= len(self.mesh.vertices):
            refuse(f"hair_roots: expected vertices below {len(self.mesh.vertices)}, found {np.max(self.hair.roots)}")

    def with_vertices(self, vertices: np.ndarray) -> Self:
        """The same face in another shape, (V, 3) metres, with all else that it has; its hair goes along."""
        hair = None if self.hair is None else self.hair.moved(self.vertices, vertices)
        return replace(self, mesh=self.mesh.with_vertices(vertices), hair=hair)

    def posed(self, vertices: np.ndarray) -> "Face":
        """The same face in another shape, (V, 3) metres, of which no picture or model knows."""
        bare = Face(self.mesh, pictures=self.pictures, materials=self.materials, hair=self.hair)
        return bare.with_vertices(vertices)

    def wearing(self, other: "Face") -> "Face":
        """The same face in the polygons, pictures, hair and teeth of another of its topology."""
        worn = other.posed(self.vertices)
        dressed = replace(self, mesh=worn.mesh, pictures=worn.pictures, materials=worn.materials, hair=worn.hair)
        return replace(dressed, teeth=other.teeth)

    def without_latent(self) -> "Face":
        """The same face without what a model says of it."""
        return replace(self, latent=None, residual=None, model_id=None)

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) of the mesh."""
        return self.mesh.vertices

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) of the mesh."""
        return self.mesh.faces

    @property
    def triangle_materials(self) -> np.ndarray | None:
        """(F,) int: the Material of every triangle, or None where all are skin."""
        return None if self.materials is None else np.repeat(self.materials, self.mesh.triangles_of_polygons)

    def require_latent(self) -> np.ndarray:
        """(D,) the latent. Raises InputError for a face without one."""
        if self.latent is None:
            raise InputError("expected a face with a latent, found none; make one with caricli encode")
        return self.latent

    def require_camera(self) -> Camera:
        """The camera. Raises InputError for a face without one."""
        if self.camera is None:
            raise InputError(
                "expected a face with the camera of its picture, found none; make one with caricli "
                "reconstruct-from-landmarks and give its NPZ"
            )
        return self.camera

    def require_landmarks(self) -> np.ndarray:
        """(L, 2) the landmarks. Raises InputError for a face without any."""
        if self.landmarks is None:
            raise InputError(
                "expected a face with fitted landmarks, found none; make one with caricli reconstruct-from-landmarks"
            )
        return self.landmarks
