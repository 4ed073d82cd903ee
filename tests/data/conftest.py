"""Small datasets, built once."""

import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from caricli.data import build_dataset as building
from caricli.data.build_dataset import build_dataset
from caricli.data.build_settings import BuildSettings, OwnSettings
from caricli.io.meshes.obj import write_obj
from caricli.io.strict_json import write_json
from caricli.structures import Mesh
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template


@pytest.fixture(scope="session")
def small_prior():
    """The prior of the exaggeration by parts, from few shapes: most of the time of a tiny build."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "PRIOR_SHAPES", 16)
        patch.setattr(building, "PRIOR_DIMENSION", 8)
        yield


@pytest.fixture(scope="session")
def random_settings():
    return BuildSettings(count=12, identities=5)


@pytest.fixture(scope="session")
def built(tmp_path_factory, small_prior, random_settings):
    """(folder, summary, calls of progress) of 12 random draws, built by two workers."""
    folder, calls = tmp_path_factory.mktemp("built"), []
    return folder, build_dataset(folder, random_settings, 2, lambda *numbers: calls.append(numbers)), calls


@pytest.fixture(scope="session")
def own_built(tmp_path_factory, small_prior):
    """(folder, summary) of 10 random draws of people's own features, built by one worker."""
    folder = tmp_path_factory.mktemp("own_built")
    return folder, build_dataset(folder, OwnSettings(count=10, identities=4, regular=0.3, parts=0.55), 1)


@pytest.fixture(scope="session")
def grid(tmp_path_factory):
    """(folder, summary) of a full grid of 2 people, 3 expressions and 4 levels."""
    folder = tmp_path_factory.mktemp("grid")
    return folder, build_dataset(folder, BuildSettings(identities=2, expressions=3, levels=4), 2)


@pytest.fixture(scope="session")
def barrel(head_template):
    """A coarse closed mesh with quads at its side, triangles at its ends and a UV seam; template included."""
    rows, columns = 6, 10
    turn = 2 * np.pi * np.arange(columns) / columns
    height = np.linspace(-0.8, 0.8, rows)
    x, y = np.sqrt(1 - height[:, None] ** 2) * np.sin(turn), np.repeat(height[:, None], columns, 1)
    z = np.sqrt(1 - height[:, None] ** 2) * np.cos(turn)
    side = np.stack([x, y, z], -1).reshape(-1, 3) * [0.07, 0.11, 0.09]
    vertices = np.vstack([side, [[0, -0.11, 0], [0, 0.11, 0]]])
    row, column = (a.ravel() for a in np.mgrid[0 : rows - 1, 0:columns])
    right = (column + 1) % columns
    quads = np.stack([row * columns + column, row * columns + right, (row + 1) * columns + right], -1)
    quads = np.c_[quads, (row + 1) * columns + column]
    ring, low, high = np.arange(columns), rows * columns, rows * columns + 1
    next_ring, none = (ring + 1) % columns, np.full(columns, -1)
    bottom = np.stack([next_ring, ring, np.full(columns, low), none], -1)
    top = np.stack([ring, next_ring, none, none], -1) + (rows - 1) * columns
    top[:, 2:] = high, -1
    polygons = np.vstack([quads, bottom, top]).astype(np.int32)
    # One column of UVs more than of vertices: vertices of the first column have two.
    wide = columns + 1
    u, v = np.meshgrid(np.linspace(0, 1, wide), np.linspace(0.1, 0.9, rows))
    uvs = np.vstack([np.stack([u, v], -1).reshape(-1, 2), [[0.5, 0], [0.5, 1]]])
    uv_quads = np.stack([row * wide + column, row * wide + column + 1, (row + 1) * wide + column + 1], -1)
    uv_quads = np.c_[uv_quads, (row + 1) * wide + column]
    uv_bottom = np.stack([ring + 1, ring, np.full(columns, rows * wide), none], -1)
    uv_top = np.stack([ring + (rows - 1) * wide, ring + 1 + (rows - 1) * wide], -1)
    uv_top = np.c_[uv_top, np.full(columns, rows * wide + 1), none]
    uv_polygons = np.vstack([uv_quads, uv_bottom, uv_top]).astype(np.int32)
    # Landmarks about where a face has them; the inner lips, for which no vertices are left, are the outer ones.
    wanted = head_template.vertices[head_template.annotation.landmarks[:60]]
    wanted = (wanted - wanted.mean(0)) / np.ptp(wanted, axis=0) * [0.14, 0.2, 0.12]
    outer = linear_sum_assignment(((wanted[:, None] - vertices) ** 2).sum(-1))[1].tolist()
    annotation = {"ibug68": outer + [outer[k] for k in (48, 50, 51, 52, 54, 56, 57, 58)]}
    parsed = parse_annotation(annotation, len(vertices), "barrel")
    template = Template(vertices, polygons, uvs, uv_polygons, annotation=parsed)
    return SimpleNamespace(template=template, annotation=annotation, mesh=Mesh(vertices, polygons, uvs, uv_polygons))


@pytest.fixture
def barrels(barrel, tmp_path):
    """(folder of 12 OBJ files, (12, V, 3) their vertices, path of the annotation)."""
    folder, generator = tmp_path / "scans", np.random.default_rng(5)
    folder.mkdir()
    bend = generator.normal(size=(12, 3, 3)) * 0.08
    shapes = barrel.template.vertices @ (np.eye(3) + bend)
    for number, shape in enumerate(shapes):
        mesh = barrel.mesh
        write_obj(folder / f"scan_{number:02d}.obj", Mesh(shape, mesh.polygons, mesh.uvs, mesh.uv_polygons))
    write_json(tmp_path / "annotation.json", barrel.annotation)
    return folder, shapes, tmp_path / "annotation.json"


@pytest.fixture
def copy_of_grid(grid, tmp_path):
    """A copy of the grid that a test may damage."""
    return shutil.copytree(grid[0], tmp_path / "copy")
