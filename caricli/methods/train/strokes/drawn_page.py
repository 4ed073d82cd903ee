"""Pages with all that people draw of a face and beside it, of which every place along a line is known what it draws."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from caricli.methods.sketch.settings import SELDOM
from caricli.methods.train.strokes.beside_lines import Curves, lines_beside
from caricli.models.sketch.window import Window
from caricli.structures.sketch import CANVAS
from caricli.template.feature_curves import SILHOUETTE

_KNOTS = 5
"""Heights of a face at which it is made longer or wider by itself."""
_FEATURES = (("mouth",), ("nose", "nostril"))
"""What the names of curves begin with that are one feature in the middle; artists move and enlarge features."""
_SIDED = ("brow", "eye", "ear")
"""The same of features on either side."""


@dataclass(frozen=True)
class PageSettings:
    """What artists do to faces, and leave out; lengths are shares of the face's height.

    stretched: by how much parts of the face become longer or shorter, standard deviation of logarithms; widened: the
    same across. exact: chance that features stay where they are. grown, aside, turned: of a feature, turned in radians.
    seldom: chance that curves of SELDOM are left out, each kind by itself; ears, lips, lids, outline: that the ears,
    the outer lips, the lower lids and the silhouette are. doubled: chance of brows in two lines; closed: of a closed
    mouth in one. bare: that the silhouette goes from ear to ear, without a crown. broken: chance of a line to be
    interrupted. again: to be drawn twice. tilt: of the page, degrees.
    """

    stretched: float = 0.15
    widened: float = 0.1
    exact: float = 0.4
    grown: float = 0.16
    aside: float = 0.018
    turned: float = 0.04
    seldom: float = 0.55
    ears: float = 0.3
    lips: float = 0.15
    lids: float = 0.1
    outline: float = 0.03
    doubled: float = 0.25
    closed: float = 0.3
    bare: float = 0.7
    broken: float = 0.15
    again: float = 0.1
    tilt: float = 5.0


@dataclass(frozen=True, eq=False)
class Page:
    """Lines (N, 2) on a canvas, pixels, the curve's name of each, or None, and the window that shows them."""

    lines: list[np.ndarray]
    names: list[str | None]
    window: Window


def draw_page(
    curves: Curves,
    wrinkles: Sequence[np.ndarray],
    generator: np.random.Generator,
    settings: PageSettings = PageSettings(),  # noqa: B008 (frozen)
) -> Page:
    """A page of a face.

    curves: lines of the face as a hand drew them, pixels of a canvas. wrinkles: further lines (N, 2) of it.
    """
    bent = _bending(curves, generator, settings)
    face = _moved({name: bent(line) for name, line in curves.items()}, generator, settings)
    face = _left(face, generator, settings)
    lines: list[tuple[str | None, np.ndarray]] = [*_as_drawn(face, generator, settings)]
    lines += [(None, bent(line)) for line in wrinkles]
    lines += [(None, line) for line in lines_beside(face, generator)]
    pieces = [(name, piece) for name, line in lines for piece in _drawn(line, generator, settings)]
    tilt = np.radians(settings.tilt) * generator.normal()
    turned = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    drawn = [piece @ turned for _, piece in pieces]
    tight = Window.around(drawn, CANVAS)
    aside = 0.05 * tight.half * generator.uniform(-1, 1, 2)
    window = Window(tight.centre + aside, tight.half * generator.uniform(0.97, 1.12))
    return Page(drawn, [name for name, _ in pieces], window)


class _Bending:
    """Makes some heights of a face longer and wider than others."""

    def __init__(self, low: np.ndarray, high: np.ndarray, longer: np.ndarray, wider: np.ndarray) -> None:
        """low, high: (2,) of the box around it. longer, wider: factors at ``_KNOTS`` heights, from above."""
        self.heights = np.linspace(low[1], high[1], len(longer))
        steps = np.diff(self.heights) * (longer[1:] + longer[:-1]) / 2
        self.places = low[1] + np.append(0, np.cumsum(steps))
        self.wider = wider
        self.middle = float(low[0] + high[0]) / 2

    def __call__(self, line: np.ndarray) -> np.ndarray:
        """A line (N, 2) of the face, or near it."""
        x, y = line.T
        wider = np.interp(y, self.heights, self.wider)
        beyond = y - np.clip(y, self.heights[0], self.heights[-1])
        placed = np.interp(y, self.heights, self.places) + beyond
        return np.stack([self.middle + wider * (x - self.middle), placed], 1)


def _bending(curves: Curves, generator: np.random.Generator, own: PageSettings) -> _Bending:
    points = np.concatenate(list(curves.values()))
    longer = np.exp(own.stretched * generator.normal(size=_KNOTS))
    wider = np.exp(own.widened * generator.normal(size=_KNOTS))
    return _Bending(points.min(0), points.max(0), longer, wider)


