from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.geometry.deformation.smooth_displacement import least_areas
from caricli.methods.edit.map_landmarks import map_landmarks
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.stylise.exaggerate_portrait import ShapeTools, exaggerate_portrait
from caricli.methods.stylise.mesh_warp import mesh_warp
from caricli.methods.stylise.settings import StyliseSettings, WarpSettings
from caricli.methods.stylise.stylise_portrait import stylise_portrait
from caricli.store.directions import load_directions
from caricli.store.landmark_maps import load_landmark_map
from caricli.structures import Landmarks

SIZE = (620, 900)
BARE = StyliseSettings(style="none")


@pytest.fixture(scope="module")
def tools(intrinsic):
    intrinsic.prepare()
    return ShapeTools(intrinsic, load_landmark_map(), load_directions(intrinsic))


@pytest.fixture(scope="module")
def portrait(seen, people):
    """A picture in which every place has a colour of its own, and the landmarks of a face in it."""
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    image = np.dstack([columns * 255 // SIZE[0], rows * 255 // SIZE[1], (columns + rows) % 256]).astype(np.uint8)
    return image, Landmarks(seen(people[3], yaw=12).points, SIZE)


@pytest.mark.parametrize("shape", ["map", "direction", "own"])
def test_faces_go_further_with_more_strength_and_fold_nowhere(portrait, tools, shape):
    image, marks = portrait
    fit = fit_landmarks(marks.points, tools.model)
    before = fit.face.landmarks
    moved = []
    for strength in (0.5, 1.0, 3.0):
        vertices = exaggerate_portrait(fit, tools, shape, strength)
        warp = mesh_warp(fit.face, vertices, tools.model.template, SIZE, WarpSettings())
        # Areas between neighbouring pixels, not only between the nodes that were solved for.
        assert least_areas(warp.moves).min() > 0.1
        moved.append(np.linalg.norm(warp.points(before) - before, axis=1).mean())
        # The surface pulls the picture along: where its landmarks go, pixels go.
        wanted = fit.face.camera.project(vertices[fit.anchors]) - before
        if strength == 1:
            missed = np.linalg.norm(warp.points(before) - before - wanted, axis=1).mean()
            assert missed < 0.6 * np.linalg.norm(wanted, axis=1).mean()
    assert 0 < moved[0] < moved[1] < moved[2]


def test_landmarks_come_nearer_to_those_of_the_map(portrait, tools):
    image, marks = portrait
    result = stylise_portrait(image, marks, tools, BARE)
    style = tools.landmark_map.own_style(marks.points[:68])
    wanted = map_landmarks(marks.points, tools.landmark_map, "caricature", style)
    before, after = (
        np.linalg.norm(points - wanted, axis=1).mean() for points in (marks.points, result.landmarks.points)
    )
    assert after < 0.7 * before
    assert result.picture is result.warped and (result.picture != image).any()
    assert 0.5 < result.moved < 10


def test_a_wrong_landmark_pulls_less_where_it_is_unsure(portrait, tools):
    image, marks = portrait
    points, tip = np.array(marks.points), 30
    points[tip] += 20, 0
    spreads = np.tile(4 * np.eye(2), (len(points), 1, 1))
    doubted = np.array(spreads)
    doubted[tip] *= 100**2
    right, sure, unsure = (
        stylise_portrait(image, replace(marks, points=places, spreads=doubt), tools, BARE).landmarks.points
        for places, doubt in ((marks.points, spreads), (points, spreads), (points, doubted))
    )
    others = np.delete(np.arange(len(points)), tip)
    missed, harm = (np.linalg.norm((moved - right)[others], axis=1).mean() for moved in (unsure, sure))
    assert missed < 0.5 * harm


def test_where_nothing_moves_the_picture_stays(portrait, tools):
    image, marks = portrait
    fit = fit_landmarks(marks.points, tools.model)
    warp = mesh_warp(fit.face, fit.face.vertices, tools.model.template, SIZE, WarpSettings())
    np.testing.assert_allclose(warp.moves, 0, atol=1e-3)
    for settings in (replace(BARE, strength=0.0), replace(BARE, shape="none")):
        result = stylise_portrait(image, marks, tools, settings)
        assert result.picture is image and result.moved == 0
        np.testing.assert_array_equal(result.landmarks.points, marks.points)
    assert stylise_portrait(image, marks, None, BARE).picture is image


def test_a_face_that_is_moved_takes_its_surroundings_along_and_the_borders_stay(portrait, tools):
    """The mesh shifted as a whole: its pixels follow, what is far away does not, and between nothing tears."""
    image, marks = portrait
    fit = fit_landmarks(marks.points, tools.model)
    shift = fit.face.camera.rotation.T @ [20 / fit.face.camera.scale, 0, 0]
    warp = mesh_warp(fit.face, fit.face.vertices + shift, tools.model.template, SIZE, WarpSettings())
    np.testing.assert_allclose(warp.points(marks.points[27:60]) - marks.points[27:60], [[20, 0]] * 33, atol=1.0)
    warped = warp.picture(image)
    np.testing.assert_array_equal(warped[:, [0, -1], 0], image[:, [0, -1], 0])
    assert np.abs(np.diff(warped[..., 0].astype(int), axis=1)).max() <= 3, "no seam"


def test_unknown_landmarks_stay_unknown(portrait, tools):
    image, marks = portrait
    points = marks.points.copy()
    points[[3, 50]] = np.nan
    result = stylise_portrait(image, Landmarks(points, SIZE), tools, BARE)
    assert (~result.landmarks.known).nonzero()[0].tolist() == [3, 50]


def test_a_generator_paints_in_place_of_a_style(portrait):
    image, marks = portrait
    result = stylise_portrait(image, marks, None, StyliseSettings(shape="none"), lambda picture: 255 - picture)
    np.testing.assert_array_equal(result.picture, 255 - image)


def test_a_shape_whose_map_is_missing_is_refused(portrait, tools):
    with pytest.raises(InputError, match="expected a landmark map"):
        stylise_portrait(portrait[0], portrait[1], ShapeTools(tools.model), BARE)
