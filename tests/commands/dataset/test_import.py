import json

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.errors import InputError
from caricli.io.meshes.mesh import write_mesh
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.strict_json import write_json
from caricli.methods.parts.attachment import attachment_for
from caricli.store.models import load_model
from caricli.structures import Material, Mesh


@pytest.fixture
def annotation(eggs):
    return eggs.parent / "annotation.json"


def test_meshes_become_a_dataset(run, eggs, annotation, tmp_path):
    labels = tmp_path / "labels.csv"
    labels.write_text("file,Smile\n" + "".join(f"egg_{k:02d}.obj,{k - 6}\n" for k in range(12)))
    out = tmp_path / "deep" / "d"
    result = run("dataset", "import", eggs, out, "--annotation", annotation, "--labels", labels)
    assert result.exit_code == 0 and result.stdout.startswith(
        f"{out}: 12 meshes, people 12, expressions 1, 0.240 m high, taken as given in m, "
    ), result.output
    data = read_dataset(out)
    first = read_obj(eggs / "egg_05.obj")
    np.testing.assert_allclose(data.vertices[5], first.vertices, atol=1e-7)
    np.testing.assert_array_equal(data.template.polygons, first.polygons)
    assert data.attributes == ("Smile",) and data.labels[:, 0].sum() == 5


def test_what_exists_is_replaced_only_when_told_to(run, refused, eggs, annotation, tmp_path):
    out = tmp_path / "d"
    assert run("dataset", "import", eggs, out, "--annotation", annotation).exit_code == 0
    assert "--overwrite" in refused("dataset", "import", eggs, out, "--annotation", annotation)
    assert run("dataset", "import", eggs, out, "--annotation", annotation, "--overwrite").exit_code == 0


def test_bad_input_is_one_line_and_leaves_nothing(run, refused, eggs, annotation, egg, tmp_path):
    out, scans = tmp_path / "out", tmp_path / "scans"
    scans.mkdir()
    for number in range(3):
        egg.write(scans / f"{number}.obj", np.zeros(4))

    def check(*words, folder=scans, note=annotation, labels=()):
        said = refused("dataset", "import", folder, out, "--annotation", note, *labels)
        assert all(word in said for word in words), said
        assert not out.exists()

    check("missing", folder=tmp_path / "missing")
    check("no.json", note=tmp_path / "no.json")
    check("folder", note=scans)
    check("0.obj", note=scans / "0.obj")
    check("l.csv", labels=("--labels", tmp_path / "l.csv"))
    (tmp_path / "l.csv").write_text("file,Smile\n0.obj,nan\n1.obj,1\n2.obj,1\n")
    check("l.csv", "line 2", labels=("--labels", tmp_path / "l.csv"))
    bad = b"", b"<html></html>", b"v 0 0\n", b"v 0 0 nan\n", b"f 1 2 3\n", b"\x80\x04\x95.", b"v 1e308 0 0\n"
    for content in bad:
        (scans / "1.obj").write_bytes(content)
        check("1.obj")
    (scans / "1.obj").write_bytes((scans / "0.obj").read_bytes().replace(b"\nf ", b"\nf 1/1 2/2 3/3\nf ", 1))
    check("1.obj", "0.obj")
    sorted_names = sorted(path.name for path in tmp_path.iterdir())
    assert sorted_names == ["l.csv", "scans"]


def test_what_is_left_out_and_lacking_is_told(run, eggs, annotation, tmp_path):
    scans = tmp_path / "scans"
    scans.mkdir()
    for number, path in enumerate(sorted(eggs.glob("*.obj"))):
        (scans / f"{number}__smile.obj").write_bytes(path.read_bytes())
    write_mesh(scans / "a.ply", read_obj(path))
    result = run("dataset", "import", scans, tmp_path / "d", "--annotation", annotation)
    assert result.exit_code == 0, result.output
    assert "left out 1 meshes of other formats" in result.stderr and "no mesh is neutral" in result.stderr


def test_an_output_is_never_an_input(refused, eggs, annotation, tmp_path):
    before = sorted(path.name for path in eggs.iterdir())
    said = refused("dataset", "import", eggs, eggs, "--annotation", annotation, "--overwrite")
    assert "input" in said
    said = refused("dataset", "import", eggs, eggs.parent, "--annotation", annotation, "--overwrite")
    assert "input" in said
    assert sorted(path.name for path in eggs.iterdir()) == before


