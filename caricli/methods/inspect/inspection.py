"""What is said of a file."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from caricli.errors import shown
from caricli.methods.inspect.check_mesh import MeshCheck, check_mesh
from caricli.structures import Material, Mesh, Rig
from caricli.structures.track import Clip


@dataclass(frozen=True)
class Inspection:
    """What a file holds.

    kind: what it is, such as "face".
    summary: the most important numbers, for the first line.
    lines: what else there is to say to people.
    values: the same for programs, as JSON holds it.
    problems: what is not whole, in words.
    """

    kind: str
    summary: str
    lines: tuple[str, ...] = ()
    values: dict[str, Any] = field(default_factory=dict)
    problems: tuple[str, ...] = ()

    def text(self, name: str, beside: list[str]) -> str:
        """All of it in lines for people. name: of the file. beside: names of the files of the same stem."""
        lines = [f"{name}: {self.kind}, {self.summary}", *self.lines]
        if beside:
            lines.append(f"beside it: {', '.join(beside)}")
        lines.append(f"not whole: {', '.join(self.problems)}" if self.problems else "whole")
        # Names are anybody's.
        return "\n".join(map(shown, lines))

    def report(self, name: str, beside: list[str]) -> dict[str, Any]:
        """All of it for programs."""
        whole = {"whole": not self.problems, "problems": list(self.problems)}
        return {"file": name, "kind": self.kind} | self.values | whole | {"beside": beside}


@dataclass(frozen=True, eq=False)
class Animated:
    """A Rig or Mesh that moves. clips: Clips of its animations."""

    still: Rig | Mesh
    clips: tuple[Clip, ...]


@dataclass(frozen=True)
class FolderPart:
    """Arrays that belong to a folder.

    folder: what it holds, such as "pictures". count: how many there are in this file, of what ``counted`` says. arrays:
    their names.
    """

    folder: str
    count: int
    counted: str
    arrays: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Acquaintances:
    """What files can refer to.

    head: Mesh of the bundled models.
    models: kinds of the bundled models by id.
    """

    head: Mesh
    models: dict[str, str]

    def model_name(self, model_id: str) -> str:
        """What a model of an id is called."""
        return f"the bundled {self.models[model_id]} model" if model_id in self.models else f"model {model_id[:12]}"


@dataclass(frozen=True)
class MeshWords:
    """A mesh in words and numbers.

    check: MeshCheck.
    same: whether it has the topology of the bundled models.
    """

    check: MeshCheck
    same: bool

    @classmethod
    def of(cls, mesh: Mesh, around: Acquaintances) -> "MeshWords":
        """Check a mesh."""
        return cls(check_mesh(mesh, around.head), mesh.topology_id == around.head.topology_id)

    @classmethod
    def of_skin(cls, rig: Rig, around: Acquaintances) -> "MeshWords":
        """Check the mesh of a rig; its topology is that of the skin, wherever in the file this comes."""
        faces = rig.faces[rig.triangle_materials == Material.SKIN]
        if not len(faces) or len(faces) == len(rig.faces):
            return cls.of(rig.mesh, around)
        used, numbers = np.unique(faces, return_inverse=True)
        whole = check_mesh(rig.mesh)
        if not np.array_equal(numbers.reshape(-1, 3), around.head.faces):
            return cls(whole, False)
        skin = check_mesh(around.head.with_vertices(rig.neutral[used]), around.head)
        return cls(replace(whole, flipped=skin.flipped), True)

    @property
    def counts(self) -> str:
        """Numbers of vertices, polygons and triangles."""
        check = self.check
        polygons = "" if check.polygons == check.triangles else f"{check.polygons} polygons, "
        return f"{check.vertices} vertices, {polygons}{check.triangles} triangles"

    @property
    def height(self) -> str:
        """How high it is."""
        return f"{self.check.height:.3f} m high"

    @property
    def lines(self) -> list[str]:
        """Unit, topology, UVs, pieces."""
        check = self.check
        topology = "that of the bundled models" if self.same else "not known"
        uvs = f"{check.uvs} UVs" if check.uvs else "no UVs"
        pieces = "one piece" if check.components == 1 else f"{check.components} pieces"
        hints = [] if check.hint is None else [check.hint]
        return [*hints, f"topology: {topology}", f"{uvs}, {pieces}, {check.open_edges} open edges"]

    @property
    def values(self) -> dict[str, Any]:
        """For programs."""
        return {"mesh": vars(self.check) | {"known_topology": self.same}}
