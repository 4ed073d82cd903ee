"""The picture on a shell of hair."""

import cv2
import numpy as np

from caricli.geometry.smooth_step import smooth_step
from caricli.methods.hair.continue_strands import continue_strands, seen_tones
from caricli.methods.texture.picture_view import PictureView, SeenColours, SurfacePoints
from caricli.methods.texture.texels import Texels
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Hair

_STRANGE = 3.5  # of the median distance from the median colour
_NEVER_STRANGE = 6.0  # CIELAB
_SPECK = 7  # texels of those in which strands are continued: what is seen in less of them is not shown
_PART = 0.1  # of the largest part that is seen, what another has to have to count
_SOFT = 6.0  # of the same, over which what is seen goes over into continued strands
_SIDE = 384  # texels, at most, in which strands are continued
_SHADE = 0.06  # of the picture, over which what is darker or lighter is in shade or light
_TAKEN = 0.6  # power of what it is darker or lighter by, that is taken out
_SPREAD = (10.0, 0.35)  # levels of 255, and share of the mean: how far from the usual colour hair may be
_DARKEST = 4.0  # levels of 255, below which nothing is told of light


def paint_hair(hair: Hair, view: PictureView, size: int, generator: np.random.Generator) -> np.ndarray:
    """Paint a shell with the picture where the picture shows it, and with strands continued from there elsewhere.

    hair: Hair of `make_shell`, whose strands run from the whorl in the middle of its picture outwards.
    view: PictureView of its shell. size: texels. generator: of the choice of strands.
    Returns (size, size, 3) uint8.
    """
    look = _look(hair, view, size)
    side = min(size, _SIDE)
    colours = cv2.resize(look.colours, (side, side), interpolation=cv2.INTER_AREA)
    trust = view.settings.trust
    seen = cv2.resize(look.seen, (side, side), interpolation=cv2.INTER_AREA) > trust
    seen = _inner(seen & _usual(colours, _inner(seen)))
    shown = look.colours
    if not view.settings.keep_light:
        gain = _gain(colours, seen)
        colours = _lit(colours, gain)
        shown = _lit(shown, cv2.resize(gain, (size, size), interpolation=cv2.INTER_LINEAR))
        usual_colour = colours[seen].mean(0) if seen.any() else colours.mean((0, 1))
        colours = _calm(colours, usual_colour)
        shown = np.maximum(shown, _calm(shown, usual_colour))
    elsewhere = cv2.resize(continue_strands(colours, seen, generator), (size, size), interpolation=cv2.INTER_CUBIC)
    # What is seen and unusual, as skin at the border, is not hair's.
    usual = cv2.GaussianBlur(seen.astype(np.float32), (0, 0), _SOFT)
    usual = cv2.resize(usual, (size, size), interpolation=cv2.INTER_LINEAR)
    share = smooth_step(np.minimum(look.seen / trust, 2 * usual - 1), 0, 1)[..., None]
    return np.clip(np.round(share * shown + (1 - share) * elsewhere), 0, 255).astype(np.uint8)


def _gain(colours: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """(S, S) float32, how many times as bright colours (S, S, 3) get where shade or light on them is taken out.

    seen: (S, S) bool, colours that count."""
    if not seen.any():
        return np.ones(seen.shape, np.float32)
    tones = seen_tones(colours, seen.astype(np.float32), _SHADE * len(seen)).mean(-1)
    gain: np.ndarray = ((colours[seen].mean() + _DARKEST) / (tones + _DARKEST)) ** _TAKEN
    return gain.astype(np.float32)


def _calm(colours: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Colours (S, S, 3) with what is much lighter or darker than a usual one (3,) brought nearer to it.

    A highlight that comes again and again all over a head is a speck, and a deep shade seen from aside a hole.
    """
    light = colours.mean(-1, keepdims=True)
    mean = usual.mean()
    most = _SPREAD[0] + _SPREAD[1] * mean
    nearer = mean + most * np.tanh((light - mean) / most)
    calm: np.ndarray = np.clip(colours + (nearer - light) * (usual + 1) / (mean + 1), 0, 255).astype(np.float32)
    return calm


def _lit(colours: np.ndarray, gain: np.ndarray) -> np.ndarray:
    return np.clip(gain[..., None] * colours, 0, 255).astype(np.float32)


def _inner(seen: np.ndarray) -> np.ndarray:
    """What is seen (R, C) without its border, where colours are mixed with what is beside hair, and without specks and
    small parts, as at the sides, where strands would begin and end."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (_SPECK, _SPECK))
    inner = cv2.morphologyEx(cv2.erode(seen.astype(np.uint8), np.ones((3, 3), np.uint8)), cv2.MORPH_OPEN, disc)
    if not inner.any():
        return seen
    _, parts, figures, _ = cv2.connectedComponentsWithStats(inner)
    areas = figures[:, cv2.CC_STAT_AREA]
    large = areas >= _PART * areas[1:].max()
    large[0] = False
    return large[parts]


def _look(hair: Hair, view: PictureView, size: int) -> SeenColours:
    """What the picture shows of the texels: colours (size, size, 3), seen (size, size)."""
    shell = hair.shell
    texels = Texels(shell, size)
    columns = np.column_stack([shell.vertices, smooth_normals(shell.vertices, shell.faces)]).astype(np.float32)
    points = texels.mix @ columns
    looked = view.look(SurfacePoints(points[:, :3], points[:, 3:], np.zeros(len(points), np.float32), scalp=1.0))
    return SeenColours(looked.colours[texels.owner], looked.seen[texels.owner].astype(np.float32))


def _usual(colours: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Which of colours (R, C, 3) are like most that are seen (R, C): skin at the border of hair is not continued."""
    if not seen.any():
        return seen
    lab = cv2.cvtColor(colours / np.float32(255), cv2.COLOR_RGB2LAB)
    away = np.linalg.norm(lab - np.median(lab[seen], axis=0), axis=-1)
    return away <= _STRANGE * np.median(away[seen]) + _NEVER_STRANGE
