"""How the face's chart and the head's own layout lie on the face: sizes, angles, and what of the picture each gives.

Usage: python benchmarks/chart.py OUT.json. On the neutral open head and on 10 random people of seed 19001, whose shapes
the chart was not made for. Of every triangle of the face its length and breadth in the picture, for one metre: `angles`
is the larger over the smaller (1 keeps angles), `sizes` their mean's 5th to 95th percentile over the median (1 keeps
areas), all weighted by area on the surface; `flipped` triangles lie upside down. `igl.ARAP` is libigl's own
parameterisation from the same start (elements, until nothing moves), of the surface with eyes and mouth as holes: it
knows no membrane and no sizes. `shares` are of the whole picture. `round_trip` is the mean difference, of 255, of a
picture of 1024 texels after it went to a chart of 1024 and back, where the face is: of noise, on average 50 from its
mean, blurred by 1.5 texels and by 4, as strokes and as shading are.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

import cv2
import igl
import numpy as np

from caricli.data.identities import random_identity
from caricli.geometry.flattening.embed_disc import embed_disc
from caricli.geometry.flattening.triangle_stretch import triangle_stretch
from caricli.geometry.repair.fill_holes import fill_holes
from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.dynamic.chart_pictures import ChartGrid, chart_to_texture, face_texels, texture_to_chart
from caricli.structures import Mesh
from caricli.template.chart import ChartSettings, face_chart
from caricli.template.head import load_head

SEED = 19001
PEOPLE = 10
SIDE = 1024
ROUNDS = 200
MOUTHS = 0.02  # metres around the inner lips


def distortion(mesh: Mesh) -> dict[str, float]:
    """Of a Mesh with UVs."""
    assert mesh.uvs is not None
    areas = np.linalg.norm(triangle_normals(mesh.vertices, mesh.faces), axis=1) / 2
    whole = areas > 1e-12
    stretch = triangle_stretch(mesh.vertices, mesh.faces[whole], mesh.uvs, mesh.uv_faces[whole])
    weights = areas[whole]
    larger, smaller = np.abs(stretch).T
    sizes = quantiles(np.sqrt(larger * smaller), weights, (0.05, 0.5, 0.95))
    angles = quantiles(larger / np.maximum(smaller, 1e-9), weights, (0.5, 0.95))
    return {
        "angles_median": angles[0],
        "angles_95": angles[1],
        "sizes_5": sizes[0] / sizes[1],
        "sizes_95": sizes[2] / sizes[1],
        "flipped": int((stretch[:, 1] <= 0).sum()),
    }


def quantiles(values: np.ndarray, weights: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    """Of values (N,) with weights (N,)."""
    order = np.argsort(values)
    return np.interp(shares, np.cumsum(weights[order]) / weights.sum(), values[order])


def area(mesh: Mesh) -> float:
    """Share of the picture that a Mesh with UVs takes."""
    assert mesh.uvs is not None
    corners = mesh.uvs[mesh.uv_faces]
    return float(np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 2)


def igl_uvs(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V, 2) by libigl's ARAP."""
    closed, filled, loop = fill_holes(vertices, faces)
    radius = np.linalg.norm(vertices[loop] - vertices[loop].mean(0), axis=1).mean()
    places = radius * embed_disc(closed, filled, loop)[: len(vertices)]
    data = igl.ARAPData()
    data.max_iter = ROUNDS
    igl.arap_precomputation(vertices, np.asarray(faces, np.int64), 2, np.zeros(0, np.int32), data)
    return igl.arap_solve(np.zeros((0, 2)), data, np.ascontiguousarray(places))


def part(mesh: Mesh, kept: np.ndarray) -> Mesh:
    """Of a Mesh the triangles (F,) bool."""
    assert mesh.uvs is not None
    return Mesh(mesh.vertices, mesh.faces[kept], mesh.uvs, mesh.uv_faces[kept])


def layouts(head: Mesh, settings: ChartSettings) -> dict[str, tuple[Mesh, np.ndarray]]:
    """By name: the face's surface with UVs, and which of its triangles are of the mouth."""
    template = load_head().template()
    chart = face_chart(template, settings)
    skin = ~chart.membrane
    lips = template.vertices[np.unique(chart.corners[chart.membrane])]
    middles = template.vertices[chart.corners[skin]].mean(1)
    mouth = np.linalg.norm(middles[:, None] - lips, axis=2).min(1) < MOUTHS
    own = Mesh(head.vertices[chart.vertices], chart.faces[skin], chart.uvs, chart.faces[skin])
    flat = igl_uvs(np.asarray(template.vertices[chart.vertices], float), chart.faces[skin])
    rigid = Mesh(own.vertices, chart.faces[skin], flat, chart.faces[skin])
    return {
        "chart": (own, mouth),
        "head": (
            Mesh(head.vertices, head.faces[chart.triangles[skin]], head.uvs, head.uv_faces[chart.triangles[skin]]),
            mouth,
        ),
        "igl.ARAP": (rigid, mouth),
    }


def main(out: Path) -> None:
    """Measure, print and write."""
    head = load_head()
    neutral = head.template()
    generator = np.random.default_rng(SEED)
    people = [head.evaluate(**asdict(random_identity(head, generator))) for _ in range(PEOPLE)]
    figures: dict = {}
    for name, (mesh, mouth) in layouts(neutral, ChartSettings()).items():
        figures[name] = {"neutral": distortion(mesh)}
        rows = [distortion(layouts(neutral.with_vertices(person), ChartSettings())[name][0]) for person in people]
        figures[name]["people"] = {key: float(np.mean([row[key] for row in rows])) for key in rows[0]}
        if name != "igl.ARAP":
            figures[name]["shares"] = {"face": area(mesh), "mouth": area(part(mesh, mouth))}
    chart = face_chart(neutral)
    membrane = Mesh(
        neutral.vertices[chart.vertices], chart.faces[chart.membrane], chart.uvs, chart.faces[chart.membrane]
    )
    figures["chart"]["shares"]["membrane"] = area(membrane)
    figures["chart of one size"] = {"neutral": distortion(layouts(neutral, ChartSettings(mouth=1.0))["chart"][0])}
    grid = ChartGrid(chart, SIDE)
    shown = face_texels(neutral, grid, SIDE)
    figures["round_trip"] = {}
    for blur in (1.5, 4.0):
        noise = cv2.GaussianBlur(generator.normal(size=(SIDE, SIDE, 3)), (0, 0), blur)
        picture = np.clip(128 + 50 * noise / np.abs(noise).mean(), 0, 255).astype(np.uint8)
        back = chart_to_texture(texture_to_chart(picture, neutral, grid), neutral, grid, SIDE)
        figures["round_trip"][f"blurred by {blur:g}"] = float(np.abs(back[shown].astype(float) - picture[shown]).mean())
    print(json.dumps(figures, indent=1))
    out.write_text(json.dumps(figures, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
