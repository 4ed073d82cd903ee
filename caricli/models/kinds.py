"""The kinds of shape models: their classes, imported only when they are asked for, and their settings."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from caricli.models.bilinear.config import BilinearConfig
from caricli.models.config import TrainingConfig
from caricli.models.deformable.config import DeformableConfig
from caricli.models.intrinsic.config import IntrinsicConfig
from caricli.models.kernel.config import KernelConfig
from caricli.models.morphable.config import MorphableConfig
from caricli.models.pca.config import PcaConfig

if TYPE_CHECKING:
    from caricli.models.shape_model import ComponentModel, ShapeModel


@dataclass(frozen=True)
class Kind:
    """What belongs to a kind.

    model: imports the class, which mypy holds to the interface. config: the dataclass of its training's settings.
    """

    model: "Callable[[], type[ShapeModel]]"
    config: type[TrainingConfig]


def _pca() -> "type[ComponentModel]":
    from caricli.models.pca.model import PcaModel

    return PcaModel


def _intrinsic() -> "type[ComponentModel]":
    from caricli.models.intrinsic.model import IntrinsicModel

    return IntrinsicModel


def _kernel() -> "type[ComponentModel]":
    from caricli.models.kernel.model import KernelModel

    return KernelModel


def _deformable() -> "type[ShapeModel]":
    from caricli.models.deformable.model import DeformableModel

    return DeformableModel


def _morphable() -> "type[ShapeModel]":
    from caricli.models.morphable.model import MorphableModel

    return MorphableModel


def _bilinear() -> "type[ShapeModel]":
    from caricli.models.bilinear.model import BilinearModel

    return BilinearModel


KINDS = {
    "pca": Kind(_pca, PcaConfig),
    "intrinsic": Kind(_intrinsic, IntrinsicConfig),
    "kernel": Kind(_kernel, KernelConfig),
    "deformable": Kind(_deformable, DeformableConfig),
    "morphable": Kind(_morphable, MorphableConfig),
    "bilinear": Kind(_bilinear, BilinearConfig),
}
"""Kinds by the names that checkpoints carry."""


def model_class(kind: str) -> "type[ShapeModel]":
    """The class of one of KINDS. Not every kind needs torch, whose import takes seconds."""
    return KINDS[kind].model()


def config_class(kind: str) -> type[TrainingConfig]:
    """The dataclass of the settings that one of KINDS is trained with."""
    return KINDS[kind].config
