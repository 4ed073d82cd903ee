"""A shell of hair on a head, its outline that of the hair in the picture."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_dilation, binary_opening, gaussian_filter, gaussian_filter1d, label

from caricli.geometry.polar_quads import polar_quads
from caricli.methods.hair.far_side import as_other_side, facing_of, inside_softly
from caricli.methods.hair.find_edge import find_edge
from caricli.methods.hair.fit_outline import Outline, fit_outline, meet_outline
from caricli.methods.hair.hair_view import HairView
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.hidden_hairline import (
    around_ears,
    far_ear,
    hidden_reach,
    lower_nape,
    usual_reach,
    without_corners,
)
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.move_skull import lower_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.tuck_ears import tuck_ears
from caricli.methods.hair.visible_hair import union_share, visible_hair
from caricli.render.pixels.sample_texture import sample_pixels
from caricli.structures import Camera, Mesh
from caricli.structures.parts import Hair
from caricli.template.template import Template

DISC = 0.49
"""Of the picture's side, how far from its middle the edge of a shell is."""

_FACING = 0.2  # cosine between skin and view from which on it is seen as it is
_FAINTEST = 1e-6  # share of hair around, below which there is none
_GRAZING = 0.1  # cosine down to which skin that turns away from the camera says whether there is hair
_SAMPLES = 8  # of the way across the outline
_GAPS = 6  # directions: what no wider gap joins is apart
_TURNS = 4  # of bending a shell away from bare skin that it hides
_ROUNDS = 2  # of surface and hairline in turns


def make_shell(
    head: Template,
    camera: Camera,
    hair: HairMask,
    settings: ShellSettings = ShellSettings(),  # noqa: B008 (frozen)
) -> tuple[Hair, Template] | None:
    """Build a shell of hair.

    It leaves the skin along rays from the middle of the head, which a smooth field makes longer so that its outline is
    that of the mask; it ends where the mask ends, and where nothing is seen along the hairline that is usual, lower if
    hair is longer at the sides; there its thickness falls to nothing, and it closes towards the skin. The far side of a
    head that is turned is as the near one where an ear is under hair there. Where a shell so made is far from the mask,
    heads are bare at the sides, which are seen from aside and then count in full.

    head: Template in the shape of the face, whose annotation names ears and scalp. camera: of the picture.
    hair: HairMask. Returns Hair, its quads from the whorl outwards, its picture unrolled around the whorl,
    and the head, its skull below them; or None where the picture shows none of it: what the mask has is no hair's.
    """
    grown = _grown(head, camera, hair, settings)
    if not grown.is_seen:
        return None
    shell, under = _closed(grown, settings)
    if settings.aside:
        shown = visible_hair(under, shell, camera, hair.pixels.shape)
        if union_share(shown, hair.pixels) < settings.overlap:
            shell, under = _closed(grown, replace(settings, aside=0.0))
    return shell, under


@dataclass(frozen=True, eq=False)
class _Grown:
    """Hair that does not end yet.

    sphere: HeadSphere of the head. view: HairView of the same. total: (R, C) metres, how far out hair is. edge: (C,)
    angles where it ends as seen from the whorl.
    """

    sphere: HeadSphere
    view: HairView
    total: np.ndarray
    edge: np.ndarray

    @property
    def is_seen(self) -> bool:
        """Whether the picture shows any of it as hair."""
        longitudes, angles = np.meshgrid(self.sphere.longitudes, self.sphere.angles)
        points = self.sphere.points(longitudes, angles, self.total)
        return bool(((angles < self.edge) & self.view.shows(points) & (self.view.to_bare(points) > 0)).any())


