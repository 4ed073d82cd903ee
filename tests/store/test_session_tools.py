import pytest

from caricli.errors import InputError
from caricli.store.session_tools import check_alone


def test_an_obj_without_its_materials_is_refused_where_it_came_alone(tmp_path):
    path = tmp_path / "face.obj"
    path.write_text("mtllib worn.mtl\nv 0 0 0\n")
    with pytest.raises(InputError, match="^face.obj: expected its materials beside it, found none"):
        check_alone(path)
    (tmp_path / "worn.mtl").touch()
    check_alone(path)
    path.write_text("v 0 0 0\n")
    (tmp_path / "worn.mtl").unlink()
    check_alone(path)
    check_alone(tmp_path / "face.npz")