def _moved(curves: Curves, generator: np.random.Generator, own: PageSettings) -> dict[str, np.ndarray]:
    """Curves whose features are enlarged, moved and turned, those on either side nearly alike."""
    moved = dict(curves)
    if generator.random() < own.exact:
        return moved
    height = float(np.ptp(np.concatenate(list(curves.values()))[:, 1]))
    for start in _FEATURES:
        names = [name for name in curves if name.startswith(start)]
        moved |= _feature(curves, names, _Change.drawn(generator, own, height))
    for side_start in _SIDED:
        both = _Change.drawn(generator, own, height)
        for side, way in (("left", 1), ("right", -1)):
            names = [name for name in curves if name.startswith(side_start) and name.endswith(side)]
            alone = _Change.drawn(generator, own, height / 2)
            aside = both.aside * [way, 1] + alone.aside
            moved |= _feature(curves, names, _Change(both.grown * np.sqrt(alone.grown), aside, alone.turned))
    return moved


@dataclass(frozen=True, eq=False)
class _Change:
    """grown: (2,) factors. aside: (2,) pixels. turned: radians."""

    grown: np.ndarray
    aside: np.ndarray
    turned: float

    @classmethod
    def drawn(cls, generator: np.random.Generator, own: PageSettings, height: float) -> "_Change":
        """Any. height: of the face, pixels."""
        grown = np.exp(own.grown * generator.normal(size=2))
        return cls(grown, own.aside * height * generator.normal(size=2), own.turned * float(generator.normal()))


def _feature(curves: Curves, names: Sequence[str], change: _Change) -> dict[str, np.ndarray]:
    """Some curves, changed around their middle."""
    if not names:
        return {}
    middle = np.concatenate([curves[name] for name in names]).mean(0)
    cosine, sine = np.cos(change.turned), np.sin(change.turned)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    return {name: (curves[name] - middle) * change.grown @ turn + middle + change.aside for name in names}


def _left(curves: Curves, generator: np.random.Generator, own: PageSettings) -> dict[str, np.ndarray]:
    """The curves that are drawn, one at least."""
    gone = tuple(start for start in SELDOM if generator.random() < own.seldom)
    chances = (
        (own.ears, ("ear",)),
        (own.lips, ("mouth_upper", "mouth_lower")),
        (own.lids, ("eye_lower",)),
        (own.outline, (SILHOUETTE,)),
    )
    gone += tuple(name for chance, names in chances if generator.random() < chance for name in names)
    left = {name: line for name, line in curves.items() if not name.startswith(gone)} if gone else dict(curves)
    return left or dict(curves)


def _as_drawn(curves: Curves, generator: np.random.Generator, own: PageSettings) -> list[tuple[str, np.ndarray]]:
    """Lines of curves: brows in two, a closed mouth in one, a silhouette without its crown."""
    lines = dict(curves)
    height = float(np.ptp(np.concatenate(list(curves.values()))[:, 1]))
    inner = [lines.get(f"mouth_inner_{which}") for which in ("upper", "lower")]
    upper, lower = inner
    if generator.random() < own.closed and upper is not None and lower is not None:
        if lower[:, 1].mean() - upper[:, 1].mean() < 0.02 * height:
            del lines["mouth_inner_lower"]
    if SILHOUETTE in lines and generator.random() < own.bare:
        lines[SILHOUETTE] = _without_crown(lines[SILHOUETTE], curves, generator)
    drawn = list(lines.items())
    if generator.random() < own.doubled:
        thick = generator.uniform(0.08, 0.3)
        for name in ("brow_left", "brow_right"):
            if name in lines:
                line = lines[name]
                swell = np.sin(np.pi * np.linspace(0.05, 0.95, len(line)))
                drawn.append((name, line + np.stack([0 * swell, thick * np.ptp(line[:, 0]) * swell], 1)))
    return drawn


def _without_crown(outline: np.ndarray, curves: Curves, generator: np.random.Generator) -> np.ndarray:
    """What of a closed outline (N, 2) lies between the first and the last point below about the brows; all of an open
    one."""
    upper = [line for name, line in curves.items() if name.startswith(("brow", "eye"))]
    if not upper or not np.allclose(outline[0], outline[-1], atol=0.05 * np.ptp(outline, axis=0).max()):
        return outline
    height = float(np.ptp(outline[:, 1]))
    edge = np.concatenate(upper)[:, 1].mean() + height * generator.uniform(-0.2, 0.12)
    ring = np.roll(outline[:-1], -int(outline[:-1, 1].argmin()), axis=0)
    below = np.flatnonzero(ring[:, 1] > edge)
    return ring[below[0] : below[-1] + 1] if len(below) > 1 else outline


def _drawn(line: np.ndarray, generator: np.random.Generator, own: PageSettings) -> list[np.ndarray]:
    """A line (N, 2) as it is drawn: with a gap, or a second time beside itself."""
    pieces = [line]
    if generator.random() < own.broken and len(line) > 12:
        start = int(generator.integers(3, len(line) - 6))
        pieces = [line[:start], line[start + int(generator.integers(1, 4)) :]]
    if generator.random() < own.again:
        size = float(np.ptp(line, axis=0).max())
        pieces.append(line + 0.01 * CANVAS * generator.normal(size=2) + 0.01 * size * generator.normal(size=line.shape))
    return [piece for piece in pieces if len(piece) > 1]
