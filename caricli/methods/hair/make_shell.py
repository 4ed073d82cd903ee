"""A shell of hair on a head, its outline that of the hair in the picture."""

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter1d

from caricli.methods.hair.find_edge import find_edge
from caricli.methods.hair.fit_outline import Outline, fit_outline
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.settings import ShellSettings
from caricli.render.rasterise import rasterise
from caricli.render.sample_texture import sample_pixels
from caricli.structures import Camera, Mesh
from caricli.structures.parts import Hair
from caricli.template.template import Template

DISC = 0.49
"""Of the picture's side, how far from its middle the edge of a shell is."""

_FACING = 0.2  # cosine between skin and view from which on it is seen as it is
_SMALLEST = 0.3  # of a radius: no skull is smaller
_TOGETHER = 0.3  # how much the scales of a skull differ, beside the fit of its outline
_GAP = 2  # least thicknesses of hair by which a skull is drawn in behind the outline
_ROUNDS = 2  # of surface and hairline in turns


def sink_skull(
    head: Template,
    camera: Camera,
    hair: HairMask,
    settings: ShellSettings = ShellSettings(),  # noqa: B008 (frozen)
) -> Template:
    """The head with its skull drawn in where it stands out of the hair of the picture, which landmarks do not say.

    head: Template in the shape of the face. camera: of the picture. hair: HairMask.
    """
    for step in (_shrunk, _tightened):
        sphere = HeadSphere(head, settings)
        outline = Outline.of(hair.pixels, hair.behind, camera.project(sphere.middle), settings.bins)
        share = np.clip(step(sphere, camera, outline, settings), _SMALLEST, 1)
        longitudes, angles, _ = sphere.seen_from(head.vertices)
        hold = np.clip(sphere.sample(_blurred(sphere.region("scalp", "forehead")), longitudes, angles), 0, 1)
        kept = 1 - hold * (1 - sphere.sample(share, longitudes, angles))
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
        shares, outermost = outline.compare(projected, camera.project(sphere.middle), skull)
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


def make_shell(
    head: Template,
    camera: Camera,
    hair: HairMask,
    settings: ShellSettings = ShellSettings(),  # noqa: B008 (frozen)
) -> Hair:
    """Build a shell of hair.

    It leaves the skin along rays from the middle of the head, which a smooth field makes longer so that its outline is
    that of the mask; it ends where the mask ends, and where nothing is seen along the hairline that is usual, lower if
    hair is longer at the sides; there its thickness falls to nothing, and it closes towards the skin.

    head: Template in the shape of the face, whose annotation names ears and scalp. camera: of the picture.
    hair: HairMask. Returns Hair, its quads from the whorl outwards, its picture unrolled around the whorl.
    """
    sphere = HeadSphere(head, settings)
    outline = Outline.of(hair.pixels, hair.behind, camera.project(sphere.middle), settings.bins)
    fine = HeadSphere(head, settings, fine=True)
    longitudes, angles = np.meshgrid(fine.longitudes, fine.angles)
    edge = np.full(len(fine.longitudes), np.radians(110))
    for _ in range(_ROUNDS):
        ends = np.interp(sphere.longitudes, fine.longitudes, edge, period=2 * np.pi)
        thickness = fit_outline(sphere, camera, outline, sphere.angles[:, None] < ends, settings) - sphere.radii
        total = fine.radii + np.maximum(fine.sample(thickness, longitudes, angles), settings.least * head.height)
        edge = _edge(fine, camera, hair, total, settings)
    return _mesh(fine, total, edge, settings)


def _taper(left: np.ndarray, thickness: np.ndarray, height: float, settings: ShellSettings) -> np.ndarray:
    """How much of its thickness a shell has at a distance from its edge, metres: a quarter of an ellipse."""
    length = np.maximum(settings.round_ * thickness, settings.rim * height)
    return np.sqrt(np.clip(1 - (1 - np.clip(left / length, 0, 1)) ** 2, 0, 1))


