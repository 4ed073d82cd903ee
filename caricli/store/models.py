"""Models by name or path: those that come with caricli, and users' own."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from caricli.errors import InputError, shown
from caricli.io.bundled import asset_path
from caricli.io.checkpoint import read_checkpoint
from caricli.io.strict_json import read_json
from caricli.models.checkpoint import model_from_checkpoint, own_tensors
from caricli.models.kinds import KINDS
from caricli.models.model_id import model_id
from caricli.models.shape_model import ShapeModel
from caricli.template.layout import bundled_layout
from caricli.template.template import Template

if TYPE_CHECKING:
    from caricli.models.morphable.model import MorphableModel

DEFAULT_ELASTIC = "intrinsic"
"""Kind of the bundled model that follows landmarks elastically."""

DEFAULT_LATENT = "kernel"
"""Kind of the bundled model that latents belong to where nothing else is said."""


def load_model(name: str | Path | None = None, kind: str = DEFAULT_ELASTIC) -> ShapeModel:
    """Load a model.

    name: path of a file, or the kind of a model that comes with caricli; None for the bundled one of ``kind``.
    Raises InputError when it is no model, or damaged.
    """
    path = model_path(kind if name is None else name)
    tensors, metadata = read_checkpoint(path)
    if _is_bundled(path, tensors, metadata):
        # What is bundled is of the bundled head and lies in its picture as this does, whatever it was trained on.
        tensors |= {f"template.{part}": value for part, value in bundled_layout().items()}
    return model_from_checkpoint(tensors, metadata, shown(path))


def _is_bundled(path: Path, tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any]) -> bool:
    """Whether a checkpoint is a model that comes with caricli, or a copy of one."""
    if path.resolve().parent == asset_path("").resolve():
        return True
    kind = metadata.get("kind")
    polygons = tensors.get("template.polygons")
    if polygons is None or polygons.shape != bundled_layout()["uv_polygons"].shape:
        return False
    return isinstance(kind, str) and bundled_kind(model_id(kind, own_tensors(tensors))) == kind


def model_path(name: str | Path) -> Path:
    """The file of a model: a path, or the kind of one that comes with caricli; a file of that name goes first.

    Raises InputError for a plain name that is neither.
    """
    path = Path(name)
    if path.exists() or path.name != str(name) or path.suffix:
        return path
    bundled = {kind: asset_path(f"{kind}.safetensors") for kind in KINDS}
    kinds = sorted(kind for kind, file in bundled.items() if file.is_file())
    if str(name) not in kinds:
        raise InputError(f"{shown(name)}: expected a model file or one of {', '.join(kinds)}, found neither")
    return bundled[str(name)]


def load_morphable(path: Path | None = None) -> "MorphableModel":
    """Load the morphable model of a file, or the bundled one. Raises InputError when it is of another kind."""
    from caricli.models.morphable.model import MorphableModel

    model = load_model(path, MorphableModel.kind)
    if not isinstance(model, MorphableModel):
        raise InputError(f"{shown(path)}: expected a model of kind {MorphableModel.kind}, found {model.kind}")
    return model


def model_name(model_id: str | None) -> str:
    """What a message calls the model of an id."""
    kind = bundled_kind(model_id)
    return f"the bundled {kind} model" if kind else f"the model {shown(model_id, 12)}"


def bundled_kind(model_id: str | None) -> str | None:
    """The kind of the bundled model that has an id, or None."""
    reports = {kind: asset_path(f"{kind}.json") for kind in KINDS}
    for kind, report in reports.items():
        if report.is_file() and read_json(report).get("model_id") == model_id:
            return kind
    return None


def check_topology(template: Template, dataset_template: Template, where: object) -> None:
    """Refuse a model and a dataset of different meshes. where: what the model is called."""
    if template.topology_id != dataset_template.topology_id:
        expected = f"the dataset's topology ({len(dataset_template.vertices)} vertices)"
        raise InputError(f"{where}: expected {expected}, found another ({len(template.vertices)} vertices)")
