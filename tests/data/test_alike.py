import shutil

import numpy as np
import pytest

from caricli.data.alike import check_alike, check_own
from caricli.data.dataset import read_dataset
from caricli.data.import_dataset import ImportSettings, import_dataset
from caricli.errors import InputError
from caricli.io.meshes.obj import read_obj, write_obj


@pytest.fixture
def refused(barrels, tmp_path):
    """What is said when some of the barrels are changed and imported; of their vertices function makes the others."""

    def said(numbers, function, unit=None):
        for number in numbers:
            path = barrels[0] / f"scan_{number:02d}.obj"
            mesh = read_obj(path)
            write_obj(path, mesh.with_vertices(function(mesh.vertices)))
        (tmp_path / "out").mkdir()
        with pytest.raises(InputError) as caught:
            import_dataset(barrels[0], tmp_path / "out", barrels[2], settings=ImportSettings(unit))
        assert not any((tmp_path / "out").iterdir())
        return str(caught.value)

    return said


@pytest.mark.parametrize("unit", [None, "m"])
def test_a_mesh_in_another_unit_is_refused(refused, unit):
    line = refused([4], lambda vertices: 1000 * vertices, unit)
    assert "scan_04.obj: expected a height of 0.0" in line and "(1 such of 12)" in line


def test_files_half_of_which_are_in_another_unit_are_refused(refused):
    line = refused(range(6, 12), lambda vertices: 10 * vertices)
    assert "in the unit of the others, found 0.2" in line and "(6 such of 12)" in line


def test_a_mesh_that_stands_elsewhere_is_refused(refused):
    line = refused([2, 7], lambda vertices: vertices + [0, 0.5, 0])
    assert "scan_02.obj: expected a head within 0.1" in line and "it 0.5 away (2 such of 12)" in line


@pytest.mark.parametrize("number", [0, 5])
def test_a_mesh_that_lies_is_refused(refused, number):
    line = refused([number], lambda vertices: vertices @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]))
    assert f"scan_{number:02d}.obj: expected a head turned as the others" in line and "(1 such of 12)" in line
    assert 80 < float(line.split("turned by ")[1].split()[0]) < 100


def test_caricatures_of_every_kind_are_alike(built, grid, own_built):
    for folder, *_ in (built, grid, own_built):
        data = read_dataset(folder)
        files = [folder / f"{row}.obj" for row in range(len(data.vertices))]
        check_alike(files, data.vertices)
        check_own(files, data.vertices, [str(person) for person in data.identity])


def test_two_people_of_one_mesh_are_refused(barrels, tmp_path):
    folder, _, annotation = barrels
    again = read_obj(folder / "scan_03.obj")
    write_obj(folder / "scan_12.obj", again.with_vertices(again.vertices + [0, 0.01, 0]))
    (tmp_path / "out").mkdir()
    with pytest.raises(InputError, match="scan_12.obj: expected a mesh of scan_12's own, found that of scan_03.obj"):
        import_dataset(folder, tmp_path / "out", annotation)


def test_somebody_may_have_a_mesh_twice(barrels, tmp_path):
    folder, _, annotation = barrels
    shutil.copy(folder / "scan_03.obj", folder / "scan_03__smile.obj")
    (tmp_path / "out").mkdir()
    assert import_dataset(folder, tmp_path / "out", annotation).people == 12


def test_others_who_measure_the_same_are_others(barrel, tmp_path):
    """Averages over all vertices say little of how these lie among each other."""
    shape = barrel.template.vertices
    check_own([tmp_path / "a.obj", tmp_path / "b.obj"], np.stack([shape, shape[::-1]]), ["a", "b"])
