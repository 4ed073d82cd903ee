"""How a face moves: weights of expressions over time."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError, shown
from caricli.limits import MAX_NUMBER
from caricli.structures.checks import refuse

LEAST = -0.5
MOST = 1.5
"""Range of a weight: trackers overshoot 0 and 1 a little, never this far."""

_MAX_ANGLE = 4 * np.pi
_UNIT = 1e-4


class FrameError(InputError):
    """Something is wrong with one frame of a track. frame: its number. problem: what, without the number."""

    frame = 0
    problem = ""


def _refuse_frame(frame: int, problem: str) -> None:
    error = FrameError(f"frame {frame}: {problem}")
    error.frame = frame
    error.problem = problem
    raise error


@dataclass(frozen=True, eq=False)
class Track:
    """How much of each expression a face shows over time, as a face tracker says.

    names: (N,), distinct, ARKit's in its own spelling.
    times: (T,) seconds, rising from 0 to at most MAX_NUMBER.
    weights: (T, N) from LEAST to MOST.
    head: (T, 3) yaw, pitch and roll of the head in radians as Live Link Face has them, or None.
    fps: frames a second where there is one frame; several say so by their times.
    Raises InputError when the parts do not fit each other, FrameError when a value is out of range.
    """

    names: tuple[str, ...]
    times: np.ndarray
    weights: np.ndarray
    head: np.ndarray | None = None
    fps: float = 30.0

    def __post_init__(self) -> None:
        """Check names, shapes and ranges."""
        names = self.names
        times = np.asarray(self.times)
        weights = np.asarray(self.weights)
        if not names or not all(names) or len(set(names)) < len(names):
            twice = next((name for k, name in enumerate(names) if name in names[:k]), "an empty one")
            refuse(f"names: expected distinct names, found {shown(twice, 40)!r}" + (" twice" if names else ""))
        if weights.shape != (len(times), len(names)) or not len(times):
            refuse(f"weights: expected the shape {(len(times), len(names))}, found {weights.shape}")
        bad = ~((weights >= LEAST) & (weights <= MOST))
        if bad.any():
            row, column = np.argwhere(bad)[0]
            expected = f"expected a weight from {LEAST:g} to {MOST:g}"
            _refuse_frame(int(row), f"{shown(names[column], 40)}: {expected}, found {weights[row, column]:g}")
        self._check_times(times)
        if self.head is not None:
            self._check_head(np.asarray(self.head), len(times))

    @staticmethod
    def _check_times(times: np.ndarray) -> None:
        rises = np.concatenate([times[:1] == 0, times[1:] > times[:-1]]) & (times <= MAX_NUMBER)
        if not rises.all():
            row = int(np.argmin(rises))
            _refuse_frame(row, f"expected times that rise from 0, found {times[row]:g} s")

    @staticmethod
    def _check_head(head: np.ndarray, count: int) -> None:
        if head.shape != (count, 3):
            refuse(f"head: expected the shape {(count, 3)}, found {head.shape}")
        bad = ~(np.abs(head) <= _MAX_ANGLE).all(1)
        if bad.any():
            row = int(np.argmax(bad))
            _refuse_frame(row, f"expected angles of the head in radians, found {head[row]}")


@dataclass(frozen=True)
class Clip:
    """What is known of an animation without reading its values.

    name: as its file says, or "". length: seconds to its last frame. frames: how many moments are given.
    """

    name: str
    length: float
    frames: int


@dataclass(frozen=True, eq=False)
class Animation:
    """How a rig moves.

    times: (T,) seconds, rising, from 0 on.
    weights: (T, K) of the rig's shapes in its order.
    rotations: (T, 4) of the head, unit quaternions xyzw, or None.
    Raises InputError when the parts do not fit each other or hold what is not finite.
    """

    times: np.ndarray
    weights: np.ndarray
    rotations: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        times = np.asarray(self.times, np.float32)
        weights = np.asarray(self.weights, np.float32)
        if times.ndim != 1 or not len(times) or not np.isfinite(times).all() or times[0] < 0:
            refuse("times: expected seconds that rise from 0 on, found others")
        if (np.diff(times) <= 0).any():
            refuse("times: expected seconds that rise from 0 on, found others")
        if weights.ndim != 2 or len(weights) != len(times) or not np.isfinite(weights).all():
            refuse(f"weights: expected finite numbers for {len(times)} frames, found {weights.shape} or others")
        if self.rotations is not None:
            rotations = np.asarray(self.rotations, np.float64)
            sound = rotations.shape == (len(times), 4) and np.isfinite(rotations).all()
            if not sound or np.abs(np.linalg.norm(rotations, axis=1) - 1).max() > _UNIT:
                refuse(f"rotations: expected unit quaternions {(len(times), 4)}, found {rotations.shape} or others")
