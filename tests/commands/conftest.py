"""Inputs for commands: landmarks of a known face, a small dataset and models trained on it, another topology."""

from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import linear_sum_assignment

from caricli.cli import COMMANDS, cli
from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.io.directions import write_directions
from caricli.io.landmarks import write_landmarks
from caricli.io.meshes.obj import write_obj
from caricli.io.strict_json import format_json, write_json
from caricli.render.sky import DIRECTIONS
from caricli.store.models import load_model
from caricli.structures import Directions, Landmarks, Mesh
from tests.reports import untold_keys


@pytest.fixture(scope="session", autouse=True)
def told_reports():
    """Whatever reports hold that are written here, docs/formats.md says what it is; that is looked at when all ran."""
    untold = {}

    def told(value, *arguments, **options):
        # What `inspect` says of a report names its command, too.
        if isinstance(value, dict) and value.get("command") in COMMANDS and "whole" not in value:
            untold.setdefault(value["command"], set()).update(untold_keys(value))
        return format_json(value, *arguments, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.io.strict_json.format_json", told)
        yield
    assert {name: keys for name, keys in untold.items() if keys} == {}


@pytest.fixture(scope="session")
def run():
    """Run a command in the real group."""
    return lambda *args: CliRunner().invoke(cli, [str(arg) for arg in args])


@pytest.fixture(scope="module")
def small_pictures():
    """Views of 48 pixels in the sheets of faces, which are otherwise most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("encode", "sample", "interpolate", "edit_handle", "edit_semantic", "caricaturize", "refine"):
            patch.setattr(f"caricli.commands.{name}.SIZE", 48)
        patch.setattr("caricli.render.sheets.expression_sheet.SIZE", 48)
        yield


@pytest.fixture(scope="module")
def quick_pictures(small_pictures):
    """Small pictures without shadows, which take most of the time that is left."""

    def lit(vertices, faces, normals, ids=None, directions=DIRECTIONS):
        return np.ones((len(vertices if ids is None else ids), len(directions)), np.float32)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.render.rig_stage.sky_visibility", lit)
        yield


@pytest.fixture(scope="session")
def refused(run):
    """Run a command that must fail with exit 1 and one line on stderr; returns the line."""

    def check(*args, code=1):
        result = run(*args)
        assert result.exit_code == code, result.output
        assert result.stdout == ""
        assert result.stderr.count("\n") == 1 and result.stderr.startswith("caricli: error: "), result.stderr
        assert "bug in caricli" not in result.stderr
        return result.stderr

    return check


@pytest.fixture(scope="session")
def points(head, head_template):
    """81 landmarks of a smiling head turned by 10 degrees, in a picture of 400 x 400 pixels."""
    face = head.evaluate(gender=0.2, age=0.8, actions={"mouthSmileLeft": 0.6, "mouthSmileRight": 0.6})
    rotation = rotation_matrices(np.radians([[0, 10.0, 0]]))[0] @ np.diag([1.0, -1, -1])
    marks = 1400 * face[head_template.annotation.landmarks] @ rotation[:2].T
    return marks - marks.mean(0) + [200.0, 210.0]


@pytest.fixture
def marks(points, tmp_path):
    """A landmark file."""
    path = tmp_path / "marks.json"
    write_landmarks(path, Landmarks(points[:68], (400, 400)))
    return path


@pytest.fixture(scope="session")
def dataset(run, tmp_path_factory):
    """A grid of 4 people whom no bundled model has seen, 2 expressions and 2 levels, made by the command."""
    folder = tmp_path_factory.mktemp("data") / "dataset"
    sizes = ("--identities", 4, "--expressions", 2, "--levels", 2, "--workers", 2, "--seed", 5)
    result = run("dataset", "build", folder, *sizes)
    assert result.exit_code == 0, result.output
    assert f"{folder}: 16 meshes, flipped triangles 0." in result.stdout
    return folder


@pytest.fixture(scope="session")
def models(run, dataset, tmp_path_factory):
    """Paths by kind of small models trained on the dataset, made by the commands."""
    folder, paths = tmp_path_factory.mktemp("models"), {}
    for kind in ("pca", "intrinsic", "kernel"):
        paths[kind] = folder / f"{kind}.safetensors"
        result = run("train", kind, "--data", dataset, "--out", paths[kind], "--set", "dimension=5")
        assert result.exit_code == 0, result.output
        assert f"{paths[kind]}: 5 dimensions, shape error train " in result.stdout
    return paths


@pytest.fixture(scope="session")
def directions(models, tmp_path_factory):
    """Paths by kind of directions of the small models: three labels, the axes of the whitened latents."""
    folder, paths, five = tmp_path_factory.mktemp("directions"), {}, np.eye(5)[:3]
    for kind, path in models.items():
        paths[kind] = folder / f"{kind}.npz"
        labels = Directions(
            names=("BigNose", "Smile", "Caricature"),
            normals=five,
            gradients=five[[0, 0, 2]],
            auc=np.full(3, 0.9),
            positives=np.array([4, 5, 6]),
            count=12,
            cost=np.full(3, 0.1),
            change=np.array([1.0, 0.5, -0.5]),
            model_id=load_model(path).model_id,
            recipe={},
            people=3 * np.eye(5),
        )
        write_directions(paths[kind], labels)
    return paths


@pytest.fixture(scope="session")
def smile(head, tmp_path_factory):
    """An OBJ of a head with an expression, somewhere else than the template."""
    path = tmp_path_factory.mktemp("smile") / "smile.obj"
    vertices = head.evaluate(gender=0.3, actions={"mouthSmileLeft": 0.8}) + [0.01, 0.02, 0.03]
    write_obj(path, Mesh(vertices, head.polygons, head.uvs, head.uv_polygons))
    return path


@pytest.fixture(scope="session")
def egg(head_template):
    """A coarse head: quads around, triangles at the poles, a UV seam at the back; and a way to draw its shapes."""
    columns, rows = 26, 18
    turn = 2 * np.pi * (np.arange(columns) + 0.5) / columns + np.pi
    lift = np.linspace(-0.45, 0.45, rows) * np.pi
    lift, turn = np.meshgrid(lift, turn, indexing="ij")
    side = np.stack([np.sin(turn) * np.cos(lift), np.sin(lift), np.cos(turn) * np.cos(lift)], -1).reshape(-1, 3)
    vertices = np.vstack([side, [[0, -1, 0], [0, 1, 0]]]) * [0.075, 0.12, 0.095]
    row, column = (a.ravel() for a in np.mgrid[0 : rows - 1, 0:columns])
    right, ring, none = (column + 1) % columns, np.arange(columns), np.full(columns, -1)
    quads = np.stack([row * columns + column, row * columns + right, (row + 1) * columns + right], -1)
    quads = np.c_[quads, (row + 1) * columns + column]
    low, top = np.full(columns, rows * columns), (rows - 1) * columns
    caps = np.c_[(ring + 1) % columns, ring, low, none], np.c_[top + ring, top + (ring + 1) % columns, low + 1, none]
    polygons = np.vstack([quads, *caps]).astype(np.int32)
    wide = columns + 1
    uv_quads = np.stack([row * wide + column, row * wide + column + 1, (row + 1) * wide + column + 1], -1)
    uv_quads = np.c_[uv_quads, (row + 1) * wide + column]
    uv_low, uv_top = np.full(columns, rows * wide), (rows - 1) * wide
    uv_caps = np.c_[ring + 1, ring, uv_low, none], np.c_[uv_top + ring, uv_top + ring + 1, uv_low + 1, none]
    u, v = np.meshgrid(np.linspace(0, 1, wide), np.linspace(0.05, 0.95, rows))
    uvs = np.vstack([np.stack([u, v], -1).reshape(-1, 2), [[0.5, 0], [0.5, 1]]])
    uv_polygons = np.vstack([uv_quads, *uv_caps]).astype(np.int32)

    # Landmarks where a face has them: the head's, laid over the egg, each on a vertex of its own in front.
    wanted = head_template.vertices[head_template.annotation.landmarks[:68], :2]
    wanted = (wanted - wanted.mean(0)) / np.ptp(wanted, axis=0) * [0.13, 0.15]
    front = np.flatnonzero(vertices[:, 2] > 0.01)
    distance = ((vertices[front, None, :2] - wanted[None]) ** 2).sum(-1)
    landmarks = front[linear_sum_assignment(distance.T)[1]]
    paths = []
    for landmark in landmarks[:17]:
        own_row, own = divmod(int(landmark), columns)
        step = 1 if vertices[landmark, 0] < 0 else -1
        paths.append([own_row * columns + (own + step * k) % columns for k in range(-1, 3)])
    annotation = {"ibug68": landmarks.tolist(), "jaw_paths": paths}

    generator = np.random.default_rng(11)
    waves, phases = generator.normal(size=(4, 3)) * 14, generator.uniform(0, 6, 4)
    axes = generator.normal(size=(4, 3)) * [0.008, 0.008, 0.004]
    fields = np.sin(vertices @ waves.T + phases).T[:, :, None] * axes[:, None]

    def shape(latent):
        return vertices + np.tensordot(latent, fields, 1)

    def write(path, latent):
        write_obj(path, Mesh(shape(latent), polygons, uvs, uv_polygons))

    return SimpleNamespace(vertices=vertices, polygons=polygons, annotation=annotation, shape=shape, write=write)


@pytest.fixture(scope="session")
def eggs(egg, tmp_path_factory):
    """A folder of 12 OBJ files of random eggs, and beside it annotation.json."""
    folder, generator = tmp_path_factory.mktemp("eggs") / "scans", np.random.default_rng(3)
    folder.mkdir()
    for number in range(12):
        egg.write(folder / f"egg_{number:02d}.obj", generator.normal(size=4))
    write_json(folder.parent / "annotation.json", egg.annotation)
    return folder
