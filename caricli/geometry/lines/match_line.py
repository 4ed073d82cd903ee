"""Where the points of a line lie along another one that was drawn for it."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.lines.rows_at import rows_at

_FINEST = 8
"""Samples of a drawn line for each point that is looked for, within ``_SAMPLES``."""
_SAMPLES = (64, 320)
"""Of a line: least, and most where these are not fewer than ``_COARSEST`` for each point."""
_COARSEST = 3
"""Samples for each point, at least, however many points there are: a step takes one or more."""
_SKIPPED = 1e-9
"""Of a line's length: points nearer to each other are one."""


@dataclass(frozen=True)
class MatchSettings:
    """What points lie where along a line.

    place: weight of a point's distance to where it was, in lengths of the drawn line, squared. turn: weight of the
    difference of directions, one minus their cosine. stretch: weight of steps that are longer or shorter than before.
    left_out: cost of the part of the line that was not drawn, for each share of its length. widest: steps become at
    most so many times longer, and as many times shorter.
    """

    place: float = 4.0
    turn: float = 0.5
    stretch: float = 0.1
    left_out: float = 0.01
    widest: float = 3.0


def match_line(
    points: np.ndarray,
    drawn: np.ndarray,
    whole: bool,
    settings: MatchSettings = MatchSettings(),  # noqa: B008 (frozen)
) -> np.ndarray:
    """Places along a drawn line for the points of a line, in their order (dynamic time warping).

    Minimises over monotone t ``sum_i a_i (place |q(t_i) - p_i|^2 + turn (1 - cos angle_i) + stretch (r_i - 1)^2)``, a_i
    the share of the line's length that a point stands for, r_i by how much the step to it is stretched, lengths in
    those of the drawn line. All of the drawn line is used. Points are compared after the affine map that takes a whole
    line nearest to the drawn one, so that what is drawn larger or elsewhere counts as the same shape.

    points: (K, 2) of the line, at least two. drawn: (N, 2), in the same direction, of some length. whole: whether all
    of the line was drawn; else its ends may be left out.
    Returns (K, 2), NaN for points that were left out.
    """
    steps = _steps(points)
    length = _steps(drawn).sum()
    samples = max(int(np.clip(_FINEST * len(points), *_SAMPLES)), _COARSEST * len(points))
    line = resample(drawn, samples + 1)
    if whole:
        share = np.concatenate([[0], np.cumsum(steps)]) / max(steps.sum(), _SKIPPED)
        there = line[np.rint(share * samples).astype(int)]
        points = _affine(points, there)
        steps = steps * (length / max(steps.sum(), _SKIPPED))
    origin = line[0]
    warp = _Warp((points - origin) / length, (line - origin) / length, steps / length, settings)
    rows = warp.whole() if whole else warp.part()
    if rows is None:  # far longer than the line was expected to be
        return match_line(points, drawn, True, settings)
    return np.where((rows < 0)[:, None], np.nan, line[rows])


def resample(line: np.ndarray, count: int) -> np.ndarray:
    """Points (count, 2) at equal distances along a line (N, 2) of some length, its ends among them."""
    places = np.zeros(len(line))
    np.cumsum(_steps(line), out=places[1:])
    wanted = np.arange(count) * (places[-1] / (count - 1))
    return rows_at(wanted, places, line)


def _steps(line: np.ndarray) -> np.ndarray:
    return np.hypot(*(line[1:] - line[:-1]).T)


