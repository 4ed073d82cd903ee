import pytest

from caricli.errors import InputError
from caricli.store.session_tools import SessionTools, lacks_materials, load_start


def test_what_is_named_as_a_picture_and_is_none_is_refused_as_a_picture(tmp_path):
    path = tmp_path / "b.png"
    path.write_text("no picture")
    with pytest.raises(InputError, match="b.png: expected a PNG, JPEG, .* image, found"):
        load_start(path, SessionTools())


def test_an_obj_lacks_the_materials_that_it_names_and_that_are_not_beside_it(tmp_path):
    path = tmp_path / "face.obj"
    path.write_text("mtllib worn.mtl\nv 0 0 0\n")
    assert lacks_materials(path)
    (tmp_path / "worn.mtl").touch()
    assert not lacks_materials(path)
    path.write_text("v 0 0 0\n")
    (tmp_path / "worn.mtl").unlink()
    assert not lacks_materials(path) and not lacks_materials(tmp_path / "face.npz")
