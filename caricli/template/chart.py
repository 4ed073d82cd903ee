"""The face in a picture of its own: as rigid as possible, upright, symmetric, with what is between the lips."""

from dataclasses import dataclass
from functools import cache, partial

import igl
import numpy as np
from scipy.spatial import KDTree

from caricli.errors import InputError
from caricli.geometry.flattening.embed_disc import embed_disc
from caricli.geometry.flattening.flatten import Sheet, flatten
from caricli.geometry.flattening.turn_upright import turn_upright
from caricli.geometry.repair.fill_holes import fill_holes
from caricli.io.kept import kept_arrays
from caricli.structures.chart import FaceChart
from caricli.structures.landmarks import LIPS_INSIDE, POINT_NAMES
from caricli.template.annotation import CAVITIES, EARS
from caricli.template.head import load_head
from caricli.template.template import Template

NOSTRILS = ("nostril_left", "nostril_right")


@dataclass(frozen=True)
class ChartSettings:
    """How the face is laid out.

    margin: share of the picture's side that stays free on every side. ears: how far around the ears the face is left
    out, for its width. opening: height for its width of the mouth that the membrane is made
    for. mouth: size of the mouth for that of the rest; it changes much, and is small. reach: how far from the line
    between its corners that goes, for its width. hole: weight of what fills eyes and nostrils while the face is
    flattened, beside the surface's.
    """

    margin: float = 0.02
    ears: float = 0.09
    opening: float = 0.7
    mouth: float = 1.6
    reach: float = 0.7
    hole: float = 0.02


def face_chart(template: Template, settings: ChartSettings = ChartSettings()) -> FaceChart:  # noqa: B008 (frozen)
    """Lay the face of a head out in the unit square.

    The face is the annotation's region of that name without mouth cavity, eye sockets and nostrils; the opening between
    the inner lips is closed by a membrane of triangles between vertices that are there, as wide open as the settings
    say. It is flattened by `flatten` from `embed_disc`, eyes and nostrils filled meanwhile, and made mirror-symmetric
    where the annotation has a mirror. That of the open head is the same whatever shape the template has.

    template: Template whose annotation has ``regions.face``.
    Returns FaceChart. Raises InputError where the region is missing, or is no surface in one piece.
    """
    note = template.annotation
    if "face" not in note.regions:
        raise InputError("a chart of the face needs 'regions.face', its vertices, in the annotation, found none")
    usual = _usual_head()
    if template.topology_id == usual.topology_id:
        template = template.with_vertices(usual.vertices)
    regions = np.stack([template.mask("face"), template.mask(*CAVITIES, *NOSTRILS), template.mask(*EARS)])
    mirror = np.zeros(0, int) if note.mirror is None else note.mirror
    given = (template.vertices, template.faces, regions, note.landmarks, mirror, repr(settings))
    arrays = kept_arrays("chart", given, partial(_laid_out, template, settings))
    return FaceChart(**arrays, topology_id=template.topology_id)


@cache
def _usual_head() -> Template:
    return load_head().template()


def _laid_out(template: Template, settings: ChartSettings) -> dict[str, np.ndarray]:
    """The arrays of a FaceChart."""
    mirror = template.annotation.mirror
    triangles = _face_triangles(template, settings.ears)
    vertices, rows = np.unique(template.faces[triangles], return_inverse=True)
    shape = np.asarray(template.vertices, float)
    if mirror is not None:
        shape = (shape + shape[mirror] * [-1, 1, 1]) / 2
    lips = _lips(shape[vertices], rows.reshape(-1, 3), shape[template.annotation.landmarks[LIPS_INSIDE]])
    sheet = _sheet(shape[vertices], rows.reshape(-1, 3), lips, settings)
    count = len(sheet.faces)
    uvs = _flat(sheet, settings.hole)
    if mirror is not None:
        there = np.searchsorted(vertices, mirror[vertices]).clip(max=len(vertices) - 1)
        uvs = np.where((vertices[there] == mirror[vertices])[:, None], (uvs + uvs[there] * [-1, 1]) / 2, uvs)
    edges = uvs[sheet.faces[:, 1:]] - uvs[sheet.faces[:, :1]]
    if (np.linalg.det(edges) <= 0).any():
        raise InputError("a chart of the face needs 'regions.face' and 'mirror' that fit each other, found folds in it")
    uvs = uvs - [0, np.mean([uvs[:, 1].min(), uvs[:, 1].max()])]
    uvs = 0.5 + uvs * (0.5 - settings.margin) / np.abs(uvs).max()
    between = np.arange(count) >= len(triangles)
    triangles = np.append(triangles, np.full(count - len(triangles), -1))
    return {"vertices": vertices, "faces": sheet.faces, "uvs": uvs, "membrane": between, "triangles": triangles}


