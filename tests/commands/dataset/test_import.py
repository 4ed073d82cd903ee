import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.io.obj import read_obj


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


def test_an_output_is_never_an_input(refused, eggs, annotation, tmp_path):
    before = sorted(path.name for path in eggs.iterdir())
    said = refused("dataset", "import", eggs, eggs, "--annotation", annotation, "--overwrite")
    assert "input" in said
    said = refused("dataset", "import", eggs, eggs.parent, "--annotation", annotation, "--overwrite")
    assert "input" in said
    assert sorted(path.name for path in eggs.iterdir()) == before
