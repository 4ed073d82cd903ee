"""The generator of two branches and its critic (expressions paper, section 3.3.1).

Attention is told by the expressions alone, as shapes or as codes, and the colours by them and the texture. Attention
says here where to change, so that equation 12 reads T' = (1 - A) T + A C.
"""

from dataclasses import dataclass

import torch
from torch import nn
from torch.nn import functional

from caricli.models.residual import Residual, start_convolutions, unit
from caricli.models.texture.config import TextureSize

CODES = 104
"""Weights of ARKit's 52 actions in the source and in the target."""

MAPS = 23
"""Channels of the maps of both shapes."""

OPEN = 0.2
"""Attention where nothing moves, of colours that change what is there: shading changes there, too."""

ATLAS = 48
"""Places of the atlas, across and down."""

_PLACE = 2
"""Channels that say where a texel is: the chart is the same for everybody."""

_DARK = 0.02
"""From 0 to 1: what is as dark as that has no hue."""

_WIDE = 16
"""Of a chart's side: the standard deviation of what is around a fold."""

_HALF = 2
_LEVELS = 4
_SLOPE = 0.2


@dataclass(frozen=True, eq=False)
class Change:
    """What becomes of a texture at every texel: T' = T + A (G T + O), sRGB from 0 to 1.

    attention: A, (B, 1, S, S) 0 to 1. gain: G, (B, 3, S, S). offset: O, (B, 3, S, S). Colours C in place of a gain are
    G = -1, O = C.
    """

    attention: torch.Tensor
    gain: torch.Tensor
    offset: torch.Tensor

    def paint(self, pictures: torch.Tensor) -> torch.Tensor:
        """Textures (B, 3, S, S) as they become (equation 12)."""
        return pictures + self.attention * (self.gain * pictures + self.offset)

    def in_own_shades(self, pictures: torch.Tensor, shades: torch.Tensor, share: torch.Tensor) -> "Change":
        """The same, but so far as the darker or lighter paint that the pictures have themselves, equally light.

        pictures: (B, 3, S, S), sRGB from 0 to 1. shades: (B, 3), exponents of the channels, see ``Manner``. share:
        (S, S) from 0 to 1, how far.
        """
        before = _luminance(pictures)
        after = _luminance(self.paint(pictures).clamp(0, 1))
        shaded = pictures.clamp(_DARK, 1) * (after / before) ** shades[:, :, None, None]
        factor = shaded * after / _luminance(shaded) / pictures.clamp(_DARK, 1) - 1
        gain = self.attention * self.gain
        offset = self.attention * self.offset
        return Change(torch.ones_like(self.attention), gain + share * (factor - gain), offset - share * offset)

    def with_folds_up_to(
        self, pictures: torch.Tensor, deepest: torch.Tensor, shades: torch.Tensor, skin: torch.Tensor
    ) -> "Change":
        """The same, but folds, which are darker than what is around them, no deeper than the pictures have any.

        pictures: (B, 3, S, S), sRGB from 0 to 1. deepest: (B,), see ``Manner``. shades: (B, 3). skin: (S, S).
        """
        ratio = skin * (_luminance(self.paint(pictures).clamp(0, 1)) / _luminance(pictures)).log()
        folds = skin * (_around(ratio).clamp(max=0) - ratio).clamp(min=0)
        most = deepest[:, None, None, None]
        factor = ((folds - most * torch.tanh(folds / most)) * shades[:, :, None, None]).exp()
        gain = (1 + self.attention * self.gain) * factor - 1
        return Change(torch.ones_like(self.attention), gain, self.attention * self.offset * factor)

    def toned(self, share: torch.Tensor) -> "Change":
        """The same with so much of its colour, (B,) from 0, in shades of grey, to 1."""
        grey = 1 - share[:, None, None, None]
        gain, offset = (each + grey * (each.mean(1, keepdim=True) - each) for each in (self.gain, self.offset))
        return Change(self.attention, gain, offset)