def _face_triangles(template: Template, before: float) -> np.ndarray:
    """(S,) triangles of the face in one piece, that around the tip of the nose. before: of ChartSettings.ears."""
    within = template.mask("face") & ~template.mask(*CAVITIES, *NOSTRILS)
    ears = template.mask(*EARS)
    if within.any() and ears.any():
        away, _ = KDTree(template.vertices[ears]).query(template.vertices)
        within &= away > before * np.ptp(template.vertices[within, 0])
    triangles = np.flatnonzero(within[template.faces].all(1))
    faces = np.asarray(template.faces[triangles], np.int64)
    around = (faces == template.annotation.landmarks[POINT_NAMES["nose_tip"]]).any(1)
    if not around.any():
        raise InputError("a chart of the face needs 'regions.face' around the tip of the nose, found it elsewhere")
    _, pieces = igl.facet_components(faces)
    triangles = triangles[pieces == np.bincount(pieces[around]).argmax()]
    faces = np.asarray(template.faces[triangles], np.int64)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, times = np.unique(edges, axis=0, return_counts=True)
    rims = np.bincount(unique[times == 1].ravel(), minlength=1)
    # Euler: a disc with holes has one component, and as many loops as the count says, none of which meets another.
    loops = 2 - (len(np.unique(faces)) - len(unique) + len(faces))
    if times.max() > 2 or rims.max() > 2 or loops != len(igl.boundary_loop_all(faces)) or not loops:
        raise InputError("a chart of the face needs a 'regions.face' that is one sheet with holes, found another shape")
    return triangles


def _lips(vertices: np.ndarray, faces: np.ndarray, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of vertices (V, 3) along upper and lower inner lip, from right to left; none where these are one.

    faces: (F, 3), a disc with holes. inside: (8, 3) the landmarks of the inner lips.
    """
    right, above, left = inside[[0, 2, 4]]
    loops = [np.asarray(loop) for loop in igl.boundary_loop_all(faces)]
    away = [np.linalg.norm(vertices[loop].mean(0) - inside.mean(0)) for loop in loops]
    loop = loops[int(np.argmin(away))]
    if len(loops) < 2 or min(away) > np.linalg.norm(left - right) / 2:
        return np.zeros(0, int), np.zeros(0, int)
    loop = np.roll(loop, -np.linalg.norm(vertices[loop] - right, axis=1).argmin())
    turn = np.linalg.norm(vertices[loop] - left, axis=1).argmin()
    lines = [loop[: turn + 1], np.append(loop[turn:], loop[0])[::-1]]
    first, second = sorted(lines, key=lambda line: np.linalg.norm(vertices[line] - above, axis=1).min())
    return first, second


def _sheet(
    vertices: np.ndarray, faces: np.ndarray, lips: tuple[np.ndarray, np.ndarray], settings: ChartSettings
) -> Sheet:
    """The face's vertices (V, 3) and faces (F, 3), and between the lips those of a mouth that is open, a flat lens."""
    shapes = vertices[faces]
    sizes = np.ones(len(vertices))
    if len(lips[0]):
        ends = vertices[lips[0][[0, -1]]]
        width = np.linalg.norm(ends[1] - ends[0])
        line = np.linspace(ends[0], ends[1], 9)
        away, _ = KDTree(line).query(vertices)
        sizes += (settings.mouth - 1) * np.exp(-((away / (settings.reach * width)) ** 2))
        lens = np.zeros_like(vertices)
        shares = [_shares(vertices[line]) for line in lips]
        for line, share, side in zip(lips, shares, (1, -1), strict=True):
            lens[line, 0] = width * share
            lens[line, 1] = side * settings.opening * width / 2 * np.sin(np.pi * share)
        strip = _strip(lips, shares)
        faces = np.concatenate([faces, strip])
        shapes = np.concatenate([shapes, lens[strip]])
    return Sheet(vertices, faces, sizes, np.ones(len(faces)), shapes)


def _strip(lines: tuple[np.ndarray, np.ndarray], shares: list[np.ndarray]) -> np.ndarray:
    """Triangles (M, 3) between an upper and a lower line with the same ends, and how far along these their rows are."""
    upper, lower = lines
    over = 0
    under = 0
    strip = []
    while over + 2 < len(upper) or under + 2 < len(lower):
        if under + 2 >= len(lower) or (over + 2 < len(upper) and shares[0][over + 1] <= shares[1][under + 1]):
            strip.append((lower[under], upper[over + 1], upper[over]))
            over += 1
        else:
            strip.append((lower[under], lower[under + 1], upper[over]))
            under += 1
    strip.append((lower[under], lower[-1], upper[over]))
    return np.array([corners for corners in strip if len(set(corners)) == 3])


def _shares(line: np.ndarray) -> np.ndarray:
    """(N,) from 0 to 1, how far along a line the points (N, 3) of it are."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.append(0, np.cumsum(steps)) / steps.sum()


def _flat(sheet: Sheet, weight: float) -> np.ndarray:
    """Places (V, 2) of a sheet in metres, upright, around the middle. weight: of what fills its holes meanwhile."""
    count = len(sheet.vertices)
    vertices, faces, loop = fill_holes(sheet.vertices, sheet.faces)
    fans = faces[len(sheet.faces) :]
    assert sheet.shapes is not None
    closed = Sheet(
        vertices,
        faces,
        np.append(sheet.sizes, np.ones(len(vertices) - count)),
        np.append(sheet.weights, np.full(len(fans), weight)),
        np.concatenate([sheet.shapes, vertices[fans]]),
    )
    radius = np.linalg.norm(vertices[loop] - vertices[loop].mean(0), axis=1).mean()
    places = flatten(closed, turn_upright(radius * embed_disc(vertices, faces, loop), vertices))
    return turn_upright(places, vertices)[:count]
