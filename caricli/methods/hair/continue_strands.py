"""Strands of hair continued around a head, from patches of what is seen."""

from dataclasses import dataclass, replace
from math import ceil, floor

import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt

_SIDES = (0.2, 0.14, 0.1, 0.07, 0.05, 0.035, 0.025)  # of the picture: patches, the largest of which there are enough
_ENOUGH = 24  # patches
_FULL = 0.7  # of a patch: with less of it seen it is none
_BORDER = 0.003  # of the picture: so near to what is not seen no patch is taken
_STEP = 0.6  # of a patch's side, from one to the next
_UNEVEN = 0.3  # of a step, to and fro, so that patches do not lie in rings
_PASSES = 2  # over all of them: a patch that is seen in part leaves holes
_CANDIDATES = 80  # places that a patch may be taken from
_LIKELY = 1.1  # of the least difference: those with no more are drawn from
_USED = 0.5  # how much worse a patch is each time that it was taken, so that nothing repeats
_FEATHER = 0.2  # of a patch's side, over which it fades into what was there
_TONE = 0.3  # of a patch's side, over which it takes on the tone of what it joins
_OWN = 0.1  # how much of its own tone it keeps, so that tones do not drift
_BLOTCH = 0.015  # of the picture: what is as dark or light over more than this is a shadow or a light
_EVEN = 0.7  # of how far these are from the mean tone, that is taken out of patches
_FEW = 4  # times that a patch is smaller where its tone is blurred
_STRANDS = 0.15  # of what a patch changes, what it changes more across than along, from which on it has strands
_COARSE = 12  # pixels, the longest side of patches where they are compared


