"""Speech from mouth cues and visemes: shapes that run into each other, and lips that close where they must."""

from dataclasses import dataclass

import numpy as np

from caricli.data.expressions import mouth_shapes
from caricli.errors import InputError
from caricli.io.takes.track import MAX_FRAMES
from caricli.structures import Cues, Track
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.cues import SHAPES

CLOSED = ("viseme_PP", "rhubarb_A")
"""Shapes of closed lips."""

BITTEN = ("viseme_FF", "rhubarb_G")
"""Shapes of the lower lip at the upper teeth."""


@dataclass(frozen=True)
class SpeechSettings:
    """How a mouth goes from shape to shape; seconds.

    transition: length of the window that smooths all: how long a mouth takes from one vowel to the next. closing: how
    long lips take to close or to part, and to reach the teeth. hold: how long they stay there at least.
    """

    transition: float = 0.15
    closing: float = 0.08
    hold: float = 0.05


def speak_cues(cues: Cues, rate: float) -> Track:
    """The Track of a mouth that says cues.

    Every shape has a dominance over time, after Cohen and Massaro (1993): its cue, smoothed by a Hann window. The
    dominances add up to one, so shapes blend, a short one is reached less than a long one, and no weight jumps or
    overshoots. Sounds that need the lips, p, b, m and f, v, are made whole however short they are: in the middle of
    their cue the other shapes yield to them.

    rate: frames a second. Raises InputError for more frames than a track can have.
    """
    count = int(np.floor(cues.end * rate + 1e-6)) + 1
    if count > MAX_FRAMES:
        raise InputError(f"expected at most {MAX_FRAMES} frames, found {cues.end:g} seconds at {rate:g} a second")
    times = np.arange(count) / rate
    # No contact may fall between two frames.
    settings = SpeechSettings(hold=max(SpeechSettings.hold, 1 / rate))
    return act_visemes(Track(SHAPES, times, _dominances(cues, times, settings)))


def act_visemes(track: Track) -> Track:
    """A track of mouth shapes, of SHAPES, as one of ARKit's actions.

    ``weights = shapes @ table``; then ``mouthClose = closed jawOpen``, where closed is the weight of closed lips: it
    takes back as much as the jaw opens them.
    """
    table = mouth_shapes(ARKIT_NAMES)
    used = [name for name in ARKIT_NAMES if any(name in actions for actions in table.values())]
    matrix = np.array([[table[shape].get(name, 0.0) for name in used] for shape in track.names])
    shares = np.clip(track.weights, 0, 1)
    weights = shares @ matrix
    closed = shares[:, [name in CLOSED for name in track.names]].sum(1)
    close = np.clip(closed, 0, 1) * weights[:, used.index("jawOpen")]
    return Track((*used, "mouthClose"), track.times, np.clip(np.column_stack([weights, close]), 0, 1), track.head)


def _dominances(cues: Cues, times: np.ndarray, settings: SpeechSettings) -> np.ndarray:
    """(T, len(SHAPES)) from 0 to 1, rows of sum one."""
    shares = np.zeros((len(times), len(SHAPES)))
    edges = np.append(cues.starts, cues.end)
    # The mouth has been as at the beginning before it, and stays as at the end.
    edges[0] = -np.inf
    edges[-1] = np.inf
    reach = settings.transition / 2
    for name, start, end in zip(cues.names, edges[:-1], edges[1:], strict=True):
        rows = slice(*np.searchsorted(times, (start - reach, end + reach)))
        here = times[rows]
        shares[rows, SHAPES.index(name)] += _eased(here - start, reach) - _eased(here - end, reach)
    closed = _contacts(cues, times, CLOSED, settings)
    bitten = _contacts(cues, times, BITTEN, settings) * (1 - closed.sum(1, keepdims=True))
    held = closed + bitten
    return shares * (1 - held.sum(1, keepdims=True)) + held


def _contacts(cues: Cues, times: np.ndarray, shapes: tuple[str, ...], settings: SpeechSettings) -> np.ndarray:
    """(T, len(SHAPES)) how far shapes of contact are made, 1 in the middle of their cues, rows of sum at most one."""
    apart = np.ones((len(times), len(SHAPES)))
    edges = np.append(cues.starts, cues.end)
    for name, start, end in zip(cues.names, edges[:-1], edges[1:], strict=True):
        if name in shapes:
            middle = (start + end) / 2
            half = max(settings.hold, (end - start) / 2) / 2
            reach = half + settings.closing
            rows = slice(*np.searchsorted(times, (middle - reach, middle + reach)))
            away = np.abs(times[rows] - middle) - half - settings.closing / 2
            apart[rows, SHAPES.index(name)] *= _eased(away, settings.closing / 2)
    made_by = 1 - apart
    return made_by / np.maximum(made_by.sum(1, keepdims=True), 1)


def _eased(seconds: np.ndarray, reach: float) -> np.ndarray:
    """A step from 0 to 1 that takes from -reach to reach: the integral of a Hann window."""
    turn = np.clip(seconds / reach, -1, 1)
    return 0.5 * (1 + turn + np.sin(np.pi * turn) / np.pi)
