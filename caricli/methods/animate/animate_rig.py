"""A rig that moves as a track of weights says."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

import numpy as np
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.methods.animate.bind_weights import BoundWeights, bind_weights
from caricli.methods.animate.pose_rig import RigPoser
from caricli.methods.animate.resample_weights import resample_weights
from caricli.methods.animate.smooth_weights import smooth_weights
from caricli.methods.animate.turn_head import turn_head, within_half_turns
from caricli.structures import Animation, Rig, Track
from caricli.structures.arkit import arkit_name, start_of, within_reach


@dataclass(frozen=True)
class AnimationSettings:
    """How a track becomes an animation.

    fps: frames a second; None for the track's own.
    smooth: strength of the One-Euro filter; 1 is usual, 0 leaves the weights.
    scales: factors of weights by expression; what starts from another goes by that one's, unless it has its own.
    head: whether the head turns.
    """

    fps: float | None = None
    smooth: float = 0.0
    scales: dict[str, float] = field(default_factory=dict)
    head: bool = True


@dataclass(frozen=True, eq=False)
class Performance:
    """A rig and how it moves.

    animation: times, weights and the turning of the head of every frame.
    fps: frames a second.
    bound: the weights as the track has them, before they were cut and scaled.
    settings: what was asked for.
    """

    rig: Rig
    animation: Animation
    fps: float
    bound: BoundWeights
    settings: AnimationSettings

    def frames(self, report: Callable[[int, int], object]) -> Iterator[np.ndarray]:
        """Vertices (V, 3) of every frame, the head turned; each is overwritten by the next.

        report: called with the number of frames that are done, and of all.
        """
        poser = RigPoser(self.rig)
        rotations = self.animation.rotations
        turns = None if rotations is None else Rotation.from_quat(rotations).as_matrix()
        for k, weights in enumerate(self.animation.weights):
            vertices = poser.pose(weights)
            yield vertices if turns is None else vertices @ turns[k].T
            report(k + 1, len(self.animation.weights))

    @property
    def driven(self) -> list[int]:
        """Numbers of the rig's expressions that the track moves."""
        return [k for k, name in enumerate(self.rig.names) if name not in self.bound.undriven]

    def figures(self) -> dict:
        """What was done, as JSON holds it."""
        weights = self.animation.weights
        bound = self.bound.weights
        return {
            "fps": self.fps,
            "frames": len(self.animation.times),
            "length": float(self.animation.times[-1]),
            "smooth": self.settings.smooth,
            "scale": self.settings.scales,
            "head": self.animation.rotations is not None,
            "unmatched": self.bound.unmatched,
            "undriven": self.bound.undriven,
            "clipped": int(np.count_nonzero((bound < 0) | (bound > 1))),
            "ranges": {
                self.rig.names[k]: [float(weights[:, k].min()), float(weights[:, k].max())] for k in self.driven
            },
        }


def animate_rig(
    rig: Rig,
    track: Track,
    settings: AnimationSettings = AnimationSettings(),  # noqa: B008 (frozen)
) -> Performance:
    """Move a rig by a track: weights are smoothed, resampled, bound by name, cut to 0 to 1, scaled, then limited.

    What only means something on top of another action goes no further than that: ``mouthClose`` undoes what ``jawOpen``
    opens, and alone would pull the chin over the lips. Nor does what closes lids with a blink go further than they are
    open: ``eyeSquint`` alone would raise the lower lid over the upper one.
    Raises InputError as ``check_rig``, and when no name is common, or frames are too many.
    """
    check_rig(rig, settings)
    head = track.head if settings.head else None
    if head is not None:
        head = within_half_turns(smooth_weights(np.unwrap(head, axis=0), track.times, settings.smooth))
    calm = smooth_weights(track.weights, track.times, settings.smooth)
    even, fps = resample_weights(replace(track, weights=calm, head=head), settings.fps)
    bound = bind_weights(even, rig.names)
    weights = within_reach(_scales(rig.names, settings.scales) * np.clip(bound.weights, 0, 1), rig.names)
    rotations = None if even.head is None else turn_head(even.head)
    return Performance(rig, Animation(even.times, weights, rotations), fps, bound, settings)


def check_rig(rig: Rig, settings: AnimationSettings) -> None:
    """Raise InputError when a rig has no expressions, or one that is scaled is not the rig's."""
    if not rig.names:
        raise InputError("expected a rig with expressions, found one without")
    unknown = [name for name in settings.scales if name not in rig.names]
    if unknown:
        near = get_close_matches(unknown[0], rig.names, 1, 0.0)[0]
        raise InputError(f"scale: {unknown[0]}: not among the rig's {len(rig.names)}; did you mean {near!r}?")


def _scales(names: Sequence[str], given: Mapping[str, float]) -> np.ndarray:
    """(K,) factors of expressions of a rig. given: some of them, by name."""
    actions = {arkit_name(name): scale for name, scale in given.items()}
    return np.array([given.get(name, actions.get(start_of(name), 1.0)) for name in names])