@dataclass(frozen=True)
class _Frame:
    """A square in a picture whose strands run outwards from its middle: they run down in it.

    radius: pixels from the middle. turn: radians. side: pixels. lean: radians by which it is turned where its strands
    run otherwise.
    """

    radius: float
    turn: float
    side: int
    lean: float = 0.0

    def matrix(self, size: int) -> np.ndarray:
        """(2, 3): from pixels of the square to those of the picture."""
        sine = np.sin(self.turn + self.lean)
        cosine = np.cos(self.turn + self.lean)
        corner = (self.side - 1) / 2
        x = (size - 1) / 2 + self.radius * np.sin(self.turn) - corner * (cosine + sine)
        y = (size - 1) / 2 + self.radius * np.cos(self.turn) - corner * (cosine - sine)
        return np.array([[cosine, sine, x], [-sine, cosine, y]])

    def cut(self, picture: np.ndarray) -> np.ndarray:
        """What a picture (S, S, ...) shows there."""
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = (self.side, self.side)
        return cv2.warpAffine(picture, self.matrix(len(picture)), size, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def continue_strands(image: np.ndarray, seen: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Fill a picture whose strands run outwards from its middle with patches of what is seen of it.

    Image quilting (Efros and Freeman 2001) with patches that turn with the strands: from what is seen outwards, a patch
    is taken where it differs least from what it joins, and the less, the oftener it was taken.

    image: (S, S, 3) from 0 to 255. seen: (S, S) bool. generator: of the choice among equals.
    Returns (S, S, 3) float32, what is seen unchanged but for its border, over which patches fade into it. All else is
    its mean colour where too little is seen for a patch.
    """
    canvas = image.astype(np.float32)
    if not seen.any() or seen.all():
        return canvas
    canvas[~seen] = canvas[seen].mean(0)
    quilt = _Quilt(canvas, seen, generator)
    if len(quilt.patches):
        for frame in _PASSES * quilt.frames():
            quilt.lay(frame)
    return quilt.canvas


class _Quilt:
    """A picture (S, S, 3) that is laid with patches; laid: (S, S) from 0 to 1, where it is."""

    def __init__(self, canvas: np.ndarray, seen: np.ndarray, generator: np.random.Generator) -> None:
        self.canvas = canvas
        self.laid = seen.astype(np.float32)
        self.generator = generator
        # Along the border there is something of what hair ends at.
        inside = cv2.distanceTransform(np.pad(seen, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]
        self.seen = (inside > _BORDER * len(seen)).astype(np.float32)
        self.far = distance_transform_edt(~seen)
        self.side, patches = self._patches(_even(canvas, self.seen))
        self.patches = patches[..., :3]
        self.whole = patches[..., 3]
        every = ceil(self.side / _COARSE)
        self.coarse = np.s_[every // 2 :: every, every // 2 :: every]
        self.fades = np.clip(2 * self.whole - 1, 0, 1)
        whole = self.whole[:, *self.coarse]
        whole = whole.reshape(len(patches), whole.shape[1] * whole.shape[2])
        colours = self.patches[:, *self.coarse].reshape(len(patches), whole.shape[1], 3)
        # What the squares of differences are made of, where a patch is seen.
        self.parts = (
            whole,
            (whole[..., None] * colours).reshape(len(patches), 3 * whole.shape[1]),
            whole * (colours**2).sum(-1),
        )
        self.totals = whole.sum(1)
        self.uses = np.zeros(len(self.patches))

    def _patches(self, picture: np.ndarray) -> tuple[int, np.ndarray]:
        """Their side, and (N, side, side, 4) patches of a picture, mirrored ones too, with how far they are seen."""
        size = len(picture)
        both = np.dstack([picture, self.seen])
        for share in _SIDES:
            side = 2 * round(share * size / 2)
            full = cv2.blur(self.seen, (side, side), borderType=cv2.BORDER_CONSTANT)
            rows, columns = np.nonzero((full > _FULL) & (self.seen > 0))
            if len(rows) >= _ENOUGH:
                chosen = self.generator.choice(len(rows), min(_CANDIDATES, len(rows)), replace=False)
                x, y = columns[chosen] - (size - 1) / 2, rows[chosen] - (size - 1) / 2
                frames = [_Frame(*place, side) for place in zip(np.hypot(x, y), np.arctan2(x, y), strict=True)]
                frames = [replace(frame, lean=_lean(frame.cut(both))) for frame in frames]
                patches = np.stack([frame.cut(both) for frame in frames])
                return side, np.concatenate([patches, patches[:, :, ::-1]])
        return 2, np.zeros((0, 2, 2, 4), np.float32)

    def frames(self) -> list[_Frame]:
        """Frames that cover the disc, the nearest to what is seen first."""
        size = len(self.canvas)
        step = _STEP * self.side
        frames = []
        for radius in np.arange(0, size / 2 + step, step):
            count = max(1, round(2 * np.pi * radius / step))
            first = self.generator.uniform()
            away = radius + step * self.generator.uniform(-_UNEVEN, _UNEVEN, count)
            frames += [_Frame(r, 2 * np.pi * (first + n) / count, self.side) for n, r in enumerate(away)]
        places = np.array([frame.matrix(size) @ [(self.side - 1) / 2, (self.side - 1) / 2, 1] for frame in frames])
        column, row = np.clip(np.round(places).astype(int), 0, size - 1).T
        away = self.far[row, column]
        return [frames[each] for each in np.argsort(away, kind="stable")]

    def lay(self, frame: _Frame) -> None:
        """Choose a patch for a frame and lay it where nothing is."""
        laid = frame.cut(self.laid)
        full = laid > 0.5
        if full.all():
            return
        before = frame.cut(self.canvas)
        chosen = self._choose(before, laid)
        patch = self.patches[chosen]
        whole = self.whole[chosen]
        # The tone of what it joins, less with the distance.
        spread = _TONE * self.side
        joined = laid * whole
        lacks = _blurred(_weighted(before - patch, joined), spread)
        patch = np.clip(patch + lacks[..., :3] / (lacks[..., 3:] + _OWN), 0, 255)
        inside = cv2.distanceTransform(full.astype(np.uint8), cv2.DIST_L2, 3)
        alpha = np.maximum(1 - inside / max(_FEATHER * self.side, 1), 0) * self.fades[chosen]
        self._paste(frame, _weighted(patch, alpha))

    def _choose(self, before: np.ndarray, laid: np.ndarray) -> int:
        given = laid[self.coarse].ravel()
        colours = before[self.coarse].reshape(-1, 3)
        whole, first, second = self.parts
        squares = (
            second @ given - 2 * first @ (given[:, None] * colours).ravel() + whole @ (given * (colours**2).sum(-1))
        )
        common = whole @ given
        differences = np.maximum(squares, 0) / np.maximum(common, 1)
        # One that fills little is hardly one.
        fills = (self.totals - common) / max((1 - given).sum(), 1e-9)
        costs = (differences + 1) * (1 + _USED * self.uses) / np.maximum(fills, 0.01) ** 2
        likely = np.flatnonzero(costs <= _LIKELY**2 * costs.min())
        chosen = int(self.generator.choice(likely))
        self.uses[[chosen, (chosen + len(self.uses) // 2) % len(self.uses)]] += 1
        return chosen

    def _paste(self, frame: _Frame, painted: np.ndarray) -> None:
        size = len(self.canvas)
        matrix = frame.matrix(size)
        middle = matrix @ [(frame.side - 1) / 2, (frame.side - 1) / 2, 1]
        left, top = (min(max(floor(place - frame.side), 0), size) for place in middle)
        right, bottom = (min(max(ceil(place + frame.side), 0), size) for place in middle)
        if right <= left or bottom <= top:
            return
        matrix[:, 2] -= left, top
        turned = cv2.warpAffine(painted, matrix, (right - left, bottom - top))
        part = np.s_[top:bottom, left:right]
        alpha = turned[..., 3:]
        self.canvas[part] = (1 - alpha) * self.canvas[part] + turned[..., :3]
        self.laid[part] = np.maximum(self.laid[part], alpha[..., 0])


def _lean(patch: np.ndarray) -> float:
    """Radians from the way down in a patch (N, N, 4), with how far it is seen, to its strands; 0 where it has none.

    Strands are where colours change least along (structure tensor, Bigun and Granlund 1987).
    """
    grey = np.ascontiguousarray(patch[..., :3].mean(-1))
    across = cv2.Sobel(grey, cv2.CV_32F, 1, 0, ksize=3)
    down = cv2.Sobel(grey, cv2.CV_32F, 0, 1, ksize=3)
    weights = cv2.erode(np.ascontiguousarray(patch[..., 3]), np.ones((3, 3)))
    both = 2 * (weights * across * down).sum()
    apart = (weights * (across**2 - down**2)).sum()
    whole = (weights * (across**2 + down**2)).sum()
    strands = np.hypot(both, apart) > _STRANDS * whole
    return float(-0.5 * np.arctan2(both, apart)) if strands else 0.0


def _weighted(colours: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(S, S, 4) float32: colours (S, S, 3) times weights (S, S), and the weights."""
    both = np.empty((*weights.shape, 4), np.float32)
    both[..., 3] = weights
    np.multiply(colours, weights[..., None], out=both[..., :3])
    return both


def _even(picture: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """A picture (S, S, 3) whose light and dark places, where it is seen (S, S), are nearer to its mean.

    A shadow that is taken with a patch is a blotch wherever the patch is laid.
    """
    tones = seen_tones(picture, seen, _BLOTCH * len(picture))
    mean = picture[seen > 0].mean(0) if seen.any() else 0
    return np.where(seen[..., None] > 0, np.clip(picture - _EVEN * (tones - mean), 0, 255), picture).astype(np.float32)


def seen_tones(picture: np.ndarray, seen: np.ndarray, spread: float) -> np.ndarray:
    """(S, S, 3) mean colours within so many pixels of a picture (S, S, 3) that is seen (S, S) from 0 to 1."""
    tones = _blurred(_weighted(picture, seen), spread)
    return tones[..., :3] / np.maximum(tones[..., 3:], 1e-3)


def _blurred(values: np.ndarray, spread: float) -> np.ndarray:
    """Values (S, S, 4), blurred by so many pixels; what is so smooth needs few of them."""
    share = max(1 / _FEW, 1 / len(values))
    small = cv2.resize(values, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    return cv2.resize(cv2.GaussianBlur(small, (0, 0), share * spread), values.shape[1::-1])
