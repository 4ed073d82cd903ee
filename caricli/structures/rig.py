"""A face with named expressions."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError, shown
from caricli.limits import MAX_MOODS, MAX_SHAPES
from caricli.structures.arkit import ARKIT_NAMES, start_delta
from caricli.structures.change_atlas import ChangeAtlas
from caricli.structures.checks import coordinate_problem, number_problem, refuse
from caricli.structures.depiction import Depiction
from caricli.structures.face import Face
from caricli.structures.materials import Material, material_problem
from caricli.structures.mesh import Mesh
from caricli.structures.pictures import Mood, Pictures


@dataclass(frozen=True, eq=False)
class Rig:
    """A face with named expressions: ``mesh + sum_k weight_k deltas_k`` (portrait paper, equation 13).

    names: (K,), distinct; none for a head that keeps still.
    mesh: Mesh of the neutral face, float32.
    deltas: (K, V, 3) float32, metres.
    materials: (P,) int32, a Material for every polygon; all skin where there are none.
    pictures: Pictures that it wears, on the UVs of the mesh.
    normal_deltas: (K, N, 3) float32, metres, what the same expressions do to a normal face of N vertices (expressions
    paper, equation 19); or None.
    moods: pictures of the skin in expressions, by distinct names, as large as that of the pictures.
    depiction: Depiction of it in the picture that it was fitted to, or None.
    actions: (K, 52) float32, weights of ARKit's actions that the expressions are made of, or None.
    changes: ChangeAtlas of what the expressions do to the picture of the skin, or None.
    Raises InputError when the parts do not fit each other or hold what is not finite.
    """

    names: tuple[str, ...]
    mesh: Mesh
    deltas: np.ndarray
    materials: np.ndarray | None = None
    pictures: Pictures = Pictures()  # noqa: RUF009 (frozen)
    normal_deltas: np.ndarray | None = None
    moods: tuple[Mood, ...] = ()
    depiction: Depiction | None = None
    actions: np.ndarray | None = None
    changes: ChangeAtlas | None = None

    def __post_init__(self) -> None:
        """Check that the parts fit each other."""
        names = self.names
        sound = isinstance(names, tuple) and all(isinstance(name, str) and name for name in names)
        if not sound or len(names) > MAX_SHAPES or len(set(names)) < len(names):
            refuse(f"names: expected at most {MAX_SHAPES} distinct names, found {shown(names, 60)}")
        refuse(self._delta_problem(), material_problem(self.materials, len(self.mesh.polygons)), self._mood_problem())
        if self.depiction is not None and np.shape(self.depiction.vertices) != self.neutral.shape:
            refuse(f"depicted: expected {self.neutral.shape} as neutral, found {np.shape(self.depiction.vertices)}")
        if self.actions is not None and np.shape(self.actions) != (len(names), len(ARKIT_NAMES)):
            refuse(f"actions: expected {(len(names), len(ARKIT_NAMES))}, found {np.shape(self.actions)}")
        refuse(None if self.actions is None else number_problem("actions", np.asarray(self.actions)))
        if self.changes is not None and self.changes.count < 2 * len(names) + 2:
            refuse(f"changes: expected {2 * len(names) + 2} tiles, found room for {self.changes.count}")

    @property
    def neutral(self) -> np.ndarray:
        """(V, 3) vertices of the neutral face."""
        return self.mesh.vertices

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) triangles of the mesh."""
        return self.mesh.faces

    @property
    def triangle_materials(self) -> np.ndarray:
        """(F,) int: the Material of every triangle."""
        if self.materials is None:
            return np.full(len(self.mesh.faces), Material.SKIN)
        return np.repeat(self.materials, self.mesh.triangles_of_polygons)

    @property
    def face(self) -> Face:
        """The neutral Face in what the rig wears; pictures that have no UVs to lie on are left out."""
        pictures = Pictures() if self.mesh.uvs is None else self.pictures
        return Face(self.mesh, pictures=pictures, materials=self.materials)

    def shape(self, name: str) -> np.ndarray:
        """(V, 3) vertices with one expression at full weight. Raises InputError when it has another name."""
        if name not in self.names:
            raise InputError(f"expected one of the rig's {len(self.names)} expressions, found {shown(name, 60)!r}")
        return self.neutral + self.deltas[self.names.index(name)]

    def require_normal_deltas(self) -> np.ndarray:
        """(K, N, 3) what the expressions do to a normal face. Raises InputError for a rig that does not say."""
        if self.normal_deltas is None:
            raise InputError(
                "expected a rig that says what its expressions do to a normal face, found none; "
                "caricli blendshapes writes one"
            )
        return self.normal_deltas

    def require_depiction(self) -> Depiction:
        """How its picture shows it. Raises InputError for a rig without the camera of its picture."""
        if self.depiction is None:
            raise InputError(
                "expected a rig with the camera of its picture, found none; make it with caricli blendshapes, from a "
                "face NPZ that has one or from the picture"
            )
        return self.depiction

    def shape_in_use(self, k: int) -> np.ndarray:
        """(V, 3) vertices with expression k at full weight, on top of the expression that it is meant for."""
        return self.neutral + start_delta(self.names, self.deltas, k) + self.deltas[k]

    def _mood_problem(self) -> str | None:
        names = [mood.name for mood in self.moods]
        if len(names) > MAX_MOODS or len(set(names)) < len(names):
            return f"moods: expected at most {MAX_MOODS} of distinct names, found {shown(names, 60)}"
        usual = self.pictures.skin
        if usual is None:
            return "moods: expected a picture of the skin beside them, found none" if self.moods else None
        others = [mood.skin.shape for mood in self.moods if mood.skin.shape != usual.shape]
        return f"moods: expected pictures of the skin's shape {usual.shape}, found {others[0]}" if others else None

    def _delta_problem(self) -> str | None:
        deltas = np.asarray(self.deltas)
        expected = (len(self.names), *self.neutral.shape)
        if deltas.shape != expected:
            return f"deltas: expected the shape {expected}, found {deltas.shape}"
        if self.normal_deltas is None:
            return coordinate_problem("deltas", deltas)
        normal = np.asarray(self.normal_deltas)
        if normal.ndim != 3 or (len(normal), normal.shape[2]) != (len(self.names), 3):
            return f"normal_deltas: expected {len(self.names)} displacements of a face, found {normal.shape}"
        return coordinate_problem("deltas", deltas) or coordinate_problem("normal_deltas", normal)
