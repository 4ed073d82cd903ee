"""Settings of the network that sees faces in sketches, and of its training."""

from dataclasses import dataclass

from caricli.models.config import MAX_SEED, check_levels, check_ranges, check_windows

MODERN = "modern"

_SIZES = {"stem": (4, 512), "hidden": (1, 8192), "told": (1, 8192), "components": (1, 512)}
_RANGES = _SIZES | {
    "size": (64, 512), "epochs": (1, 10**6), "steps": (1, 10**6), "batch": (2, 4096), "mixed": (0, 1),
    "people": (1, 64), "missing": (0, 1), "unnamed": (0, 1), "strength": (0, 10), "learning_rate": (1e-9, 1),
    "kernel_rate": (0, 1), "weight_decay": (0, 10), "branch": (1, 8192), "classify": (0, 10**6), "regress": (0, 10**6), 
    "later_rate": (1e-6, 1), "extra": (0, 10**6), "importance": (0, 1000), "decay": (0, 0.99999),
    "camera_weight": (0, 1e6), "validation": (1, 10**5),
    "validate_every": (1, 10**6), "held": (0, 0.9), "checkpoint_seconds": (0, 10**5), "seed": (0, MAX_SEED),
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
class SketchConfig:
    """Settings of a sketch network's training.

    With the defaults the network has 4.7 MB in half precision. What only one kind of network has, others leave out.

    variant: "modern", or a name in PUBLISHED. stem, widths, blocks, told, hidden, components: see SketchSize; branch,
    local: see PublishedSize. size: of the windows, pixels; a multiple of 32. epochs; steps: in an epoch. batch:
    sketches a step. mixed: share of them that are of nobody, mixtures of ``people`` at most with one's expression.
    missing: share of the sketches that lack strokes, up to all but a few. unnamed: share of which only the picture is
    given. strength: of the noise of hand and view on average, 1 as ``HandSettings`` has it; every sketch has its own,
    from none to twice as much. learning_rate, weight_decay: of AdamW, with a cosine schedule. decay: of the weights'
    moving average, a step. camera_weight: of the error of the camera beside the mean distance of the vertices, percent
    of the head's height. precision: of the convolutions. validation: sketches measured at a validation. validate_every:
    epochs. held: share of the faces of people who are trained with that are left out, to test with (sketch paper,
    section 4.4). checkpoint_seconds: between two checkpoints.

    Of published networks alone: classify, regress: epochs of the first two steps of the training, in which people and
    expressions are told apart, and u and v are learnt with the convolutions as they are; the others are for the
    vertices. kernel_rate: of Muon, by which the weights of all layers but the last ones learn; 0 lets them learn as all
    else. later_rate: learning rates of the last two steps, relative to the first. extra: faces between pairs of faces,
    beside those of the datasets. importance: weight of vertices on the curves, where others have 1.
    Raises ValueError for impossible sizes.
    """

    variant: str = MODERN
    stem: int = 32
    widths: tuple[int, ...] = (64, 96, 128)
    blocks: tuple[int, ...] = (0, 1, 1)
    told: int = 512
    hidden: int = 512
    components: int = 160
    branch: int = 1024
    local: bool = False
    size: int = 128
    epochs: int = 60
    steps: int = 100
    batch: int = 256
    mixed: float = 0.9
    people: int = 12
    missing: float = 0.4
    unnamed: float = 0.1
    strength: float = 0.75
    learning_rate: float = 1e-3
    weight_decay: float = 1e-3
    decay: float = 0.998
    camera_weight: float = 0.05
    precision: str = "bfloat16"
    validation: int = 200
    validate_every: int = 3
    held: float = 0.1
    classify: int = 0
    regress: int = 0
    kernel_rate: float = 0.0
    later_rate: float = 1.0
    extra: int = 10000
    importance: float = 4.0
    checkpoint_seconds: int = 60
    seed: int = 0

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
            return SketchSize(self.stem, self.widths, self.blocks, self.told, self.hidden, self.components)
        sizes = (self.hidden, self.branch, self.told, self.local, identity, expression)
        return PublishedSize(self.variant, self.widths, *sizes)
