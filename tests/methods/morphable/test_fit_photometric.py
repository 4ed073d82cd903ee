from copy import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from caricli.errors import InputError
from caricli.methods.morphable.fit_photometric import fit_photometric
from caricli.methods.morphable.photometric_search import skin_patch
from caricli.methods.morphable.renderer import MorphableRenderer
from caricli.methods.morphable.settings import PhotometricSettings
from caricli.methods.morphable.wear_colours import wear_colours
from caricli.methods.reconstruct.fit_morphable import fit_morphable
from caricli.store.models import load_morphable
from caricli.structures import Face, Landmarks
from caricli.structures.detection import FacePicture
from caricli.structures.parsing import Region
from caricli.template.annotation import CAVITIES
from caricli.template.chart import NOSTRILS

SIDE = 200


@pytest.fixture(scope="module")
def model():
    return load_morphable()


@pytest.fixture(scope="module")
def scene(model):
    """(coefficients, picture, landmarks that are off by 1 % of their diagonal) of a face of the model."""
    renderer = MorphableRenderer(model)
    generator = np.random.default_rng(8)
    x = np.zeros(renderer.layout.size)
    x[: renderer.layout.face] = 0.7 * generator.normal(size=renderer.layout.face)
    parts = renderer.layout.parts(x)
    parts["light"][:] = [2.4, 0.8, -0.5, -1.2, 0.1, 0.0, 0.1, 0.0, 0.0]
    parts["pose"][:] = [0.05, 0.25, 0.05, 100, 95, 620]
    posed = renderer.pose(torch.as_tensor(x, dtype=torch.float32)[None])
    sight = renderer.look(posed, SIDE, SIDE)
    picture = np.full((SIDE, SIDE, 3), 90, np.uint8)
    colours = renderer.paint(posed, sight).numpy()
    picture[sight.row.numpy(), sight.column.numpy()] = np.round(255 * np.clip(colours, 0, 1))
    points = renderer.landmarks(posed, renderer.anchors(posed, 68))[0].numpy().astype(float)
    points += 0.01 * np.linalg.norm(np.ptp(points, axis=0)) * generator.normal(size=points.shape)
    return x, picture, points


def picture_of(points, image, regions=None):
    return FacePicture(Landmarks(points, (SIDE, SIDE)), image, regions=regions)


@pytest.fixture(scope="module")
def fit(model, scene):
    return fit_photometric(picture_of(scene[2], scene[1]), model)


def error(model, scene, latent):
    face = model.template.region("face")
    truth = model.decode(scene[0][: len(latent)])
    shift = (model.decode(latent) - truth)[face]
    return np.linalg.norm(shift - shift.mean(0), axis=1).mean()


def test_colours_tell_more_of_the_shape_than_landmarks_alone(model, scene, fit, monkeypatch):
    marks = error(model, scene, fit_morphable(scene[2], model).face.latent)
    usual = error(model, scene, fit.face.latent)
    assert usual < marks and fit.after < 0.5 * fit.before and fit.nme < 2
    # The picture is exact, which no picture is: here it may be trusted a hundred times as much.
    trusting = replace(PhotometricSettings(), photometric=100 * PhotometricSettings().photometric)
    monkeypatch.setattr("caricli.methods.morphable.fit_photometric._SETTINGS", trusting)
    exact = fit_photometric(picture_of(scene[2], scene[1]), model)
    assert error(model, scene, exact.face.latent) < 0.9 * usual and exact.after < fit.after


def test_it_is_one_face_with_one_camera(model, scene, fit):
    np.testing.assert_allclose(model.decode(fit.face.latent), fit.face.vertices, atol=1e-9)
    camera = fit.face.camera
    np.testing.assert_allclose(camera.project(fit.face.vertices.mean(0)), fit.coefficients["pose"][3:5], atol=1e-6)
    assert camera.scale == fit.coefficients["pose"][5] == pytest.approx(620, rel=0.05)
    projected = camera.project(fit.face.vertices[fit.anchors])
    np.testing.assert_allclose(projected, fit.face.landmarks, atol=1e-9)
    assert fit.figures()["photometric"]["after"] == fit.after
    assert fit.face.pictures.skin.shape == (512, 512, 3)
    assert fit.figures()["iterations"] == 10


def test_what_does_not_show_skin_does_not_count(model, scene, fit):
    _, picture, points = scene
    masked = picture.copy()
    masked[: SIDE // 2] = [255, 0, 255]
    regions = np.full(picture.shape[:2], Region.SKIN, np.uint8)
    regions[: SIDE // 2] = Region.HAT
    seen = fit_photometric(picture_of(points, masked, regions), model)
    assert seen.after < 1.5 * fit.after
    with pytest.raises(InputError, match="skin"):
        fit_photometric(picture_of(points, picture, np.zeros_like(regions)), model)


def test_where_no_region_is_the_face_all_of_the_head_may_show_skin(model):
    plain = copy(model)
    template = model.template
    regions = {name: ids for name, ids in template.annotation.regions.items() if name != "face"}
    plain.template = replace(template, annotation=replace(template.annotation, regions=regions))
    _, vertex, triangle = skin_patch(plain)
    holes = template.mask(*CAVITIES, *NOSTRILS)[template.faces].any(1)
    assert (vertex >= 0).all() and holes.any()
    np.testing.assert_array_equal(triangle.numpy() >= 0, ~holes)


def test_an_identity_that_is_given_stays(model, scene):
    given = scene[0][: len(model.identity)]
    fit = fit_photometric(picture_of(scene[2], scene[1]), model, identity=given)
    np.testing.assert_array_equal(model.parts(fit.face.latent)[0], given)


def test_it_asks_for_a_picture(model, scene):
    with pytest.raises(InputError, match="picture"):
        fit_photometric(picture_of(scene[2], None), model)


def test_worn_colours_are_those_of_the_vertices(model):
    colours = np.zeros_like(model.mean)
    colours[:, 0] = 1
    colours[model.template.region("face")] = [0, 0, 1]
    face = wear_colours(Face(model.template), model.template, colours)
    counts = {tuple(c) for c in face.pictures.skin.reshape(-1, 3)}
    assert {(255, 0, 0), (0, 0, 255)} <= counts
    # What closes the neck goes on from its edge.
    assert (face.pictures.bust == [255, 0, 0]).all()
