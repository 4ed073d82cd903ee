import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.methods.reconstruct.fit_landmarks_intrinsic import LandmarkChase
from caricli.template.feature_curves import feature_curves


def lines(face, template):
    ids = np.concatenate([curve.vertices for curve in feature_curves(template.annotation)])
    return face.camera.project(face.vertices[ids])


@pytest.mark.parametrize("count", [68, 81])
def test_a_chase_shows_what_a_whole_fit_shows(intrinsic, seen, strangers, count):
    points = seen(strangers[1], pitch=5, yaw=10, count=count).points
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    chase = LandmarkChase(intrinsic)
    chase.look(points)
    for _ in range(10):
        points = points.copy()
        points[[30, 31, 32, 33, 34, 35]] += 0.004 * diagonal
        points[8, 1] += 0.004 * diagonal
        face = chase.look(points)
    whole = fit_landmarks(points, intrinsic).face
    apart = np.linalg.norm(lines(face, intrinsic.template) - lines(whole, intrinsic.template), axis=1) / diagonal
    assert apart.mean() < 0.005
    assert face.landmarks.shape == (count, 2)
    assert np.linalg.norm(face.landmarks - points, axis=1).mean() < 0.006 * diagonal


def test_points_come_and_go_and_a_face_may_move_across_the_picture(intrinsic, seen, strangers):
    points = seen(strangers[0], count=81).points
    chase = LandmarkChase(intrinsic)
    first = chase.look(points)
    fewer = points.copy()
    fewer[60:] = np.nan
    assert np.isfinite(chase.look(fewer).landmarks).all()
    spreads = np.tile(np.eye(2), (81, 1, 1))
    for _ in range(3):
        there = chase.look(2 * points + 300, spreads)
    assert np.linalg.norm(there.landmarks - (2 * first.landmarks + 300), axis=1).mean() < 4
    with pytest.raises(InputError, match="expected at least 8 known landmarks"):
        chase.look(np.full((81, 2), np.nan))


def test_the_same_drag_gives_the_same_bytes(intrinsic, seen, strangers):
    points = seen(strangers[2], count=68).points
    faces = []
    for _ in range(2):
        chase = LandmarkChase(intrinsic)
        chase.look(points)
        faces.append(chase.look(points + 1))
    assert faces[0].vertices.tobytes() == faces[1].vertices.tobytes()