def _grown(head: Template, camera: Camera, hair: HairMask, settings: ShellSettings) -> _Grown:
    """Hair whose outline is that of a mask."""
    sphere = HeadSphere(head, settings)
    outline = Outline.of(hair, sphere, camera, settings.bins)
    fine = HeadSphere(head, settings, fine=True)
    view = HairView(head, camera, hair, outline)
    longitudes, angles = np.meshgrid(fine.longitudes, fine.angles)
    edge = np.full(len(fine.longitudes), np.radians(110))
    for _ in range(_ROUNDS):
        ends = np.interp(sphere.longitudes, fine.longitudes, edge, period=2 * np.pi)
        thickness = fit_outline(sphere, camera, outline, sphere.angles[:, None] < ends, settings) - sphere.radii
        total = fine.radii + np.maximum(fine.sample(thickness, longitudes, angles), settings.least * head.height)
        edge = _edge(fine, view, total, settings)
    hairy = angles < edge
    unseen = hairy & ~view.shows(fine.points(longitudes, angles, total))
    total = total + inside_softly(unseen) * (_rounded(hairy, total, settings) - total)
    return _Grown(fine, view, meet_outline(fine, camera, outline, hairy, total), edge)


def _closed(grown: _Grown, settings: ShellSettings) -> tuple[Hair, Template]:
    """The shell that ends where hair does, and the head under it."""
    left, *_ = _left(grown.sphere, grown.view, grown.edge, grown.total, settings)
    head = grown.sphere.head
    head = lower_skull(head, grown.sphere, np.where(left > 0, grown.total - settings.least * head.height, np.inf))
    fine = grown.sphere.with_head(head)
    # The skull is flat between its vertices, where a shell may be hollow.
    total = np.where(left > 0, np.maximum(grown.total, fine.radii + settings.least * head.height), grown.total)
    view = HairView(head, grown.view.camera, grown.view.hair, grown.view.outline)
    left, free, hidden, seen = _left(fine, view, grown.edge, total, settings)
    if far_ear(fine, view) is not None:
        left, total = as_other_side(fine, view.camera, left, total, hidden)
    # Seen skin says itself where hair ends, down to some way below the edge.
    row = np.clip(np.searchsorted(fine.angles, grown.edge), 0, len(fine.angles) - 1)
    lower = grown.edge + settings.below * seen[row, np.arange(len(grown.edge))]
    lower = np.maximum(lower, np.pi / len(left) * (np.cumprod(left > 0, axis=0).sum(0) + 0.5))
    return _mesh(_Surface(fine, total, left, free, hidden, lower), view, settings), tuck_ears(fine, view, settings)


def _rounded(hairy: np.ndarray, total: np.ndarray, settings: ShellSettings) -> np.ndarray:
    """Radii (R, C) without the edges between facets of the skin, which a finer shell would show as creases.

    hairy: (R, C) bool, where there is hair; elsewhere nothing changes.
    """
    rows, columns = total.shape
    spread = settings.facets * rows / np.pi, settings.facets * columns / (2 * np.pi)
    sums, shares = (
        gaussian_filter(values, spread, mode=("nearest", "wrap")) for values in (total * hairy, hairy.astype(float))
    )
    return np.where(hairy, sums / np.maximum(shares, _FAINTEST), total)


