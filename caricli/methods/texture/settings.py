"""What textures are tuned by; light to import, because the command line takes its defaults from here."""

from dataclasses import dataclass
from typing import Literal

from caricli.structures import HeadChoice
from caricli.structures.head_choice import WHOLE

Hair = Literal["auto", "none", "shell"]
"""What becomes of the hair of a picture."""


@dataclass(frozen=True)
class TextureSettings:
    """How a picture is brought onto a face.

    grazing, facing: cosine between surface and view below which nothing is seen, and from which on all is: at a grazing
    angle one pixel would be smeared over many texels, and outlines and rim light are there. grazing_hair, facing_hair:
    the same of scalp and hair, which are alike all over.
    mirrored: how much the other side counts where a texel is seen itself; small, so that sides keep what is theirs.
    behind: share of the head's height that a point may be behind the surface that is seen, a pixel at least, for
    rasterising rounds.
    edge: share of the head's height, width of the band inside the mask's border that hardly counts: outlines are there.
    other: standard deviation of colours, of full scale, from what is farther inside, by which those in that band count
    as another thing; what is like it counts as much.
    trust: how far a texel must be seen to take nothing but the picture.
    glimpse: how far a vertex must be seen for what is hardly seen around it to look as it does in the picture, and a
    texel for its own colour to count where this is like what fills it.
    neck: how far a neck must be seen in the mean to take anything of the picture: what a collar leaves is a patch.
    burnt: sRGB from which on a pixel may have been brighter than it is in the picture.
    keep_light: whether light and shade of the picture stay in the texture.
    rounds: of giving back what a rendering blurs; alone: weight that keeps texels which no pixel shows near the others.
    smallest, largest: texels, limits of the size that follows the picture.
    buffer: pixels, the most of a head's longer side in its picture; more than the largest texture can hold tell
    nothing.
    """

    grazing: float = 0.2
    facing: float = 0.6
    grazing_hair: float = 0.12
    facing_hair: float = 0.5
    mirrored: float = 0.08
    behind: float = 0.006
    edge: float = 0.012
    other: float = 0.08
    trust: float = 0.35
    glimpse: float = 0.01
    neck: float = 0.08
    burnt: int = 250
    keep_light: bool = False
    rounds: int = 8
    alone: float = 0.25
    smallest: int = 1024
    largest: int = 4096
    buffer: int = 2048


@dataclass(frozen=True)
class PaintSettings:
    """How a head is painted.

    size: texels, side of the texture; None for as fine as the picture.
    project_uv: the picture itself as texture, as published (portrait paper, equation 12), to compare.
    seed: of the fibres of the iris, and of strands of hair and grain of skin that the picture does not show.
    hair: "shell" of hair on the head, "none", or "auto": a shell unless it is doubtful what is hair.
    head: HeadChoice; pictures of what it leaves out are painted nevertheless, for the commands that come after.
    texture: TextureSettings.
    sky: whether it is looked for, beside the painting, what the head sees of the sky, for pictures of it.
    """

    size: int | None = None
    project_uv: bool = False
    seed: int = 0
    hair: Hair = "auto"
    head: HeadChoice = WHOLE
    texture: TextureSettings = TextureSettings()
    sky: bool = False
