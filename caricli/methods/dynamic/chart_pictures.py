"""Pictures in the chart of the face, from and to the picture of the whole head."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError
from caricli.render.pixels.sample_texture import sample_pixels, uv_pixels
from caricli.render.visibility.corner_mix import corner_mix
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.structures import Face, Mesh
from caricli.structures.chart import FaceChart


class ChartGrid:
    """The texels of a chart's picture: which triangle lies under each, and how its corners mix there.

    chart: FaceChart. size: S, texels, width and height. face: (S, S) int, -1 where no triangle lies. weights: (S, S, 3)
    of the corners of the triangles. covered: (S, S) bool, where one lies. mouth: (S, S) bool, where the membrane lies.
    """

    def __init__(self, chart: FaceChart, size: int) -> None:
        """chart: FaceChart. size: texels."""
        self.chart = chart
        self.size = size
        flat = Mesh(np.column_stack([chart.uvs, np.zeros(len(chart.uvs))]), chart.faces, chart.uvs, chart.faces)
        self.face, self.weights = uv_map(flat, size)
        self.covered = self.face >= 0
        self.mouth = self.covered & chart.membrane[self.face]

    @cached_property
    def mix(self) -> sp.csr_matrix:
        """(T, N) float32, sparse: how the chart's vertices mix at the texels that are covered, row by row."""
        corners = self.chart.faces[self.face[self.covered]]
        mix = corner_mix(corners, self.weights[self.covered], len(self.chart.vertices))
        mix.sort_indices()  # then no sum hangs on which corner of a triangle is its first
        return mix

    def bake(self, values: np.ndarray) -> np.ndarray:
        """Values (V, C) of the mesh's vertices at the texels: (S, S, C) float32, zero where not covered."""
        return self.bake_own(np.asarray(values)[self.chart.vertices])

    def bake_own(self, values: np.ndarray) -> np.ndarray:
        """Values (N, C) of the chart's vertices at the texels: (S, S, C) float32, zero where not covered."""
        values = np.asarray(values, np.float32)
        baked = np.zeros((*self.covered.shape, *values.shape[1:]), np.float32)
        baked[self.covered] = self.mix @ values
        return baked.reshape(self.size, self.size, -1)


def texture_to_chart(picture: np.ndarray, template: Mesh, grid: ChartGrid) -> np.ndarray:
    """The face of a head's texture in the chart.

    What lies between the lips goes over from one to the other; holes and what is around the face take the nearest
    colour.

    picture: (H, W, C), the top row first. template: Mesh with UVs. grid: ChartGrid.
    Returns (S, S, C) of the picture's type. Raises InputError where the mesh has no UVs or is not the chart's.
    """
    chart = grid.chart
    places = uv_pixels(_corners(template, chart), picture.shape[:2])[grid.face[grid.covered]]
    samples = np.zeros((grid.size, grid.size, *picture.shape[2:]), np.float32)
    at = np.einsum("nk,nkc->nc", grid.weights[grid.covered], places)
    image = _floats(picture)
    samples[grid.covered] = sample_pixels(image, at[:, 0], at[:, 1])
    if grid.mouth.any():
        rim = _rim_colours(image, template, chart)
        samples[grid.mouth] = grid.bake_own(rim)[grid.mouth].reshape(-1, *picture.shape[2:])
    return _like(pad_texture(samples, grid.covered), picture)


def chart_to_texture(picture: np.ndarray, template: Mesh, grid: ChartGrid, size: int) -> np.ndarray:
    """A picture in the chart at the places that the head's texture has for it.

    picture: (H, W, C), of any size, the top row first. template: Mesh with UVs. grid: ChartGrid of the chart. size: of
    the texture, texels.
    Returns (size, size, C) of the picture's type, zero where the texture shows no face; `face_texels` says where it
    does. Raises InputError where the mesh has no UVs or is not the chart's.
    """
    face, weights = _face_in_texture(template, grid.chart, size)
    shown = face >= 0
    padded = pad_texture(picture, grid.covered) if picture.shape[:2] == grid.covered.shape else picture
    places = uv_pixels(grid.chart.uvs, picture.shape[:2])[grid.chart.faces[face[shown]]]
    at = np.einsum("nk,nkc->nc", weights[shown], places)
    texture = np.zeros((size, size, *picture.shape[2:]), np.float32)
    texture[shown] = sample_pixels(_floats(padded), at[:, 0], at[:, 1])
    return _like(texture, picture)


def face_texels(template: Mesh, grid: ChartGrid, size: int) -> np.ndarray:
    """(size, size) bool, where the head's texture shows what is in the chart."""
    return _face_in_texture(template, grid.chart, size)[0] >= 0


def picture_to_chart(picture: np.ndarray, face: Face, grid: ChartGrid) -> np.ndarray:
    """What a picture shows at the places of the face, whether they are seen or not; of open lips what is between them.

    picture: (H, W, 3) uint8. face: Face with the camera that it is seen by. grid: ChartGrid of its mesh.
    Returns (S, S, 3) uint8; holes and what is around the face take the nearest colour. Raises InputError where the face
    has no camera or is of another mesh.
    """
    _check(face.mesh, grid.chart)
    places = grid.bake(face.require_camera().place(face.vertices))[grid.covered]
    samples = np.zeros((grid.size, grid.size, 3), np.float32)
    samples[grid.covered] = sample_pixels(_floats(picture), places[:, 0], places[:, 1])
    return _like(pad_texture(samples, grid.covered), picture)


def _face_in_texture(template: Mesh, chart: FaceChart, size: int) -> tuple[np.ndarray, np.ndarray]:
    """The chart's triangles (size, size) under the texels of a head's texture, -1 for none, and their weights."""
    _check(template, chart)
    face, weights = uv_map(template, size)
    rows = np.full(len(template.faces) + 1, -1)  # the last stands for no triangle
    rows[chart.triangles[~chart.membrane]] = np.flatnonzero(~chart.membrane)
    return rows[face], weights


def _corners(template: Mesh, chart: FaceChart) -> np.ndarray:
    """(G, 3, 2) where the corners of the chart's triangles lie in the head's texture; any for the membrane."""
    _check(template, chart)
    if template.uvs is None:
        raise InputError("a texture in the chart needs a mesh with UVs, found one without")
    return template.uvs[template.uv_faces[chart.triangles]]


def _rim_colours(image: np.ndarray, template: Mesh, chart: FaceChart) -> np.ndarray:
    """(N, C) colours of the chart's vertices."""
    corners = uv_pixels(_corners(template, chart)[~chart.membrane], image.shape[:2]).reshape(-1, 2)
    rows = chart.faces[~chart.membrane].ravel()
    samples = sample_pixels(image, corners[:, 0], corners[:, 1]).reshape(len(rows), -1)
    sums = sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), (len(chart.vertices), len(rows)))
    return (sums @ samples) / np.asarray(sums.sum(1))


def _floats(picture: np.ndarray) -> np.ndarray:
    return np.asarray(picture, np.float32)


def _like(values: np.ndarray, picture: np.ndarray) -> np.ndarray:
    """Values as those of the picture: whole numbers where these are."""
    if picture.dtype == np.uint8:
        return np.round(np.clip(values, 0, 255)).astype(np.uint8)
    return values.astype(picture.dtype)


def _check(mesh: Mesh, chart: FaceChart) -> None:
    if mesh.topology_id != chart.topology_id:
        raise InputError("expected the mesh that the chart was made of, found another one")