def _left(
    sphere: HeadSphere, view: HairView, ends: np.ndarray, total: np.ndarray, settings: ShellSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(R, C) metres, how far it is to where hair ends, below zero beyond; (R, C) metres to bare ears; and (R, C) from 0
    to 1, how far the picture shows neither the skin there nor the hair on it, and how far it shows the skin.

    It is the distance to (C,) angles and to bare ears; but where skin is seen that to what is bare in the picture, and
    where hair would be seen in front of the head not more than that.
    """
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    skin = sphere.points(longitudes, angles, sphere.radii)
    facing = facing_of(skin, view.camera)
    sure = facing / settings.aside if settings.aside else 1 + facing / _GRAZING
    seen = view.shows(skin) * np.clip(sure, 0, 1)
    outer = sphere.points(longitudes, angles, total)
    shown = view.shows(outer)
    free, mostly = around_ears(sphere, view, settings)
    bare = view.to_bare(outer)
    usual = np.where(shown, np.minimum((ends - angles) * total, bare), hidden_reach(sphere, ends, settings))
    # Hair that the picture shows over or beside an ear of which little shows is there.
    usual = np.where(shown & (bare > 0), usual, np.minimum(usual, free))
    # What is short where it is seen is as long as usual behind.
    usual = np.maximum(usual, np.minimum(usual_reach(sphere, settings), free))
    left = seen * view.to_bare(skin) + (1 - seen) * usual
    # Where an ear is hollow, too, nothing of what is under the skin may be seen.
    left = np.where(mostly | ((left < 0) & (free < 0)), np.minimum(left, free), left)
    return _without_islands(left, free, settings.rim * sphere.head.height), free, 1 - np.maximum(seen, shown), seen


def _taper(
    left: np.ndarray, thickness: np.ndarray, hidden: np.ndarray, height: float, settings: ShellSettings
) -> np.ndarray:
    """How much of its thickness a shell has at a distance from its edge, metres: a quarter of an ellipse, and where it
    is hidden a flat arc that leads into the skin, as short hair at a nape does."""
    share, flat = (
        np.clip(left / np.maximum(times * thickness, settings.rim * height), 0, 1)
        for times in (settings.round_, settings.thin)
    )
    return (1 - hidden) * np.sqrt(share * (2 - share)) + hidden * flat * (2 - flat)


def _edge(sphere: HeadSphere, view: HairView, total: np.ndarray, settings: ShellSettings) -> np.ndarray:
    """(C,) angles where hair ends."""
    longitudes, angles = np.meshgrid(sphere.longitudes, sphere.angles)
    cosine = facing_of(sphere.points(longitudes, angles, sphere.radii), view.camera)
    # What faces the camera ends where it meets the skin; at the sides its outer surface is seen.
    share = 1 - np.clip(cosine / _FACING, 0, 1)
    points = sphere.points(longitudes, angles, sphere.radii + share * (total - sphere.radii))
    # Hair behind the head is seen, too, where it stands out.
    seen = view.shows(points).astype(float)
    # Inside up to the outline's own error, which is across the outline.
    slack = np.where(view.beside(points), settings.slack * view.camera.scale * sphere.head.height, 0.5)
    inside = _inside(view, view.camera.project(points.reshape(-1, 3)), slack.ravel())
    votes = seen * np.where(inside, 1.0, -1.0).reshape(seen.shape)
    usual = np.where(sphere.region("scalp") > 0.5, 1.0, -1.0)
    for _ in range(2):
        hidden = settings.hidden * (1 - seen) * usual
        deep = angles < np.radians(settings.deepest)
        rows = find_edge(np.where(deep, votes + hidden, -1), settings.steady)
        edge = rows * (sphere.angles[1] - sphere.angles[0])
        usual = _as_long(sphere, points, rows, seen, usual)
    # What nobody sees has no corners.
    sight = seen[np.clip(rows, 0, len(seen) - 1), np.arange(len(rows))]
    sight = gaussian_filter1d(sight, settings.soft / 2, mode="wrap")
    shown, hidden = (gaussian_filter1d(edge, width, mode="wrap") for width in (settings.calm, settings.soft))
    return sight * shown + (1 - sight) * without_corners(sphere, hidden, settings)


def _inside(view: HairView, points: np.ndarray, slack: np.ndarray) -> np.ndarray:
    """(N,) bool: whether points (N, 2) of a picture are hair, or what is so many pixels (N,) nearer to the middle."""
    away = points - view.outline.centre
    inwards = -away / np.maximum(np.hypot(*away.T), 1e-9)[:, None]
    hair = view.hair.pixels.astype(np.float32)
    inside = np.zeros(len(points), bool)
    for share in np.linspace(0, 1, _SAMPLES):
        x, y = (points + share * slack[:, None] * inwards).T
        inside |= sample_pixels(hair, x, y, border=0.0) > 0.5
    return inside


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
    return np.where(behind & (points[..., 1] > np.median(ends[sure]) - lower_nape(sphere)), 1.0, usual)


@dataclass(frozen=True, eq=False)
class _Surface:
    """sphere: HeadSphere. total, left, free: (R, C) metres, how far out hair is, and how far from its end and from bare
    ears. hidden: (R, C) from 0 to 1, how far no picture shows it. ends: (C,) angles down to which a shell goes."""

    sphere: HeadSphere
    total: np.ndarray
    left: np.ndarray
    free: np.ndarray
    hidden: np.ndarray
    ends: np.ndarray


def _mesh(surface: _Surface, view: HairView, settings: ShellSettings) -> Hair:
    sphere = surface.sphere
    columns = settings.columns
    longitudes = 2 * np.pi * np.arange(columns) / columns
    ends = np.interp(longitudes, sphere.longitudes, surface.ends, period=2 * np.pi)
    # Denser towards the edge, where the shell is round.
    down = np.sin(np.pi / 2 * (np.arange(settings.rows) + 1) / settings.rows)
    angles = down[:, None] * ends
    around = np.broadcast_to(longitudes, angles.shape)
    skin = sphere.ground(around, angles)
    even = sphere.sample(_rounded(surface.left > 0, sphere.radii, settings), around, angles)
    total = sphere.sample(surface.total, around, angles)
    left, free = (sphere.sample(metres, around, angles) for metres in (surface.left, surface.free))
    # The outline, where hidden and shown hair meet, keeps its thickness.
    hidden = sphere.sample(inside_softly(surface.hidden), around, angles)
    height = sphere.head.height
    for _ in range(_TURNS):
        # Beyond its end it goes so deep that moving brows do not uncover it.
        share = _taper(left, total - skin, hidden, height, settings)
        base = skin + share * (even - skin)
        radii = base + share * (total - base)
        radii += np.clip(left, -settings.deep * height, 0)
        # What hides bare skin ends before it.
        points = sphere.points(around, angles, radii)
        sure = np.clip(facing_of(points, view.camera) / settings.aside, 0, 1) if settings.aside else 1.0
        ends = sure * np.minimum(left, view.to_bare(points)) + (1 - sure) * left
        left = np.where((left > 0) & view.shows(points), ends, left)
        left = _without_islands(left, free, settings.rim * height)
        left = gaussian_filter(left, settings.even, mode=("nearest", "wrap"))
    rim = skin[-1] - settings.under * height
    radii[-1] = np.where(free[-1] < 0, np.minimum(radii[-1], rim), rim)
    top = sphere.sample(surface.total, np.zeros(1), np.zeros(1))
    whorl = sphere.points(np.zeros(1), np.zeros(1), top)
    points = np.concatenate([whorl, sphere.points(around, angles, radii).reshape(-1, 3)])
    turn = np.append(0, around.ravel())
    roots, weights = sphere.roots(turn, np.append(0, angles.ravel()))
    quads = polar_quads(settings.rows, columns)
    uvs = unrolled_to_uv(turn, np.append(0, np.repeat(down, columns)))
    return Hair(Mesh(points, quads, uvs, quads), roots, weights)


def _without_islands(left: np.ndarray, free: np.ndarray, rim: float) -> np.ndarray:
    """How far it is to where hair ends, (R, C) metres, and a rim where this is below zero with hair all around.

    free: (R, C) metres to bare ears, below zero where hair must be clear of them: no gap is closed there.
    There is no such thing on a head: the picture shows skin before the hair behind it, at a grazing angle. Gaps of a
    few places in what is around count for nothing.
    """
    bare = left <= 0
    bare[-1] = True
    turn = bare.shape[1]
    deeper = np.pad(bare, ((0, 2 * _GAPS), (0, 0)), mode="edge")
    # Three turns, so that what goes on over the middle of the face is whole in the second.
    wide = binary_opening(np.pad(deeper, ((0, 0), (turn, turn)), mode="wrap"), iterations=_GAPS)
    parts, _ = label(wide)
    beyond = np.isin(parts, np.unique(parts[-1][wide[-1]])) & wide
    # What was lost at its border comes back, what hangs on it by a thin bridge does not.
    beyond = binary_dilation(beyond, iterations=2 * _GAPS)[: len(bare), turn : 2 * turn]
    return np.where(bare & ~beyond & (free >= 0), rim, left)


def unrolled_to_uv(longitudes: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Where the picture of a shell shows longitudes (...), and shares (...) of the way from the whorl to the edge.

    Returns (..., 2), the face at the bottom, the subject's left on the right.
    """
    return 0.5 + DISC * shares[..., None] * np.stack([np.sin(longitudes), -np.cos(longitudes)], -1)
