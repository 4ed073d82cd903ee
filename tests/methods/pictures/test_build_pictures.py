import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.pictures.build_pictures import PictureSettings, PictureSource, Task, drawing_tasks
from caricli.methods.pictures.pose import Pose
from caricli.methods.pictures.settings import SceneSettings
from caricli.store.models import load_model
from tests.posed_pictures import small_dataset


@pytest.fixture(scope="module")
def model():
    return load_model(kind="morphable")


@pytest.fixture(scope="module")
def source(head_template, model):
    return PictureSource(head_template, model, 64, 3)


@pytest.fixture(scope="module")
def task(people):
    return Task(5, np.array([7, 2]), people[[7, 2]].astype(np.float32), 12)


@pytest.fixture(scope="module")
def drawn(source, task):
    source.easel.scene = SceneSettings(none=0, several=0.5, held=0)
    return source.draw(task)


def test_people_take_turns_and_rows_are_those_of_the_dataset(drawn):
    assert len(drawn) == 12
    alone = [(number, picture.faces[0]["row"]) for number, picture in enumerate(drawn) if len(picture.faces) == 1]
    together = [sorted(face["row"] for face in picture.faces) for picture in drawn if len(picture.faces) > 1]
    assert {number % 2 for number, _ in alone} == {0, 1} and together
    assert all(row == (7, 2)[number % 2] for number, row in alone)
    assert all(rows == [2, 7] for rows in together)


def test_coefficients_say_who_it_is_how_it_is_lit_and_where_it_stands(drawn, model):
    count = len(model.prior.mean) + len(model.albedo.basis)
    for face in (face for picture in drawn for face in picture.faces):
        code, light, pose = np.split(face["coefficients"], [count, count + 9])
        np.testing.assert_allclose(light, face["light"].mean(1))
        np.testing.assert_allclose(head_rotation(pose[:3]), face["rotation"], atol=1e-9)
        np.testing.assert_allclose(pose[3:], [*face["translation"], face["scale"]])
        # The face of the coefficients, before its camera, has its landmarks where the picture has them.
        vertices = model.decode(code[: len(model.prior.mean)])
        height = np.ptp(vertices[:, 1])
        scale, translation = face["scale"], face["translation"]
        stand = Pose(face["rotation"], scale, translation, face["perspective"], vertices.mean(0), height)
        marks = model.template.annotation.landmarks[17:68]
        apart = np.linalg.norm(stand.place(vertices[marks])[:, :2] - face["landmarks"][17:68], axis=1)
        assert np.median(apart) < 0.05 * height * scale


def test_colours_of_the_coefficients_are_the_nearest_to_those_of_the_sitter(source, task, model):
    sitter = source.wardrobe.seat(task.vertices[0].astype(float), np.random.default_rng(0))
    code = source._code(sitter)[len(model.prior.mean) :]
    basis = model.albedo.basis.reshape(len(code), -1)
    expected = np.linalg.lstsq(basis.T, (sitter.albedo - model.albedo.mean).ravel(), rcond=None)[0]
    np.testing.assert_allclose(code, expected, atol=0.05 * np.abs(expected).max())


def test_every_unit_draws_its_own_pictures_and_the_same_again(source, task, drawn, monkeypatch):
    again = source.draw(Task(task.number, task.rows, task.vertices, 1))[0]
    assert again.image == drawn[0].image and again.labels == drawn[0].labels
    # Of the same people, too.
    alike = [source.wardrobe.seat(shape, np.random.default_rng(0)) for shape in task.vertices.astype(float)]
    monkeypatch.setattr(source.wardrobe, "seat", lambda vertices, generator: alike[0])
    first, other = (source.draw(Task(number, task.rows, task.vertices, 1))[0] for number in (5, 6))
    assert first.image != other.image


@pytest.mark.parametrize("count", [1, 24, 100, 500])
def test_units_are_of_one_split_and_as_many_pictures_as_asked_for(head_template, people, count):
    dataset = small_dataset(head_template, people[:9])
    tasks = list(drawing_tasks(dataset, PictureSettings(count)))
    assert sum(task.count for task in tasks) == count and max(task.count for task in tasks) <= 24
    assert [task.number for task in tasks] == list(range(len(tasks)))
    splits = [set(rows) for rows in dataset.manifest["splits"].values()]
    for task in tasks:
        assert 0 < len(task.rows) <= 3 and any(set(task.rows.tolist()) <= split for split in splits)
        np.testing.assert_array_equal(task.vertices, dataset.vertices[task.rows])
    if count == 500:
        assert set(np.concatenate([task.rows for task in tasks]).tolist()) == set(range(9))
