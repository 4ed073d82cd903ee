"""Normal faces that drive a caricature, and the rig that is driven."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from caricli.errors import CaricliError, InputError, naming
from caricli.io.meshes.mesh import is_mesh_file
from caricli.io.rig import read_rig
from caricli.methods.expressions.retarget_rig import Driver, DrivingMesh, fit_driver
from caricli.methods.train.stages import Report, unwatched
from caricli.models.morphable.model import MorphableModel
from caricli.store.face_pictures import FaceReader
from caricli.store.faces import load_shape
from caricli.structures import Rig
from caricli.structures.detection import FacePicture


def is_driving_mesh(path: Path) -> bool:
    """Whether a file drives as a mesh, not as landmarks."""
    return path.suffix.lower() == ".npz" or is_mesh_file(path)


def load_driven_rig(path: Path, model: MorphableModel) -> Rig:
    """The Rig of a file that knows what its expressions do to the normal face of a model. Raises InputError."""
    rig = read_rig(path)
    count = len(model.mean)
    with naming(path):
        deltas = rig.require_normal_deltas()
        if deltas.shape[1] != count:
            raise InputError(f"expected normal_deltas of the model's {count} vertices, found {deltas.shape[1]}")
        if not deltas.any():
            raise InputError("expected expressions that move a normal face, found none that does")
    return rig


@dataclass(frozen=True, eq=False)
class Drivers:
    """Drivers by path, the FacePictures of those that are landmarks, and the failures of those that cannot be read.

    paths: in the order that was asked for, in which a driver may come again.
    """

    paths: Sequence[Path]
    faces: dict[Path, Driver] = field(default_factory=dict)
    sources: dict[Path, FacePicture] = field(default_factory=dict)
    failures: dict[Path, CaricliError] = field(default_factory=dict)

    @property
    def rows(self) -> list[Path]:
        """The paths whose drivers could be read, in their order."""
        return [path for path in self.paths if path in self.faces]

    def row(self, path: Path) -> int:
        """The first row of a driver. Raises the failure of one that could not be read."""
        if path in self.failures:
            raise self.failures[path]
        return self.rows.index(path)


def load_drivers(
    paths: Sequence[Path],
    model: MorphableModel,
    reader: FaceReader = FaceReader(),  # noqa: B008 (frozen)
    progress: Report = unwatched,
    whole: bool = False,
) -> Drivers:
    """The Drivers of meshes of the model's topology, or of landmarks or pictures, whose cameras are found.

    reader: FaceReader of landmarks and pictures. progress: called with how many are read, and of how many.
    whole: whether one that cannot be read ends everything.
    """
    drivers = Drivers(paths)
    distinct = dict.fromkeys(paths)
    for number, path in enumerate(distinct, 1):
        try:
            if is_driving_mesh(path):
                drivers.faces[path] = DrivingMesh(load_shape(path, model))
            else:
                count = len(model.template.annotation.landmarks)
                picture = reader.read(path, count)
                with naming(path):
                    drivers.faces[path] = fit_driver(picture.landmarks, model)
                drivers.sources[path] = picture
        except CaricliError as error:
            if whole:
                raise
            drivers.failures[path] = error
        progress(number, len(distinct))
    return drivers
