"""Settings of the model of principal components."""

from dataclasses import dataclass

from caricli.models.config import LinearConfig


@dataclass(frozen=True)
class PcaConfig(LinearConfig):
    """Settings of PcaModel: see LinearConfig."""
