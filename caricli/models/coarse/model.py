"""The coarse network as it is used: weights, and what its windows and its coefficients are."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import torch

from caricli.errors import InputError, naming, shown
from caricli.models.checks import check_schema, network_size, whole_number, window_side
from caricli.models.coarse.config import STEP, CoarseSize
from caricli.models.coarse.networks import CoarseNetwork
from caricli.models.inference import on_one_core
from caricli.models.network_model import NetworkModel
from caricli.models.network_weights import load_network
from caricli.structures.landmarks import SCHEMES
from caricli.structures.seen_people import SeenPeople

SCHEMA = "caricli.coarse/1"
LANDMARKS = max(SCHEMES)
"""Landmarks that it may be told."""

SHARE = 1.6
"""Of a window's side to that of the face in it."""

_SIDES = (64, 512)
_OUTPUTS = (16, 10**4)


class CoarseModel(NetworkModel[CoarseNetwork]):
    """Tells the coefficients of the morphable model of a face in a window."""

    kind = "coarse"

    def __init__(self, network: CoarseNetwork, size: int, basis: str, recipe: Any = None) -> None:
        """network: weights. size: of its windows, pixels. basis: ``model_id`` of the morphable model whose coefficients
        it tells. recipe: JSON value, how it was trained, or None.
        """
        super().__init__(network, recipe)
        self.size = size
        self.basis = basis

    @property
    def seen(self) -> SeenPeople | None:
        """Whom it was trained with; None where the recipe does not say. Raises InputError."""
        return SeenPeople.of_recipe(self.recipe)

    @property
    def doubt(self) -> np.ndarray:
        """(D,) how far coefficients usually are from the likeliest ones of true faces, root mean squares."""
        return self.network.doubt.double().numpy()

    @on_one_core
    def read(self, windows: np.ndarray, points: np.ndarray, spreads: np.ndarray | None = None) -> np.ndarray:
        """Coefficients (B, D), pixels in those of the windows.

        windows: (B, S, S, 3) uint8, S = ``size``. points: (B, 81, 2) their pixels, NaN where unknown. spreads: (B, 81,
        2, 2) covariances of their errors, square pixels, or None.
        """
        pixels = torch.from_numpy(windows.astype(np.float32) / 255).permute(0, 3, 1, 2)
        marks = torch.from_numpy(window_marks(points, spreads, self.size))
        return self.network(pixels, marks).double().numpy()


def shares(points: np.ndarray, size: int) -> np.ndarray:
    """Landmarks (..., 2) in pixels of a window of so many as shares of its side, float32."""
    return ((points + 0.5) / size).astype(np.float32)


def window_marks(points: np.ndarray, spreads: np.ndarray | None, size: int) -> np.ndarray:
    """(..., 5) float32 what a CoarseNetwork is told of landmarks (..., 2) in pixels of a window of so many.

    spreads: (..., 2, 2) square pixels, or None.
    """
    doubts = np.full((*points.shape[:-1], 3), np.nan)
    if spreads is not None:
        doubts = np.stack([spreads[..., 0, 0], spreads[..., 1, 1], spreads[..., 0, 1]], -1) / size**2
    return np.concatenate([shares(points, size), doubts], -1).astype(np.float32)


def coarse_to_checkpoint(model: CoarseModel) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """A model as (tensors, metadata), from which ``coarse_from_checkpoint`` rebuilds it."""
    about = {"schema": SCHEMA, "network": asdict(model.network.size), "outputs": model.network.outputs}
    return model.tensors(), about | {"size": model.size, "basis": model.basis, "recipe": model.recipe}


def coarse_from_checkpoint(
    tensors: Mapping[str, np.ndarray], metadata: Mapping[str, Any], where: object
) -> CoarseModel:
    """Rebuild a CoarseModel.

    tensors, metadata: of ``coarse_to_checkpoint``, read from a file. where: its name, for messages.
    Raises InputError when something is missing or does not fit.
    """
    with naming(where):
        check_schema(metadata, SCHEMA, "coarse network")
        size = window_side(metadata.get("size"), _SIDES, STEP)
        outputs = whole_number(metadata.get("outputs"), _OUTPUTS, "number of outputs")
        basis = metadata.get("basis")
        if not isinstance(basis, str):
            raise InputError(f"expected the morphable model that it belongs to, found {shown(basis, 60)!r}")
        own = network_size(metadata.get("network"), CoarseSize)
        network = load_network(partial(CoarseNetwork, own, LANDMARKS, outputs, torch.Generator()), tensors)
        return CoarseModel(network, size, basis, metadata.get("recipe"))
