"""Settings of the intrinsic model."""

from dataclasses import dataclass

from caricli.models.config import LinearConfig


@dataclass(frozen=True)
class IntrinsicConfig(LinearConfig):
    """Settings of IntrinsicModel: see LinearConfig."""
