"""The coarse network that comes with caricli, and users' own."""

from pathlib import Path

from caricli.errors import InputError, shown
from caricli.models.coarse.model import CoarseModel, coarse_from_checkpoint
from caricli.models.morphable.model import MorphableModel
from caricli.store.bundled import load_bundled
from caricli.store.models import load_morphable

BUNDLED = "coarse.safetensors"


def load_coarse(path: Path | None = None) -> CoarseModel:
    """Load the coarse network of a file, or the bundled one.

    Raises InputError when it is none, damaged, or not there.
    """
    return load_bundled(BUNDLED, coarse_from_checkpoint, path)


def load_coarse_pair(path: Path | None = None, model: Path | None = None) -> tuple[CoarseModel, MorphableModel]:
    """Load a coarse network, or the bundled one, and the morphable model that it was trained for.

    model: file of the latter, or None for the bundled one. Raises InputError where they do not belong together.
    """
    network = load_coarse(path)
    morphable = load_morphable(model)
    if network.basis != morphable.model_id:
        raise InputError(
            f"{shown(path or BUNDLED)}: expected a network for the morphable model {shown(morphable.model_id, 12)}, "
            f"found one for {shown(network.basis, 12)}; --model takes the model that it was trained for"
        )
    return network, morphable
