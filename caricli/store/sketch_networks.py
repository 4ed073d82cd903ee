"""The network that sees faces in sketches, as it comes with caricli, and users' own."""

from collections.abc import Sequence
from pathlib import Path

from caricli.errors import InputError, shown
from caricli.models.bilinear.model import BilinearModel
from caricli.models.linear_model import LinearModel
from caricli.models.shape_model import ShapeModel
from caricli.models.sketch.model import SketchModel, sketch_from_checkpoint
from caricli.store.bundled import load_bundled
from caricli.store.models import load_model

BUNDLED = "sketch.safetensors"

BASIS = "pca"
"""Kind of the bundled model whose latents the bundled network tells."""


def load_sketch_network(path: Path | None = None) -> SketchModel:
    """Load the sketch network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    return load_bundled(BUNDLED, sketch_from_checkpoint, path)


def load_sketch_basis(path: str | Path | None = None) -> LinearModel:
    """Load a linear model whose latents networks can tell: a file or kind, or None for the bundled one.

    Raises InputError when it is of another kind.
    """
    model = load_model(path, BASIS)
    if not isinstance(model, LinearModel):
        raise InputError(f"{shown(path)}: expected a linear model, as of `caricli train pca`, found {model.kind}")
    return model


def load_bilinear(path: str | Path | None) -> BilinearModel:
    """Load the bilinear model whose u and v published networks tell. Raises InputError when it is of another kind."""
    if path is None:
        raise InputError("expected a bilinear model for this variant, as of `caricli train bilinear`, found no --model")
    model = load_model(path)
    if not isinstance(model, BilinearModel):
        raise InputError(f"{shown(path)}: expected a model of `caricli train bilinear`, found one of kind {model.kind}")
    return model


def load_sketch_pair(path: Path | None = None, basis: Path | None = None) -> tuple[SketchModel, ShapeModel]:
    """Load a sketch network, or the bundled one, and the shape model whose latents it tells.

    basis: file or kind of the latter, or None for the bundled one. Raises InputError where they do not belong together.
    """
    network = load_sketch_network(path)
    model = load_model(basis, BASIS)
    if network.basis != model.model_id:
        raise InputError(
            f"{shown(path or BUNDLED)}: expected a network for the shape model {shown(model.model_id, 12)}, found one "
            f"for {shown(network.basis, 12)}"
        )
    return network, model


def load_sketch_networks(paths: Sequence[Path], models: Sequence[Path]) -> list[tuple[SketchModel, ShapeModel]]:
    """Load sketch networks, or the bundled one where no paths are given, each with the model whose latents it tells.

    models: files or kinds of models, among which, or the bundled one, everyone's must be. Raises InputError where it is
    not.
    """
    loaded = [load_model(path, BASIS) for path in (*models, None)]
    by_id = {model.model_id: model for model in loaded}
    pairs = []
    for path in paths or (None,):
        network = load_sketch_network(path)
        if network.basis not in by_id:
            raise InputError(
                f"{shown(path or BUNDLED)}: expected --model with the shape model {shown(network.basis, 12)}, found "
                + ", ".join(shown(name, 12) for name in by_id)
            )
        pairs.append((network, by_id[network.basis]))
    return pairs