def _edge(sphere: HeadSphere, camera: Camera, hair: HairMask, total: np.ndarray, settings: ShellSettings) -> np.ndarray:
    """(C,) angles where hair ends."""
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    cosine = _facing(sphere.points(longitudes, angles, sphere.radii), camera)
    # What faces the camera ends where it meets the skin; at the sides its outer surface is seen.
    share = 1 - np.clip(cosine / _FACING, 0, 1)
    points = sphere.points(longitudes, angles, sphere.radii + share * (total - sphere.radii))
    placed = camera.place(points.reshape(-1, 3))
    pictured = ((placed[:, :2] >= 0) & (placed[:, :2] < hair.pixels.shape[::-1])).all(1)
    skin = rasterise(camera.place(sphere.head.vertices), sphere.head.faces, *hair.pixels.shape[::-1]).face >= 0
    covered = sample_pixels(skin.astype(np.float32), placed[:, 0], placed[:, 1], border=1.0) > 0.5
    # Hair behind the head is seen, too, where it stands out.
    seen = np.where(pictured, np.where(covered, np.clip(cosine.ravel() / _FACING, 0, 1), 1), 0)
    # Inside up to the outline's own error, where the surface turns away.
    away = distance_transform_edt(~hair.pixels).astype(np.float32)
    slack = np.where(cosine > 0, 0.5, settings.slack * camera.scale * sphere.head.height).ravel()
    inside = sample_pixels(away, placed[:, 0], placed[:, 1]) <= slack
    votes = seen * np.where(inside, 1.0, -1.0)
    usual = np.where(sphere.region("scalp") > 0.5, 1.0, -1.0)
    for _ in range(2):
        hidden = settings.hidden * (1 - seen) * usual.ravel()
        deep = (angles < np.radians(settings.deepest)).ravel()
        rows = find_edge(np.where(deep, votes + hidden, -1).reshape(angles.shape), settings.steady)
        edge = rows * (sphere.angles[1] - sphere.angles[0])
        usual = _as_long(sphere, points, rows, seen.reshape(angles.shape), usual)
    return gaussian_filter1d(edge, settings.calm, mode="wrap")


def _as_long(
    sphere: HeadSphere, points: np.ndarray, rows: np.ndarray, seen: np.ndarray, usual: np.ndarray
) -> np.ndarray:
    """(R, C): behind, hair falls as low as it is seen to at the sides."""
    sides = np.abs(np.sin(sphere.longitudes)) > 0.8
    last = np.clip(rows - 1, 0, len(points) - 1)
    ends = points[last, np.arange(len(rows)), 1]
    sure = sides & (seen[last, np.arange(len(rows))] > 0.2)
    if not sure.any():
        return usual
    behind = points[..., 2] < sphere.middle[2]
    return np.where(behind & (points[..., 1] > np.median(ends[sure])), 1.0, usual)


def _facing(points: np.ndarray, camera: Camera) -> np.ndarray:
    """(R, C) cosine between a surface (R, C, 3) and the view."""
    around = np.roll(points, -1, 1) - np.roll(points, 1, 1)
    along = np.gradient(points, axis=0)
    normals = np.cross(along, around)
    lengths = np.maximum(np.linalg.norm(normals, axis=-1), 1e-12)
    return -(normals @ camera.rotation[2]) / lengths


def _mesh(sphere: HeadSphere, total: np.ndarray, edge: np.ndarray, settings: ShellSettings) -> Hair:
    columns = settings.columns
    longitudes = 2 * np.pi * np.arange(columns) / columns
    ends = np.interp(longitudes, sphere.longitudes, edge, period=2 * np.pi)
    # Denser towards the edge, where the shell is round.
    share = np.sin(np.pi / 2 * (np.arange(settings.rows) + 1) / settings.rows)
    angles = share[:, None] * ends
    around = np.broadcast_to(longitudes, angles.shape)
    skin = sphere.sample(sphere.radii, around, angles)
    outer = sphere.sample(total, around, angles)
    thickness = outer - skin
    left = (ends - angles) * outer
    height = sphere.head.height
    radii = skin + thickness * _taper(left, thickness, height, settings)
    radii[-1] = skin[-1] - settings.under * height
    top = sphere.sample(total, np.zeros(1), np.zeros(1))
    points = np.concatenate(
        [
            sphere.points(np.zeros(1), np.zeros(1), top),
            sphere.points(around, angles, radii).reshape(-1, 3),
        ]
    )
    turn = np.append(0, around.ravel())
    roots, weights = sphere.roots(turn, np.append(0, angles.ravel()))
    quads = _quads(settings.rows, columns)
    uvs = unrolled_to_uv(turn, np.append(0, np.repeat(share, columns)))
    return Hair(Mesh(points, quads, uvs, quads), roots, weights)


def unrolled_to_uv(longitudes: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Where the picture of a shell shows longitudes (...), and shares (...) of the way from the whorl to the edge.

    Returns (..., 2), the face at the bottom, the subject's left on the right.
    """
    return 0.5 + DISC * shares[..., None] * np.stack([np.sin(longitudes), -np.cos(longitudes)], -1)


def _quads(rows: int, columns: int) -> np.ndarray:
    """A fan of triangles around the first vertex, and rings of quads after it."""
    rings = 1 + np.arange(rows * columns).reshape(rows, columns)
    after = np.roll(rings, -1, axis=1)
    fan = np.column_stack([np.zeros(columns, int), rings[0], after[0], np.full(columns, -1)])
    between = [np.column_stack([rings[k], rings[k + 1], after[k + 1], after[k]]) for k in range(rows - 1)]
    return np.concatenate([fan, *between]).astype(np.int32)


def _blurred(values: np.ndarray) -> np.ndarray:
    return gaussian_filter1d(gaussian_filter1d(values, 3, axis=1, mode="wrap"), 3, axis=0, mode="nearest")
