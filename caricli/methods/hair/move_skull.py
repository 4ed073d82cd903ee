"""A skull that fits under the hair of a picture."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.hair.fit_outline import Outline, fit_outline
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import ShellSettings
from caricli.structures import Camera
from caricli.template.annotation import EARS
from caricli.template.template import Template

_SMALLEST = 0.3  # of a radius: no skull is smaller
_TOGETHER = 0.3  # how much the scales of a skull differ, beside the fit of its outline
_GAP = 2  # least thicknesses of hair by which a skull is drawn in behind the outline
_RAMP = 4  # vertices over which a skull that is lowered leads down
_WIDE_RAMP = 8  # the same of one that is raised


def sink_skull(head: Template, camera: Camera, hair: HairMask) -> Template:
    """The head with its skull drawn in where it stands out of the hair of the picture, which landmarks do not say.

    head: Template in the shape of the face. camera: of the picture. hair: HairMask.
    """
    settings = ShellSettings()
    for step in (_shrunk, _tightened):
        sphere = HeadSphere(head, settings)
        outline = Outline.of(hair, sphere, camera, settings.bins)
        share = np.clip(step(sphere, camera, outline, settings), _SMALLEST, 1)
        longitudes, angles, _ = sphere.seen_from(head.vertices)
        follow = np.clip(sphere.sample(_blurred(sphere.region("scalp", "forehead")), longitudes, angles), 0, 1)
        kept = 1 - (1 - _shown_ears(head)) * follow * (1 - sphere.sample(share, longitudes, angles))
        head = head.with_vertices(sphere.middle + kept[:, None] * (head.vertices - sphere.middle))
    return head


def _shrunk(sphere: HeadSphere, camera: Camera, outline: Outline, settings: ShellSettings) -> np.ndarray:
    """(R, C) shares of the skull's radii with which its outline is inside the hair's: a scale for each axis.

    Depth, which the picture does not show, goes along with height and width.
    """
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    skull = (sphere.region("scalp", "forehead") > 0.5).ravel()
    squares = sphere.directions(longitudes, angles).reshape(-1, 3) ** 2
    scales = np.ones(3)
    for _ in range(settings.rounds):
        radii = sphere.radii * (squares @ scales).reshape(angles.shape)
        projected = camera.project(sphere.points(longitudes, angles, radii)).reshape(-1, 2)
        shares, outermost = outline.compare(projected, skull)
        chosen = outermost & np.isfinite(shares)
        if not chosen.any():
            break
        # Rows at the end hold the scales together.
        together = _TOGETHER * np.sqrt(chosen.sum()) * (np.eye(3) - 1 / 3)
        wanted = np.minimum((squares[chosen] @ scales) * shares[chosen], 1)
        scales = np.linalg.lstsq(np.vstack([squares[chosen], together]), np.append(wanted, np.zeros(3)), rcond=None)[0]
    return (squares @ scales).reshape(angles.shape)


def _tightened(sphere: HeadSphere, camera: Camera, outline: Outline, settings: ShellSettings) -> np.ndarray:
    """(R, C) shares of the skull's radii with which no place of it is outside."""
    skull = sphere.region("scalp", "forehead") > 0.5
    wanted = fit_outline(sphere, camera, outline, skull, settings) - _GAP * settings.least * sphere.head.height
    return wanted / sphere.radii


def lower_skull(head: Template, sphere: HeadSphere, most: np.ndarray) -> Template:
    """The head with its skull below hair, and what is beside it leading there.

    sphere: HeadSphere of the head. most: (R, C) metres, how far out the skull may be, infinite where there is no hair.
    """
    _, _, radii = sphere.seen_from(head.vertices)
    lower = np.clip(radii - sphere.nearest(most, head.vertices), 0, 0.5 * radii)
    return _led(head, sphere, -lower, _RAMP)


def raise_skull(head: Template, sphere: HeadSphere, least: np.ndarray, limit: float) -> Template:
    """The head with its skull so far out as it has to be, and what is beside it leading there.

    sphere: HeadSphere of the head. least: (R, C) metres, how far out, infinitely far inwards where it is no matter.
    limit: metres that nothing is raised by more than.
    """
    _, _, radii = sphere.seen_from(head.vertices)
    return _led(head, sphere, np.clip(sphere.nearest(least, head.vertices) - radii, 0, limit), _WIDE_RAMP)


def _led(head: Template, sphere: HeadSphere, moves: np.ndarray, ramp: int) -> Template:
    """The head with its skull moved outwards (V,) metres, and a ramp of vertices around what moves leading there."""
    _, _, radii = sphere.seen_from(head.vertices)
    skull = ~head.mask(*EARS)
    wanted = np.where(skull, np.abs(moves), 0)
    _, mean = vertex_neighbours(head.faces, len(head.vertices))
    led = wanted
    for _ in range(ramp):
        led = np.maximum(wanted, np.where(skull, mean @ led, 0))
    share = 1 + np.sign(moves.sum()) * led / np.maximum(radii, 1e-9)
    return head.with_vertices(sphere.middle + share[:, None] * (head.vertices - sphere.middle))


def _shown_ears(head: Template) -> np.ndarray:
    """(V,) how much vertices stay where the picture shows them: ears, but for where they join the head."""
    _, mean = vertex_neighbours(head.faces, len(head.vertices))
    ears = head.mask(*EARS)
    stay = ears.astype(float)
    for _ in range(_RAMP):
        stay = np.where(ears, np.minimum(stay, mean @ stay), 0)
    return stay


def _blurred(values: np.ndarray) -> np.ndarray:
    return gaussian_filter1d(gaussian_filter1d(values, 3, axis=1, mode="wrap"), 3, axis=0, mode="nearest")
