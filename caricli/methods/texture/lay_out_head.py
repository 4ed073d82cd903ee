"""Where the parts of the head lie in its picture: the face large, upright, symmetric, all as rigid as can be."""

from dataclasses import dataclass

import numpy as np

from caricli.geometry.flattening.embed_disc import embed_disc
from caricli.geometry.flattening.flatten import Limits, Sheet, flatten
from caricli.geometry.flattening.turn_upright import turn_upright
from caricli.geometry.repair.fill_holes import fill_holes
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.structures import Mesh
from caricli.structures.mesh import triangle_fans
from caricli.template.template import Template

GRID = 2**20
"""Parts of the picture's side to whose multiples places are rounded: single precision holds them exactly."""

SOFT = ("scalp", "neck")
"""Regions around the face that give way to it."""

_MEMBRANE = 0.02  # weight of what closes a hole, beside the surface's
_STRENGTHS = (1.0, 1e2, 1e4)  # of the limits, one after the other


@dataclass(frozen=True)
class Chart:
    """A part of the head that lies in one piece.

    region: of the annotation. inset: rings of its polygons at its border that stay with the skin, so that the seam is
    deeper in. size: picture widths for a metre. middle: (x, y) of the chart before the limits press it, from the middle
    of the picture's lower edge. limits: rows a, b, c of ``a |x| + b y <= c``, which the chart stays behind. uncut: how
    many vertices of the midline hold together what a cut along the others opens; None for no cut.
    """

    region: str
    inset: int
    size: float
    middle: tuple[float, float]
    limits: tuple[tuple[float, float, float], ...]
    uncut: int | None = None


@dataclass(frozen=True)
class LayoutSettings:
    """How the picture is shared out.

    size: picture widths for a metre of the face. sizes: of the regions of SOFT, for that of the face. smooth: rounds of
    blurring between these. soft: how much they count beside the face. uncut, limits: of the skin, as of a Chart.
    charts: those beside the skin, of the subject's left, which are mirrored, and of the middle.
    """

    size: float = 1 / 0.252
    sizes: tuple[float, ...] = (0.4, 0.55)
    smooth: int = 6
    soft: float = 0.3
    uncut: int = 2
    limits: tuple[tuple[float, float, float], ...] = (
        (1, 0, 0.495), (0, -1, -0.005), (0.3, -0.36, 0.056), (-0.3, 1, 0.885), (0, 1, 0.93), (0.8, 1, 1.21),
    )  # fmt: skip
    charts: tuple[Chart, ...] = (
        Chart("ear_left", 1, 2.9, (0.4, 0.09), ((1, 0, 0.495), (0, -1, -0.005), (-0.3, 0.36, -0.062))),
        Chart("eye_socket_left", 1, 1.2, (0.44, 0.94), ((1, 0, 0.495), (0, 1, 0.995), (-0.8, -1, -1.22))),
        Chart("nostril_left", 0, 3.4, (0.365, 0.97), ()),
        Chart("inner_mouth", 0, 1.2, (0, 0.95), ((0.3, -1, -0.895), (0, 1, 0.995)), 12),
    )  # fmt: skip


def lay_out_head(head: Template) -> Mesh:
    """Lay a head out in a picture.

    The skin is one chart, cut along the back of the head, its face of one size all over, scalp and neck giving way to
    it; ears, eye sockets, nostrils and the inside of the mouth are charts of their own. The picture is its own mirror
    image: a vertex is where its mirrored one is on the other side. Flattened by `flatten` from `embed_disc`.

    head: Template, mirror-symmetric in its polygons, whose annotation has the regions of the settings and the mirror.
    Returns it as a Mesh with the new UVs, multiples of 1 / GRID.
    """
    settings = LayoutSettings()
    mirror = head.annotation.mirror
    assert mirror is not None
    head = head.with_vertices((head.vertices + head.vertices[mirror] * [-1, 1, 1]) / 2)
    twins = _Twins(head, mirror)
    charts = _charts(head, settings)
    corners = np.full((*head.polygons.shape, 2), np.nan)
    skin = charts == len(settings.charts)
    corners[skin] = _flat_skin(head, settings, skin)
    for number, chart in enumerate(settings.charts):
        corners[charts == number] = _flat_part(head, chart, charts == number)
    corners = twins.symmetric(corners)
    assert np.isfinite(corners[head.polygons >= 0]).all(), "every polygon is in a chart or mirrored"
    return _with_corners(head, corners)


