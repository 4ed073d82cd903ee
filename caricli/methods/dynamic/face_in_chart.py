"""A painted face in the chart: its texture there, and the mesh that it lies on."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.dynamic.chart_pictures import ChartGrid, picture_to_chart, texture_to_chart
from caricli.methods.texture.paint_head import Painted
from caricli.structures import Face, Mesh
from caricli.structures.chart import FaceChart


@dataclass(frozen=True, eq=False)
class ChartedFace:
    """The face of a head by itself.

    mesh: Mesh of the chart's vertices and triangles, the membrane among them, with the chart's UVs. picture: (S, S, 3)
    uint8 sRGB on these.
    """

    mesh: Mesh
    picture: np.ndarray


def chart_mesh(chart: FaceChart, mesh: Mesh) -> Mesh:
    """The face of a head as a Mesh with the chart's UVs. mesh: Mesh of the whole head that the chart is of."""
    return Mesh(mesh.vertices[chart.vertices], chart.faces, chart.uvs, chart.faces)


def face_in_chart(painted: Painted, face: Face, picture: np.ndarray, chart: FaceChart) -> ChartedFace:
    """Bring a painted head's face into the chart, as fine as its texture; what is between the lips is the picture's.

    face: Face with the camera of its picture (H, W, 3) uint8. chart: FaceChart of its mesh.
    """
    texture = painted.pictures.skin
    assert texture is not None
    grid = ChartGrid(chart, len(texture))
    charted = texture_to_chart(texture, painted.head, grid)
    charted[grid.mouth] = picture_to_chart(picture, face, grid)[grid.mouth]
    return ChartedFace(chart_mesh(chart, painted.head), charted)