def row_of_teeth(egg, folder, **entry):
    """A little box inside an egg as a file of parts, and the annotation of the egg with it."""
    value = json.loads((folder / "annotation.json").read_text())
    vertices = egg.vertices
    low = vertices.mean(0) - 0.05 * np.ptp(vertices, axis=0)
    corners = low + 0.1 * np.ptp(vertices, axis=0) * np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), -1).reshape(-1, 3)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    write_obj(folder / "teeth.obj", Mesh(corners, quads))
    value["regions"] = {"skull": np.flatnonzero(vertices[:, 1] > low[1]).tolist()}
    value["regions"]["jaw"] = np.flatnonzero(vertices[:, 1] <= low[1]).tolist()
    value["parts"] = {"teeth_lower": {"file": "teeth.obj", "hangs_on": "jaw"} | entry}
    return value


def test_parts_come_with_the_annotation_and_stay_in_a_model(run, eggs, tmp_path):
    write_json(tmp_path / "annotation.json", json.loads((eggs.parent / "annotation.json").read_text()))
    egg = read_obj(eggs / "egg_00.obj")
    write_json(tmp_path / "annotation.json", row_of_teeth(egg, tmp_path))
    out = tmp_path / "d"
    assert run("dataset", "import", eggs, out, "--annotation", tmp_path / "annotation.json").exit_code == 0
    data = read_dataset(out)
    result = run("train", "pca", "--data", out, "--out", tmp_path / "m.safetensors", "--set", "dimension=3")
    assert result.exit_code == 0, result.output
    model = load_model(tmp_path / "m.safetensors")
    for template in (data.template, model.template):
        attachment = attachment_for(template)
        (teeth,) = attachment.attach(egg)
        assert np.abs(teeth.mesh.vertices - read_obj(tmp_path / "teeth.obj").vertices).max() < 1e-6
        (there,) = attachment.attach(egg.with_vertices(1.5 * egg.vertices + [0, 0.1, 0]))
        assert np.abs(there.mesh.vertices - 1.5 * teeth.mesh.vertices - [0, 0.1, 0]).max() < 1e-6
        assert set(there.materials) == {Material.TEETH}
        with pytest.raises(InputError, match="expected a head without teeth of its own for cartoon ones"):
            attachment_for(template, "cartoon")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda value: value["parts"]["teeth_lower"].pop("hangs_on"), "lower: hangs_on: expected skull or jaw"),
        (lambda value: value["regions"].pop("jaw"), "lower: expected 'regions.jaw', the vertices that it"),
        (lambda value: value["parts"]["teeth_lower"].pop("file"), "lower: file: expected str"),
        (lambda value: value["parts"]["teeth_lower"].update(file="../teeth.obj"), "parts.teeth_lower: expected a file"),
        (lambda value: value["parts"]["teeth_lower"].update(file="teeth\0.obj"), "parts.teeth_lower: expected a file"),
        (lambda value: value["parts"]["teeth_lower"].update(file="loop.obj"), "parts.teeth_lower: expected a file"),
        (
            lambda value: value["parts"]["teeth_lower"].update(file="far.obj"),
            "expected a part that fits the first mesh",
        ),
        (lambda value: value["parts"]["teeth_lower"].update(material="wood"), "a material (skin, eyes, teeth"),
        (lambda value: value.update(parts=["teeth.obj"]), "parts: expected dict, found list"),
    ],
)
def test_parts_that_do_not_fit_are_refused(refused, eggs, tmp_path, change, words):
    write_json(tmp_path / "annotation.json", json.loads((eggs.parent / "annotation.json").read_text()))
    egg = read_obj(eggs / "egg_00.obj")
    value = row_of_teeth(egg, tmp_path)
    teeth = read_obj(tmp_path / "teeth.obj")
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    write_obj(tmp_path / "far.obj", teeth.with_vertices(teeth.vertices + [0, 5, 0]))
    change(value)
    write_json(tmp_path / "annotation.json", value)
    line = refused("dataset", "import", eggs, tmp_path / "d", "--annotation", tmp_path / "annotation.json")
    assert words in line
    assert not (tmp_path / "d").exists()
