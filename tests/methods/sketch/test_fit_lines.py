import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.sketch.fit_lines import FEWEST, fit_lines, line_camera
from caricli.methods.sketch.line_handles import lines_by_curve
from caricli.methods.sketch.settings import LineFitSettings


@pytest.fixture(scope="module")
def lines(sketch):
    return lines_by_curve(sketch)


def test_the_camera_of_a_known_shape_comes_back(lines, handles, person, camera):
    seen = line_camera(lines, handles, person[handles.vertices])
    assert abs(seen.scale / camera.scale - 1) < 0.01
    assert np.linalg.norm(seen.translation - camera.translation) < 2


def test_the_fit_is_nearer_than_the_mean(lines, handles, model, person, camera):
    """In pixels, because no line tells how large a head is."""
    face = fit_lines(lines, handles, model)
    mean = model.decode(model.prior.mean)

    def error(vertices, scale):
        there = [size * (each - each.mean(0)) for size, each in ((camera.scale, person), (scale, vertices))]
        return np.linalg.norm(there[0] - there[1], axis=1).mean()

    seen = face.require_camera()
    before = error(mean, line_camera(lines, handles, mean[handles.vertices]).scale)
    assert error(face.vertices, seen.scale) < 0.6 * before
    own = seen.project(face.vertices[handles.vertices])
    assert np.nanmean(np.linalg.norm(handles.places(lines, own) - own, axis=1)) < 0.01 * 256
    assert model.prior.rms(face.latent) < 2


def test_no_smaller_latent_is_likelier(lines, handles, model):
    """By what is minimised, with the places on the lines where they are found."""
    face = fit_lines(lines, handles, model)
    camera = face.require_camera()
    places = handles.places(lines, camera.project(face.vertices[handles.vertices]))
    met = np.isfinite(places).all(1)
    noise = LineFitSettings.noise * np.linalg.norm(np.ptp(places[met], axis=0))

    def energy(share):
        whitened = share * model.prior.whiten(face.latent)
        points = model.decode_points(model.prior.colour(whitened), handles.vertices[met])
        return ((camera.project(points) - places[met]) ** 2).sum() / noise**2 + (whitened**2).sum()

    assert min(energy(0.93), energy(1.07)) > energy(1)


def test_few_lines_are_refused(lines, handles, model):
    with pytest.raises(InputError, match="expected lines of the curves of a face, found none"):
        fit_lines({}, handles, model)
    with pytest.raises(InputError, match="found brow_left"):
        fit_lines({"brow_left": lines["brow_left"]}, handles, model)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-9])
def test_lines_that_are_all_in_one_place_are_refused(lines, handles, model, size):
    drawn = {name: [100 + size * (line - line[0]) for line in own] for name, own in lines.items()}
    with pytest.raises(InputError, match="expected lines"):
        fit_lines(drawn, handles, model)


def test_lines_that_the_curves_of_a_face_leave_on_the_way_are_refused(lines, handles, model, monkeypatch):
    met = handles.places
    calls = []

    def places(drawn, own):
        calls.append(own)
        there = met(drawn, own)
        there[FEWEST - 1 if len(calls) > 2 * LineFitSettings.first else len(there) :] = np.nan
        return there

    monkeypatch.setattr(handles, "places", places)
    with pytest.raises(InputError, match="expected lines of the curves of a face"):
        fit_lines(lines, handles, model)
