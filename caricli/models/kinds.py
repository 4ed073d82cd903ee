"""The kinds of shape models: what their classes are called, imported only when they are asked for."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class Kind:
    """Where the classes of a kind are.

    model, config: module and name, as in "caricli.models.pca.model:PcaModel".
    """

    model: str
    config: str


KINDS = {
    "pca": Kind("caricli.models.pca.model:PcaModel", "caricli.models.pca.config:PcaConfig"),
    "intrinsic": Kind(
        "caricli.models.intrinsic.model:IntrinsicModel", "caricli.models.intrinsic.config:IntrinsicConfig"
    ),
    "kernel": Kind("caricli.models.kernel.model:KernelModel", "caricli.models.kernel.config:KernelConfig"),
    "deformable": Kind(
        "caricli.models.deformable.model:DeformableModel", "caricli.models.deformable.config:DeformableConfig"
    ),
    "morphable": Kind(
        "caricli.models.morphable.model:MorphableModel", "caricli.models.morphable.config:MorphableConfig"
    ),
}
"""Kinds by the names that checkpoints carry."""


def model_class(kind: str) -> Any:
    """The ShapeModel class of one of KINDS. Not every kind needs torch, whose import takes seconds."""
    return _imported(KINDS[kind].model)


def config_class(kind: str) -> Any:
    """The dataclass of the settings that one of KINDS is trained with."""
    return _imported(KINDS[kind].config)


def _imported(place: str) -> Any:
    module, name = place.split(":")
    return getattr(import_module(module), name)
