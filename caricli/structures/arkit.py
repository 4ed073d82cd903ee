"""The names of the 52 facial actions of ARKit, which every engine's face tracking speaks, and what they start from."""

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

import numpy as np

ARKIT_NAMES = tuple(
    "eyeBlinkLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft eyeLookUpLeft eyeSquintLeft eyeWideLeft "
    "eyeBlinkRight eyeLookDownRight eyeLookInRight eyeLookOutRight eyeLookUpRight eyeSquintRight eyeWideRight "
    "jawForward jawRight jawLeft jawOpen mouthClose mouthFunnel mouthPucker mouthRight mouthLeft mouthSmileLeft "
    "mouthSmileRight mouthFrownLeft mouthFrownRight mouthDimpleLeft mouthDimpleRight mouthStretchLeft "
    "mouthStretchRight mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper mouthPressLeft mouthPressRight "
    "mouthLowerDownLeft mouthLowerDownRight mouthUpperUpLeft mouthUpperUpRight browDownLeft browDownRight browInnerUp "
    "browOuterUpLeft browOuterUpRight cheekPuff cheekSquintLeft cheekSquintRight noseSneerLeft noseSneerRight "
    "tongueOut".split()
)
"""In ARKit's spelling and the order of Live Link Face's columns, which write the first letter as a capital."""

STARTS = {"mouthClose": "jawOpen"}
"""Actions that only mean something on top of others: mouthClose closes the lips while the jaw is open."""

CLOSES_TOO = {"eyeSquintLeft": "eyeBlinkLeft", "eyeSquintRight": "eyeBlinkRight"}
"""Actions that close what another closes as well: a squint raises the lower lid through the upper one of a blink."""

SQUINT_ROOM = 3.0
"""Weight of a squint, to one that a blink lacks to its whole: of the way to the other lid a squint goes a third."""

OPPOSITES = {"jawLeft": "jawRight", "mouthLeft": "mouthRight"} | {
    one + side: other + side
    for one, other in (("mouthSmile", "mouthFrown"), ("eyeLookUp", "eyeLookDown"), ("eyeLookIn", "eyeLookOut"))
    for side in ("Left", "Right")
}
"""Actions that nobody does at once, though both together can look like a wider jaw or mouth."""


Expressions = Mapping[str, Mapping[str, float]]
"""By the names of expressions the weights of the actions, by name, that they are made of."""


_PLAIN = {name.lower(): name for name in ARKIT_NAMES}


def arkit_name(name: str) -> str | None:
    """The ARKit name that a name means, or None; of half an action, such as ``browInnerUp_L``, the whole one's.

    Case, spaces and other separators, a prefix such as ``blendShape1.``, and the suffixes L and R are seen through.
    """
    if name in ARKIT_NAMES:
        return name
    plain = plain_name(name)
    return _PLAIN.get(plain) or _PLAIN.get(re.sub("(left|right)$", "", plain))


def arkit_sides(name: str) -> tuple[str, str] | None:
    """The ARKit names of the left and the right action that a name without a side means, such as ``mouthSmile``.

    None where it means none of its own, and where both undo each other, as left and right of a mouth do.
    """
    left, right = (_PLAIN.get(plain_name(name) + side) for side in ("left", "right"))
    if left is None or right is None or OPPOSITES.get(left) == right:
        return None
    return left, right


def plain_name(name: str) -> str:
    """A name in small letters alone, without a prefix, its side written out."""
    # Separators are looked at from their first one only, or a name of nothing else takes their number squared.
    last = r"(?<=[a-z])(?:L|R)$|(?<![\W_])[\W_]+[lLrR]$"
    side = re.sub(last, lambda m: {"l": "Left", "r": "Right"}[m[0][-1].lower()], name)
    return re.sub(r"[\W_]+", "", re.split(r"[.:|]", side)[-1]).lower()


def is_half(name: str) -> bool:
    """Whether a name means one side of an action that ARKit has only as a whole."""
    whole = arkit_name(name)
    return whole is not None and plain_name(name) != whole.lower()


def start_of(name: str) -> str:
    """The action that what a name means starts from, see ``STARTS``; empty where it starts from none."""
    return STARTS.get(arkit_name(name) or "", "")


def start_delta(names: Sequence[str], deltas: np.ndarray, k: int) -> np.ndarray:
    """What expression k is added to besides the neutral face: the displacements (V, 3) of another one, or zeros.

    names: (K,) of expressions, see ``arkit_name``. deltas: (K, V, 3) of each alone.
    """
    return deltas[_doing(start_of(names[k]), names)].sum(0)


def _doing(action: str, names: Sequence[str]) -> list[int]:
    """Numbers of the expressions, (K,) names, that do an action together: the one that does it whole, or its halves."""
    alike = [k for k, name in enumerate(names) if action and arkit_name(name) == action]
    return [k for k in alike if not is_half(names[k])][:1] or alike


def within_reach(weights: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Weights (T, K) of actions, none above what another, where there is that, opens or leaves open to it.

    names: (K,) that mean them, see ``arkit_name``; of two halves of one the stronger counts.
    """
    actions = [arkit_name(name) for name in names]

    def strongest(action: str) -> np.ndarray:
        return weights[:, [each == action for each in actions]].max(axis=1)

    room = np.full_like(weights, np.inf)
    for k, action in enumerate(actions):
        start, closing = STARTS.get(action or ""), CLOSES_TOO.get(action or "")
        if start is not None and start in actions:
            room[:, k] = strongest(start)
        if closing is not None and closing in actions:
            room[:, k] = SQUINT_ROOM * np.maximum(1 - strongest(closing), 0)
    return np.minimum(weights, room)


def reachable(weights: Mapping[str, float]) -> dict[str, float]:
    """Weights of actions by their ARKit names, as of ``within_reach``, where those that are not named do nothing."""
    every = np.array([[weights.get(name, 0.0) for name in ARKIT_NAMES]])
    reached = dict(zip(ARKIT_NAMES, within_reach(every, ARKIT_NAMES)[0].tolist(), strict=True))
    return {name: reached[name] for name in weights}


def opposites(names: Sequence[str]) -> tuple[tuple[int, int], ...]:
    """Pairs of numbers of expressions that are ``OPPOSITES``. names: (K,) of expressions, see ``arkit_name``."""
    both = [product(_doing(one, names), _doing(other, names)) for one, other in OPPOSITES.items()]
    return tuple(pair for pairs in both for pair in pairs)


def alone(names: Iterable[str]) -> dict[str, dict[str, float]]:
    """Expressions that are each one action, of the same name."""
    return {name: {name: 1.0} for name in names}


def action_codes(expressions: Sequence[Mapping[str, float]]) -> np.ndarray:
    """(K, 52) float32: of expressions, each weights of actions by name, the weights in ARKit's order."""
    return np.array([[weights.get(name, 0.0) for name in ARKIT_NAMES] for weights in expressions], np.float32)


def uses(names: Sequence[str]) -> np.ndarray:
    """(K, K) the weights of expressions that using one of them means: its own, and that of what it starts from.

    names: (K,) of expressions, see ``arkit_name``.
    """
    weights = np.eye(len(names))
    for k, name in enumerate(names):
        weights[k, _doing(start_of(name), names)] = 1
    return weights