class _Twins:
    """Which polygon is the mirror image of which, and which of its corners of which."""

    def __init__(self, head: Mesh, mirror: np.ndarray) -> None:
        padded = np.append(mirror, len(mirror))  # the index -1 stays the largest
        polygons = np.where(head.polygons >= 0, head.polygons, len(mirror))
        order = np.argsort(polygons, axis=1)
        image_order = np.argsort(padded[polygons], axis=1)
        own = np.lexsort(np.take_along_axis(polygons, order, 1).T)
        image = np.lexsort(np.take_along_axis(padded[polygons], image_order, 1).T)
        self.polygon = np.empty(len(own), int)
        self.polygon[image] = own
        self.corner = np.empty_like(order)
        np.put_along_axis(self.corner, image_order, order[self.polygon], 1)

    def symmetric(self, corners: np.ndarray) -> np.ndarray:
        """Means of corners (P, N, 2) and their mirror images; where only one is there, it."""
        images = corners[self.polygon[:, None], self.corner] * [-1, 1]
        both = np.where(np.isnan(images), corners, images)
        return (np.where(np.isnan(corners), images, corners) + both) / 2


def _charts(head: Template, settings: LayoutSettings) -> np.ndarray:
    """(P,) int: the chart of every polygon, their number for the skin, -1 for mirror images of charts."""
    charts = np.full(len(head.polygons), len(settings.charts))
    for number, chart in enumerate(settings.charts):
        charts[_inside(head, chart.region, chart.inset)] = number
        other = chart.region.replace("_left", "_right")
        if other != chart.region:
            charts[_inside(head, other, chart.inset)] = -1
    return charts


def _inside(head: Template, region: str, inset: int) -> np.ndarray:
    """(P,) bool: polygons all of whose corners are in a region, without the outermost rings of them."""
    within = np.append(head.mask(region), True)  # what pads a row is everywhere
    inside = within[head.polygons].all(1)
    for _ in range(inset):
        within[:-1][np.setdiff1d(head.polygons[~inside], -1)] = False
        inside = within[head.polygons].all(1)
    return inside


def _flat_skin(head: Template, settings: LayoutSettings, skin: np.ndarray) -> np.ndarray:
    """Places (S, N, 2) of the corners of the skin's polygons (P,) bool."""
    polygons, source = _cut(head, head.polygons[skin], _seam(head, SOFT, settings.uncut))
    sizes = settings.size * _soft_sizes(head, settings)[source]
    soft = head.mask(*SOFT)[source][triangle_fans(polygons)].any(1)
    sheet = Sheet(head.vertices[source], triangle_fans(polygons), sizes, np.where(soft, settings.soft, 1.0))
    places = _flat(sheet, settings.limits, None)
    return places[polygons]


