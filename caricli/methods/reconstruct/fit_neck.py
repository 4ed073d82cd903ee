"""How wide the neck of a head is in its picture."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.methods.texture.collar import find_collar
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.structures import Camera, Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import POINT_NAMES
from caricli.structures.parsing import Region
from caricli.template.template import Template

_OUTSIDE = 255
"""What is beyond the picture, among the values of Region."""

_HIDING = (Region.SKIN, Region.BEARD, Region.EARS, Region.OTHER, _OUTSIDE)
"""What a neck may go on behind."""

_WAYS = 65
"""Places on a way from the outside of a neck to its middle."""


@dataclass(frozen=True)
class NeckSettings:
    """When a neck is seen, and how far it is believed.

    Lengths are shares of the head's height in the picture. step: between the lines across a neck, and along them.
    above, below: the chin, where necks are looked for. aside: how far lines go on either side. least: of a neck's lines
    that are seen. flare: times the narrowest line above it, from which on one shows shoulders or clothes. thin, usual:
    of the width of the head's neck, down to which what is seen is believed less and less, since collars hide what is
    beside it, and from which on not at all. thinnest: of it, what it is brought to at least; alike: from where on it
    stays as it is. lightness: how much it counts in telling clothes from skin, which is in the shadow of the chin.
    weight, outer: of the neck's weights, and shares of its half width, above which its vertices may not stand before
    what is behind the head; several: of them that do at least, on a side; quantile: of what they call for. frontal:
    cosine of a head's turn, below which nothing is told of its neck.
    """

    step: float = 1 / 300
    above: float = 0.3
    below: float = 0.3
    aside: float = 0.8
    least: float = 0.02
    flare: float = 1.3
    thin: float = 0.6
    usual: float = 0.85
    thinnest: float = 0.35
    alike: float = 0.95
    lightness: float = 0.3
    weight: float = 0.25
    outer: float = 0.6
    several: int = 10
    quantile: float = 0.25
    frontal: float = 0.5


_SETTINGS = NeckSettings()


@dataclass(frozen=True, eq=False)
class _Axes:
    """Of a head in its picture. across, down: (2,) of unit length. start: (2,) pixels, its chin. height: pixels."""

    across: np.ndarray
    down: np.ndarray
    start: np.ndarray
    height: float

    @staticmethod
    def of(places: np.ndarray, camera: Camera, template: Template) -> "_Axes":
        """Of a head whose vertices are at pixels (V, 2), seen by a Camera, not from its side."""
        across = camera.rotation[:2, 0] / np.linalg.norm(camera.rotation[:2, 0])
        down = np.array([-across[1], across[0]])
        chin = places[template.annotation.landmarks[POINT_NAMES["chin"]]]
        return _Axes(across, down, chin, float(np.ptp(places @ down)))


def fit_neck(face: Face, template: Template, picture: ParsedPicture) -> tuple[Face, float]:
    """A face whose neck is as thin as its picture shows it, and where it does.

    Landmarks end at the jaw, and what they tell of a neck is a usual one: drawings put large heads on thin necks. Below
    the chin lines across the neck are read from its labels, from where the jaw hides neither side of it down to where
    shoulders or clothes begin; the widest is the width of the neck, and the edge of the head gets it. Where the
    picture shows what is behind the head beside the jaw, the neck does not stand before that, either.

    face: Face with the camera of the picture. template: of its topology. picture: with its regions.
    Returns the Face, and how many times as wide its neck is: the same one and 1 where no neck is seen that is thinner
    than the head's. A wider one is easily clothes.
    """
    camera = face.require_camera()
    frontal = np.linalg.norm(camera.rotation[:2, 0])
    if not len(template.neck.edge) or picture.regions is None or frontal < _SETTINGS.frontal:
        return face, 1.0
    places = camera.project(face.vertices)
    axes = _Axes.of(places, camera, template)
    edge = places[template.neck.edge] @ axes.across
    own = np.array([edge.min(), edge.max()])
    seen = min((_below(picture, axes, own), _beside(picture.regions, template, places, axes, own)), key=np.ptp)
    times = max(float(np.ptp(seen) / np.ptp(own)), _SETTINGS.thinnest)
    if times > _SETTINGS.alike:
        return face, 1.0
    shift = (seen.mean() - own.mean()) / camera.scale * axes.across @ camera.rotation[:2]
    return face.with_vertices(template.neck.widen(face.vertices, times, shift)), times


def _below(picture: ParsedPicture, axes: _Axes, own: np.ndarray) -> np.ndarray:
    """Where a neck begins and ends (2,), pixels across, by what is seen below the chin. own: (2,) of the head's."""
    assert picture.regions is not None
    everywhere = np.ones(picture.regions.shape, bool)
    collar = find_collar(picture.regions, everywhere, picture.pixels, _SETTINGS.lightness)
    seen = _sides(np.where(collar, np.uint8(Region.CLOTH), picture.regions), axes)
    if seen is None:
        return own
    chin = float(axes.start @ axes.across)
    sides = chin + seen
    if sides[0] > max(chin, own.mean()) or sides[1] < min(chin, own.mean()):
        # No neck is beside both the chin and where the head has it.
        return own
    believed = np.interp(np.ptp(sides) / np.ptp(own), (_SETTINGS.thin, _SETTINGS.usual), (1, 0))
    return own + believed * (sides - own)


