"""Settings of the texture network and of its training."""

from dataclasses import dataclass
from math import ceil

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_ranges, check_windows, size_in

_SIZES = {"width": (4, 512), "narrow": (4, 512), "atlas": (0, 64)}
_RANGES = TRAINING_RANGES | _SIZES | {
    "size": (32, 512), "looks": (0, 64), "plain": (0, 1), "mirrored": (0, 1), "unpaired": (0, 1), "kernel_rate": (0, 1),
    "critic_rate": (1e-9, 1), "judge_every": (1, 10**6), "critic_width": (4, 512), "penalty": (0, 1e6),
    "attention_weight": (0, 1e6), "colour_weight": (0, 1e6), "cycle_weight": (0, 1e6), "adversarial_weight": (0, 1e6),
    "expression_weight": (0, 1e6), "mouth": (1, 1e3),
}  # fmt: skip
STEP = 32
"""Texels that the network reduces to one: a chart has a multiple of them."""


@dataclass(frozen=True)
class TextureSize:
    """Form of the generator.

    width, narrow: channels at half of the chart's size of the branches for colour and for attention; below it there are
    3/2, 2 and 2 times as many. atlas: channels in which the weights of expressions draw what they do at each place of
    the chart, beside those that say it of the whole; none without codes. maps: whether it is told the shapes of the
    person with both expressions, as maps in the chart. codes: whether it is told the weights of both expressions.
    attention: whether there is that branch; without it the colours hold everywhere. relative: whether colours are a
    gain and an offset on those that are there, in place of colours.
    Raises ValueError for impossible sizes.
    """

    width: int = 32
    narrow: int = 12
    atlas: int = 3
    maps: bool = True
    codes: bool = True
    attention: bool = True
    relative: bool = True

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _SIZES)
        if not (self.maps or self.codes):
            raise ValueError("maps or codes must be true: else nothing tells the expression")


@dataclass(frozen=True)
class TextureConfig(TextureSize, NetworkTraining):
    """Settings of a texture network's training: NetworkTraining's, those of TextureSize, and its own.

    With the defaults the network has 1.9 MB in half precision. Its windows are charts, whose pixels are texels; batch
    and validation are pairs of expressions.

    looks: styles that every person is painted in beside the own one. plain: share of the pairs in the own look; the
    others are in any, the own one among them. mirrored: share of those that are mirrored. unpaired: share of the
    epochs, the last ones, that are trained without pairs, by cycles; below 1 the first is not. kernel_rate: of Muon, by
    which the kernels of convolutions learn; 0 lets them learn as all else. critic_rate: of the critic's AdamW.
    judge_every: one of so many steps has the critic, whose gradients of gradients cost most. critic_width: its channels
    at half of the chart's size. penalty: of its gradients. attention_weight, colour_weight, cycle_weight,
    adversarial_weight, expression_weight: of the losses (section 4.1). mouth: by how much an opened mouth counts more
    than skin.
    Raises ValueError for impossible sizes.
    """

    size: int = 96
    epochs: int = 80
    batch: int = 24
    weight_decay: float = 1e-2
    decay: float = 0.995
    validation: int = 384
    looks: int = 2
    plain: float = 0.3
    mirrored: float = 0.5
    unpaired: float = 0.05
    kernel_rate: float = 6e-3
    critic_rate: float = 2e-4
    judge_every: int = 8
    critic_width: int = 24
    penalty: float = 10.0
    attention_weight: float = 10.0
    colour_weight: float = 10.0
    cycle_weight: float = 10.0
    adversarial_weight: float = 0.02
    expression_weight: float = 1.0
    mouth: float = 5.0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        check_windows(self.size, STEP, self.precision)
        self.network()

    def network(self) -> TextureSize:
        """The TextureSize."""
        return size_in(self, TextureSize)

    @property
    def paired_epochs(self) -> int:
        """Epochs that are trained on pairs."""
        # Shares such as 0.07 are a little more than they say.
        unpaired = ceil(round(self.epochs * self.unpaired, 6))
        return max(self.epochs - unpaired, int(self.unpaired < 1))
