"""Settings of the network that sees faces in sketches, and of its training."""

from dataclasses import dataclass

from caricli.models.config import TRAINING_RANGES, NetworkTraining, check_levels, check_ranges, check_windows, size_in

MODERN = "modern"

_SIZES = {"stem": (4, 512), "hidden": (1, 8192), "told": (1, 8192), "components": (1, 512)}
_RANGES = TRAINING_RANGES | _SIZES | {
    "mixed": (0, 1), "people": (1, 64), "missing": (0, 1), "unnamed": (0, 1), "strength": (0, 10),
    "camera_weight": (0, 1e6), "held": (0, 0.9), "branch": (1, 8192), "classify": (0, 10**6), "regress": (0, 10**6),
    "kernel_rate": (0, 1), "later_rate": (1e-6, 1), "extra": (0, 10**6), "importance": (0, 1000),
}  # fmt: skip
STEP = 32
"""Pixels that the network reduces to one: a window has a multiple of them."""

_LEVELS = 3
_CONVOLUTIONS = 5
_WIDEST = 512
"""Channels of a published network: a file must not ask for more memory than there is."""


@dataclass(frozen=True)
class SketchSize:
    """Size of the network.

    stem: channels at a quarter of the window's size. widths, blocks: channels and residual blocks at 1/8, 1/16 and 1/32
    of it. hidden: numbers between what is seen and the latent. told: width of the two layers for points along strokes.
    components: numbers that these come in as, of which few curves fill but some.
    Raises ValueError for impossible sizes.
    """

    stem: int = 32
    widths: tuple[int, ...] = (64, 96, 128)
    blocks: tuple[int, ...] = (0, 1, 1)
    told: int = 512
    hidden: int = 512
    components: int = 160

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _SIZES)
        check_levels(self, _LEVELS)


@dataclass(frozen=True)
class Variant:
    """A published network (sketch paper, section 6.3): what it is shown, and whether u and v have layers of their own.

    label: what tables call it. pixels: the picture of the strokes. wrinkles: also of wrinkle lines. points: the
    coefficients of points along named strokes.
    """

    label: str
    pixels: bool = True
    wrinkles: bool = True
    points: bool = False
    branches: bool = True


PUBLISHED = {
    "pixel_shape": Variant("PixelShapeCNN", points=True),
    "pixel": Variant("PixelCNN"),
    "pixel_plain": Variant("PixelCNN without wrinkles", wrinkles=False),
    "shape": Variant("ShapeNN", pixels=False, wrinkles=False, points=True),
    "pixel_single": Variant("PixelCNNSingle", branches=False),
}


@dataclass(frozen=True)
class PublishedSize:
    """Size of a published network.

    variant: name in PUBLISHED. widths: channels of the five convolutions. hidden: of the shared layer after them.
    branch: of the layers of u and of v. told: of a layer for the coefficients of points. local: whether responses are
    normalised locally, as AlexNet's, or by batches. identity, expression: numbers of u and of v.
    Raises ValueError for impossible sizes.
    """

    variant: str = "pixel_shape"
    widths: tuple[int, ...] = (96, 256, 384, 384, 256)
    hidden: int = 4096
    branch: int = 1024
    told: int = 512
    local: bool = True
    identity: int = 50
    expression: int = 16

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        if self.variant not in PUBLISHED:
            raise ValueError(f"variant must be one of {', '.join([MODERN, *PUBLISHED])}, found {self.variant!r}")
        sizes: dict[str, tuple[float, float]] = {name: (1, 4096) for name in ("hidden", "branch", "told")}
        check_ranges(self, sizes | {"identity": (1, 256), "expression": (1, 64)})
        if len(self.widths) != _CONVOLUTIONS or not all(1 <= width <= _WIDEST for width in self.widths):
            raise ValueError(f"widths must be {_CONVOLUTIONS} numbers from 1 to {_WIDEST}, found {self.widths}")


@dataclass(frozen=True)
class SketchConfig(SketchSize, NetworkTraining):
    """Settings of a sketch network's training: NetworkTraining's, those of SketchSize, and its own.

    With the defaults the network has 4.7 MB in half precision. What only one kind of network has, others leave out.

    variant: "modern", or a name in PUBLISHED. branch, local: see PublishedSize. mixed: share of the sketches that are
    of nobody, mixtures of ``people`` at most with one's expression. missing: share that lacks strokes, up to all but a
    few. unnamed: share of which only the picture is given. strength: of the noise of hand and view on average, 1 as
    ``HandSettings`` has it; every sketch has its own, from none to twice as much. camera_weight: of the error of the
    camera beside the mean distance of the vertices, percent of the head's height. held: share of the faces of people
    who are trained with that are left out, to test with (sketch paper, section 4.4).

    Of published networks alone: classify, regress: epochs of the first two steps of the training, in which people and
    expressions are told apart, and u and v are learnt with the convolutions as they are; the others are for the
    vertices. kernel_rate: of Muon, by which the weights of all layers but the last ones learn; 0 lets them learn as all
    else. later_rate: learning rates of the last two steps, relative to the first. extra: faces between pairs of faces,
    beside those of the datasets. importance: weight of vertices on the curves, where others have 1.
    Raises ValueError for impossible sizes.
    """

    epochs: int = 60
    batch: int = 256
    validate_every: int = 3
    variant: str = MODERN
    branch: int = 1024
    local: bool = False
    mixed: float = 0.9
    people: int = 12
    missing: float = 0.4
    unnamed: float = 0.1
    strength: float = 0.75
    camera_weight: float = 0.05
    held: float = 0.1
    classify: int = 0
    regress: int = 0
    kernel_rate: float = 0.0
    later_rate: float = 1.0
    extra: int = 10000
    importance: float = 4.0

    def __post_init__(self) -> None:
        """Refuse impossible sizes."""
        check_ranges(self, _RANGES)
        self.network()
        check_windows(self.size, STEP, self.precision)
        if self.published and self.classify + self.regress >= self.epochs:
            raise ValueError(f"classify and regress must leave some of the {self.epochs} epochs, found none")

    @property
    def published(self) -> Variant | None:
        """The Variant of a published network, None for the modern one."""
        return PUBLISHED.get(self.variant)

    def network(self, identity: int = 50, expression: int = 16) -> SketchSize | PublishedSize:
        """The size. identity, expression: numbers of u and of v, of published networks."""
        if self.variant == MODERN:
            return size_in(self, SketchSize)
        sizes = (self.hidden, self.branch, self.told, self.local, identity, expression)
        return PublishedSize(self.variant, self.widths, *sizes)