def _affine(points: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Points (K, 2) after the affine map that takes them nearest to their goals (K, 2)."""
    mean = points.mean(0)
    centred = points - mean
    # A straight line does not tell what happens across it: there nothing does.
    ridge = 1e-3 * (centred**2).sum() * np.eye(2)
    move = np.linalg.solve(centred.T @ centred + ridge, centred.T @ (goals - goals.mean(0) - centred))
    return goals.mean(0) + centred + centred @ move


def _directions(line: np.ndarray) -> np.ndarray:
    """(K, 2) unit vectors along a line, at its points."""
    along = np.empty_like(line)
    along[1:-1] = (line[2:] - line[:-2]) / 2
    along[0] = line[1] - line[0]
    along[-1] = line[-1] - line[-2]
    return along / np.maximum(np.hypot(along[:, 0], along[:, 1]), _SKIPPED)[:, None]


class _Warp:
    """Costs of points (K) at samples (M + 1) of a line, everything in lengths of this line."""

    def __init__(self, points: np.ndarray, line: np.ndarray, steps: np.ndarray, settings: MatchSettings) -> None:
        """steps: (K - 1,) between the points, as the line is expected to show them."""
        self.settings = settings
        self.steps = np.maximum(steps, _SKIPPED)
        around = np.concatenate([[0], steps, [0]])
        share = (around[1:] + around[:-1]) / 2
        # Squared distances and cosines of angles in one product.
        place, turn = settings.place, settings.turn
        both = np.hstack([2 * place * points, turn * _directions(points)]) @ np.hstack([line, _directions(line)]).T
        alone = place * ((points**2).sum(1)[:, None] + (line**2).sum(1)) + turn
        self.costs = (share[:, None] * (alone - both)).astype(np.float32)
        self.skips = settings.left_out * np.concatenate([[0], np.cumsum(steps)])
        self.last = len(line) - 1
        usual = self.steps * self.last
        least = np.maximum(np.floor(usual / settings.widest), 1).astype(int)
        most = np.maximum(np.minimum(np.ceil(usual * settings.widest).astype(int), self.last), least + 1)
        # Least and most samples of every step.
        self.windows = list(zip(least.tolist(), most.tolist(), strict=True))
        reach = least[:, None] + np.arange((most - least).max() + 1)
        # (K - 1, N) what a step costs with so many samples, from the least on.
        stretches = settings.stretch * self.steps[:, None] * (reach / usual[:, None] - 1) ** 2
        self.stretches = stretches.astype(np.float32)

    def whole(self) -> np.ndarray:
        """(K,) samples, from the first to the last."""
        totals, begins = self._run(free=False)
        return self._back(totals, begins, len(self.costs) - 1)

    def part(self) -> np.ndarray | None:
        """(K,) samples, -1 for points before the first sample and after the last; None where steps are too short."""
        totals, begins = self._run(free=True)
        ends = totals[:, self.last] + self.skips[-1] - self.skips
        if not np.isfinite(ends).any():
            return None
        return self._back(totals, begins, int(np.argmin(ends)))

    def _run(self, free: bool) -> tuple[np.ndarray, np.ndarray]:
        """Least costs (K, M + 1) of reaching a sample with a point, and (K,) whether the way to the first begins there.

        free: whether points may be left out before.
        """
        totals = np.full_like(self.costs, np.inf)
        totals[0, 0] = self.costs[0, 0]
        begins = np.arange(len(totals)) == 0
        room = max(high for _, high in self.windows)
        before = np.full(room + self.last + 1, np.inf, np.float32)
        size = before.itemsize
        for k, (low, high) in enumerate(self.windows, 1):
            before[room:] = totals[k - 1]
            # In row r of this view stand the costs of r + low samples before.
            shape = (high - low + 1, self.last + 1)
            choices = np.ndarray(shape, np.float32, before, (room - low) * size, (-size, size))
            totals[k] = (choices + self.stretches[k - 1, : len(choices), None]).min(0) + self.costs[k]
            if free and self.skips[k] + self.costs[k, 0] < totals[k, 0]:
                totals[k, 0] = self.skips[k] + self.costs[k, 0]
                begins[k] = True
        return totals, begins

    def _back(self, totals: np.ndarray, begins: np.ndarray, point: int) -> np.ndarray:
        """(K,) samples of a way that ends with a point at the last sample."""
        rows = np.full(len(totals), -1)
        sample = self.last
        while True:
            rows[point] = sample
            if sample == 0 and begins[point]:
                return rows
            point -= 1
            low, high = self.windows[point]
            choices = totals[point, max(sample - high, 0) : sample - low + 1][::-1]
            sample -= low + int((choices + self.stretches[point, : len(choices)]).argmin())