def _around(fields: torch.Tensor) -> torch.Tensor:
    """Means of fields (B, 1, S, S) around every texel, with Gaussian weights."""
    spread = fields.shape[-1] / _WIDE
    reach = int(3 * spread)
    steps = torch.arange(-reach, reach + 1, dtype=fields.dtype, device=fields.device)
    weights = torch.exp(-0.5 * (steps / spread) ** 2)
    weights = weights / weights.sum()
    down = functional.conv2d(fields, weights.view(1, 1, -1, 1), padding=(reach, 0))
    return functional.conv2d(down, weights.view(1, 1, 1, -1), padding=(0, reach))


def _luminance(pictures: torch.Tensor) -> torch.Tensor:
    """(B, 1, S, S) of pictures (B, 3, S, S), never black or white."""
    weights = pictures.new_tensor((0.2126, 0.7152, 0.0722)).view(1, 3, 1, 1)
    return (weights * pictures).sum(1, keepdim=True).clamp(_DARK, 1 - _DARK)


class TextureNetwork(nn.Module):
    """Textures in the chart, and both expressions, to a Change."""

    def __init__(self, size: TextureSize, generator: torch.Generator) -> None:
        """generator: of the initial weights."""
        super().__init__()
        told = MAPS * size.maps
        codes = CODES * size.codes
        self.size = size
        self.atlas = ActionAtlas(size.atlas) if size.codes and size.atlas else None
        drawn = 0 if self.atlas is None else 2 * size.atlas
        self.colour = Branch((3 + _PLACE + told, drawn), 6 if size.relative else 3, size.width, codes)
        self.where = Branch((_PLACE + told, drawn), 1, size.narrow, codes) if size.attention else None
        start_convolutions(self, generator)
        for branch in (self.colour, self.where):
            if branch is not None:
                branch.begin(generator)

    def forward(self, pictures: torch.Tensor, maps: torch.Tensor, codes: torch.Tensor) -> Change:
        """pictures: (B, 3, S, S) sRGB from 0 to 1. maps: (B, 23, S, S). codes: (B, 104)."""
        told = torch.cat([_places(pictures), maps[:, : MAPS * self.size.maps]], 1)
        given = Told(codes[:, : CODES * self.size.codes], self._drawn(codes, pictures.shape[-1] // _HALF))
        values = self.colour(torch.cat([2 * pictures - 1, told], 1), given)
        gain = values[:, :3] if self.size.relative else torch.full_like(pictures, -1)
        offset = values[:, 3:] if self.size.relative else torch.sigmoid(values)
        if self.where is None:
            return Change(torch.ones_like(pictures[:, :1]), gain, offset)
        attention = torch.sigmoid(self.where(told, given))
        return Change(OPEN + (1 - OPEN) * attention if self.size.relative else attention, gain, offset)

    def _drawn(self, codes: torch.Tensor, side: int) -> torch.Tensor:
        """(B, K, side, side) what the atlas says; K is 0 where there is none."""
        return codes.new_zeros(len(codes), 0, side, side) if self.atlas is None else self.atlas(codes, side)


@dataclass(frozen=True, eq=False)
class Told:
    """What a branch is told of both expressions. codes: (B, C) of the whole face. drawn: (B, K, S / 2, S / 2)."""

    codes: torch.Tensor
    drawn: torch.Tensor


class ActionAtlas(nn.Module):
    """What each of the actions does at each place of the chart, learnt: folds lie where they lie in most faces."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.fields = nn.Parameter(torch.zeros(CODES // 2, channels, ATLAS, ATLAS))

    def forward(self, codes: torch.Tensor, side: int) -> torch.Tensor:
        """Codes (B, 104) of source and target to (B, 2 C, side, side)."""
        drawn = codes.view(len(codes), 2, -1) @ self.fields.flatten(1)
        fields = drawn.view(len(codes), -1, ATLAS, ATLAS)
        return fields if side == ATLAS else functional.interpolate(fields, (side, side), mode="bilinear")


class Branch(nn.Module):
    """A U-Net from half of the chart's size down to a sixteenth, told the codes on every level."""

    def __init__(self, inputs: tuple[int, int], outputs: int, width: int, codes: int) -> None:
        """inputs: channels, of the chart's size and of half of it. outputs: channels. width: at half of the chart's
        size. codes: how many numbers."""
        super().__init__()
        widths = (width, width * 3 // 2, 2 * width, 2 * width)
        self.stem = unit(inputs[0] * _HALF**2 + inputs[1], width)
        self.told = nn.ModuleList(nn.Linear(codes, each) for each in widths if codes)
        self.down = nn.ModuleList(unit(a, b, stride=2) for a, b in zip(widths[:-1], widths[1:], strict=True))
        self.same = nn.ModuleList(Residual(each) for each in widths)
        self.up = nn.ModuleList(unit(b, a, kernel=1) for a, b in zip(widths[-2::-1], widths[:0:-1], strict=True))
        self.join = nn.ModuleList(Residual(each) for each in widths[-2::-1])
        self.last = nn.Conv2d(width, outputs * _HALF**2, 3, padding=1)

    def begin(self, generator: torch.Generator) -> None:
        """Draw the weights that tell the codes; what comes out is nothing at first."""
        for name, value in self.told.named_parameters():
            nn.init.normal_(value, std=0.0 if name.endswith("bias") else 0.1, generator=generator)
        nn.init.zeros_(self.last.weight)

    def forward(self, fields: torch.Tensor, told: Told) -> torch.Tensor:
        """Fields (B, inputs, S, S) and what is told to (B, outputs, S, S)."""
        values = torch.cat([functional.pixel_unshuffle(fields, _HALF), told.drawn], 1)
        values = values.contiguous(memory_format=torch.channels_last)
        levels: list[torch.Tensor] = []
        values = self.stem(values)
        for level in range(_LEVELS):
            if level:
                values = self.down[level - 1](levels[-1])
            if self.told:
                values = values + self.told[level](told.codes)[:, :, None, None]
            levels.append(self.same[level](values))
        values = levels.pop()
        for up, join in zip(self.up, self.join, strict=True):
            values = join(levels.pop() + functional.interpolate(up(values), scale_factor=2, mode="nearest"))
        return functional.pixel_shuffle(self.last(values), _HALF).float()


class TextureCritic(nn.Module):
    """Textures to how real each patch looks, and to their expression."""

    def __init__(self, width: int, size: int, generator: torch.Generator) -> None:
        """width: channels at half of the chart's size. size: of the chart, texels."""
        super().__init__()
        widths = (3, width, 2 * width, 4 * width)
        self.down = nn.ModuleList(nn.Conv2d(a, b, 4, 2, 1) for a, b in zip(widths[:-1], widths[1:], strict=True))
        self.patch = nn.Conv2d(widths[-1], 1, 3, padding=1)
        self.far = nn.Conv2d(widths[-1], widths[-1], 4, 2, 1)
        self.expression = nn.Linear(widths[-1] * (size // 16) ** 2, CODES // 2)
        start_convolutions(self, generator)
        nn.init.normal_(self.expression.weight, std=0.01, generator=generator)
        nn.init.zeros_(self.expression.bias)

    def forward(self, pictures: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Pictures (B, 3, S, S), sRGB from 0 to 1, to scores (B, S / 8, S / 8) and weights (B, 52)."""
        values = 2 * pictures - 1
        for layer in self.down:
            values = functional.leaky_relu(layer(values), _SLOPE)
        far = functional.leaky_relu(self.far(values), _SLOPE)
        return self.patch(values)[:, 0], self.expression(far.flatten(1))


def _places(pictures: torch.Tensor) -> torch.Tensor:
    """(B, 2, S, S) from -1 to 1: how far right and down every texel of pictures (B, 3, S, S) is."""
    side = torch.linspace(-1, 1, pictures.shape[-1], dtype=pictures.dtype, device=pictures.device)
    return torch.stack(torch.meshgrid(side, side, indexing="xy")).expand(len(pictures), -1, -1, -1)
