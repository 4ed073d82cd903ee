"""The name of a model: what its weights are."""

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property

import numpy as np


def model_id(kind: str, tensors: Mapping[str, np.ndarray]) -> str:
    """SHA-256 of a model's own tensors: the same for the file and for the model in memory."""
    digest = hashlib.sha256(kind.encode())
    for name in sorted(tensors):
        value = np.ascontiguousarray(tensors[name], "<f4")
        digest.update(f"{name}{np.shape(tensors[name])}".encode())
        digest.update(value.data)
    return digest.hexdigest()


class NamedByWeights(ABC):
    """A model whose ``model_id`` is that of its tensors, whether it has ever been in a file or not."""

    kind: str

    @cached_property
    def model_id(self) -> str:
        """SHA-256 of its weights, see the function of this name."""
        return model_id(self.kind, self.tensors())

    @abstractmethod
    def tensors(self) -> dict[str, np.ndarray]:
        """Arrays by name, as a checkpoint holds them."""
