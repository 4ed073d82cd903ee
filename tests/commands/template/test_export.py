import numpy as np
import pytest

from caricli.io.image import read_image
from caricli.io.meshes.obj import read_obj


@pytest.mark.parametrize("flags", [[], ["--open-mouth"]])
def test_the_head_is_written_with_quads_and_uvs(run, head, tmp_path, flags):
    out = tmp_path / "new" / "head.obj"
    result = run("template", "export", out, *flags)
    assert result.exit_code == 0 and result.stdout.startswith(f"{out}: 4200 vertices, 4178 polygons, ")
    mesh = read_obj(out)
    expected = head.open_mouth_template() if flags else head.template()
    np.testing.assert_allclose(mesh.vertices, expected.vertices, atol=1e-8)
    np.testing.assert_array_equal(mesh.polygons, head.polygons)
    np.testing.assert_array_equal(mesh.uv_polygons, expected.uv_polygons)
    np.testing.assert_allclose(mesh.uvs, expected.uvs, atol=1e-9)
    lips = expected.annotation.landmarks[[62, 66]]
    gap = np.subtract(*mesh.vertices[lips, 1])
    assert (gap > 0.003) == bool(flags)


def test_an_existing_file_is_kept_unless_told_otherwise(run, refused, tmp_path):
    out = tmp_path / "head.obj"
    out.write_text("mine")
    assert "--overwrite" in refused("template", "export", out)
    assert out.read_text() == "mine"
    assert run("template", "export", out, "--overwrite").exit_code == 0
    assert len(read_obj(out).vertices) == 4200
    assert "folder" in refused("template", "export", tmp_path, "--overwrite")
    assert [path.name for path in tmp_path.iterdir()] == ["head.obj"]


@pytest.mark.parametrize("name", ["head.txt", "head"])
def test_another_suffix_is_refused(refused, tmp_path, name):
    assert "expected a name that ends in .obj" in refused("template", "export", tmp_path / name, code=2)
    assert list(tmp_path.iterdir()) == []


def test_an_output_that_cannot_be_written_is_refused_before_the_head_is_made(refused, tmp_path, monkeypatch):
    def make():
        raise AssertionError("the head must not be made")

    monkeypatch.setattr("caricli.template.head.load_head", make)
    (tmp_path / "head.obj").symlink_to("head.obj")
    for more in ([], ["--overwrite"]):
        assert "not a regular file" in refused("template", "export", tmp_path / "head.obj", *more)
    assert (tmp_path / "head.obj").is_symlink()


def test_a_sheet_of_the_layout_is_drawn(run, refused, tmp_path):
    mesh = tmp_path / "head.obj"
    sheet = tmp_path / "sheet.png"
    result = run("template", "export", mesh, "--uv-sheet", sheet, "--size", 256)
    assert result.exit_code == 0 and read_image(sheet).shape == (256, 256, 3) and mesh.is_file()
    assert "--overwrite" in refused("template", "export", tmp_path / "other.obj", "--uv-sheet", sheet)
    assert not (tmp_path / "other.obj").exists()