def _beside(regions: np.ndarray, template: Template, places: np.ndarray, axes: _Axes, own: np.ndarray) -> np.ndarray:
    """The same by where nothing of the head is seen beside the jaw. places: (V, 2) pixels of the head's vertices.

    What would stand there says how far the neck's side has to come in, so that by its weight it comes to the nearest
    of the head on the way to the middle.
    """
    weights = template.neck.weights
    aside = (places @ axes.across - own.mean()) / (np.ptp(own) / 2)
    outer = (weights > _SETTINGS.weight) & (np.abs(aside) > _SETTINGS.outer)
    shares = np.linspace(0, 1, _WAYS)
    ways = places[outer, None] - shares[:, None] * (aside[outer] * np.ptp(own) / 2)[:, None, None] * axes.across
    x, y = ways.reshape(-1, 2).T
    behind = sample_pixels(regions, x, y, cv2.INTER_NEAREST, _OUTSIDE).reshape(-1, _WAYS) == Region.BACKGROUND
    wanted = 1 - shares[np.argmin(behind, axis=1)] / weights[outer]
    stands_out = behind[:, 0] & ~behind.all(1)
    sides = own.copy()
    for k, side in enumerate((aside[outer] < 0, aside[outer] > 0)):
        if (stands_out & side).sum() >= _SETTINGS.several:
            come_in = max(float(np.quantile(wanted[stands_out & side], _SETTINGS.quantile)), _SETTINGS.thinnest)
            sides[k] = own.mean() + come_in * (own[k] - own.mean())
    return sides


def _sides(regions: np.ndarray, axes: _Axes) -> np.ndarray | None:
    """Where a neck begins and ends (2,), pixels across from the chin; None where it is not seen.

    It is what hangs together with the lines on which the jaw hides neither side, beside the jaw, too.
    """
    step = max(_SETTINGS.step * axes.height, 1.0)
    along = step * np.arange(-round(_SETTINGS.aside * axes.height / step), round(_SETTINGS.aside * axes.height / step))
    depths = step * np.arange(-round(_SETTINGS.above * axes.height / step), round(_SETTINGS.below * axes.height / step))
    places = axes.start + depths[:, None, None] * axes.down + along[:, None] * axes.across
    x, y = places.reshape(-1, 2).T
    labels = sample_pixels(regions, x, y, cv2.INTER_NEAREST, _OUTSIDE).reshape(len(depths), len(along))
    lines: list[int] = []
    narrowest = np.inf
    for number in np.flatnonzero(depths > 0):
        line = labels[number]
        ends = _middle_row(line == Region.NECK)
        seen = len(ends) > 0 and not np.isin(line[np.clip(ends + [-1, 1], 0, len(line) - 1)], _HIDING).any()
        if seen and np.ptp(ends) <= _SETTINGS.flare * narrowest:
            narrowest = min(narrowest, float(np.ptp(ends)))
            lines.append(int(number))
        elif lines:
            break
    if len(lines) < max(_SETTINGS.least * axes.height / step, 3):
        return None
    necks = (labels[: lines[-1] + 1] == Region.NECK).astype(np.uint8)
    _, parts = cv2.connectedComponents(necks, connectivity=4)
    own = parts[lines[0], _middle_row(labels[lines[0]] == Region.NECK)[0]]
    across = along[(parts == own).any(0)]
    return across[[0, -1]]


def _middle_row(line: np.ndarray) -> np.ndarray:
    """The first and the last (2,) of the row of true places on a line (N,) bool that is nearest to its middle, below
    the chin; none (0,) without any."""
    changes = np.diff(line.astype(np.int8), prepend=0, append=0)
    rows = np.stack([np.flatnonzero(changes == 1), np.flatnonzero(changes == -1) - 1], axis=1)
    if not len(rows):
        return rows.ravel()
    away = np.maximum(rows - len(line) // 2, 0)[:, 0] + np.maximum(len(line) // 2 - rows, 0)[:, 1]
    nearest: np.ndarray = rows[np.argmin(away)]
    return nearest