def _cut(head: Template, polygons: np.ndarray, seam: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut polygons (S, N) open along vertices (C,) of the midline, and give them numbers of their own.

    Returns them, and the vertices (T,) that their numbers stand for.
    """
    count = len(head.vertices)
    across = np.append(head.vertices[:, 0], 0)[polygons].sum(1, keepdims=True)
    apart = np.where((across < 0) & np.isin(polygons, seam), polygons + count, polygons)
    ids = np.unique(apart[apart >= 0])
    return np.where(apart >= 0, np.searchsorted(ids, apart), -1), ids % count


def _seam(head: Template, regions: tuple[str, ...], uncut: int) -> np.ndarray:
    """Vertices of the midline in regions, from its low hind end on, without the last ones."""
    assert head.annotation.mirror is not None
    middle = (head.annotation.mirror == np.arange(len(head.vertices))) & head.mask(*regions)
    adjacency, _ = vertex_neighbours(head.faces, len(head.vertices))
    beside = {int(v): adjacency[v].indices[middle[adjacency[v].indices]] for v in np.flatnonzero(middle)}
    ends = [v for v, others in beside.items() if len(others) == 1]
    path = [min(ends, key=lambda v: head.vertices[v, 1:].sum())]
    while ahead := [int(v) for v in beside[path[-1]] if v not in path[-2:]]:
        path.append(ahead[0])
    return np.array(path[: len(path) - uncut])


def _soft_sizes(head: Template, settings: LayoutSettings) -> np.ndarray:
    """(V,) sizes for that of the face."""
    _, mean = vertex_neighbours(head.faces, len(head.vertices))
    logarithms = np.zeros(len(head.vertices))
    for region, size in zip(SOFT, settings.sizes, strict=True):
        logarithms[head.mask(region)] = np.log(size)
    hard = head.mask("face", "nose")
    for _ in range(settings.smooth):
        logarithms = np.where(hard, 0, (logarithms + mean @ logarithms) / 2)
    return np.exp(logarithms)


def _flat_part(head: Template, chart: Chart, part: np.ndarray) -> np.ndarray:
    """Places (S, N, 2) of the corners of the chart's polygons (P,) bool."""
    seam = np.zeros(0, int) if chart.uncut is None else _seam(head, (chart.region,), chart.uncut)
    polygons, source = _cut(head, head.polygons[part], seam)
    faces = triangle_fans(polygons)
    sheet = Sheet(head.vertices[source], faces, np.full(len(source), chart.size), np.ones(len(faces)))
    return _flat(sheet, chart.limits, chart.middle)[polygons]


def _flat(
    sheet: Sheet, limits: tuple[tuple[float, float, float], ...], middle: tuple[float, float] | None
) -> np.ndarray:
    """Places (V, 2) of a sheet, upright as it is on the head, x from the middle of the picture.

    limits: rows of Limits. middle: where the chart's is before the limits press it; None for as low as they allow.
    """
    count = len(sheet.vertices)
    vertices, faces, loop = fill_holes(sheet.vertices, sheet.faces)
    sizes = np.append(sheet.sizes, np.full(len(vertices) - count, np.mean(sheet.sizes)))
    weights = np.append(sheet.weights, np.full(len(faces) - len(sheet.faces), _MEMBRANE))
    closed = Sheet(vertices, faces, sizes, weights)
    radius = np.linalg.norm(vertices[loop] - vertices[loop].mean(0), axis=1).mean() * np.mean(sheet.sizes)
    places = turn_upright(radius * embed_disc(vertices, faces, loop), vertices)
    places = turn_upright(flatten(closed, places), vertices)
    places += (0, -places[:, 1].min()) if middle is None else middle
    lines = np.reshape(limits, (-1, 3))
    lines = lines / np.linalg.norm(lines[:, :2], axis=1, keepdims=True)
    for strength in _STRENGTHS if len(lines) else ():
        places = flatten(closed, places, Limits(lines, strength))
    return places[:count]


def _with_corners(head: Template, corners: np.ndarray) -> Mesh:
    """The head as a Mesh with UVs at places (P, N, 2) of corners, x from the middle of the picture."""
    used = head.polygons >= 0
    # Rounded from the middle, so that what is left of it mirrors what is right of it to the last bit.
    places = np.round(corners[used] * GRID).astype(np.int64)
    keys = np.column_stack([head.polygons[used], places])
    unique, index = np.unique(keys, axis=0, return_inverse=True)
    uv_polygons = np.full(head.polygons.shape, -1, np.int32)
    uv_polygons[used] = index.ravel()
    return Mesh(head.vertices, head.polygons, unique[:, 1:] / GRID + [0.5, 0], uv_polygons)
