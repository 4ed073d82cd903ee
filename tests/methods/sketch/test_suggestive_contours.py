"""Lines on surfaces that are known in closed form, against a slow computation that shares nothing with the fast one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.sketch.suggestive_contours import ContourFinder, ContourSettings
from caricli.structures import Camera
from tests.methods.sketch.surfaces import Surface, bump, ellipsoid, torus

SETTINGS = ContourSettings(levels=0, smoothing=0, steep=8.0, keep=8.0, facing=10.0, shortest=0.02, lift=0.01)


def camera(yaw, pitch):
    return Camera(100.0, head_rotation(np.radians([pitch, yaw, 0.0])), np.zeros(2))


def drawn(surface: Surface, pose: Camera, settings: ContourSettings = SETTINGS) -> tuple[np.ndarray, np.ndarray]:
    """Points of suggestive contours and of contours."""
    finder = ContourFinder(surface.mesh, np.ones(len(surface.mesh.vertices), bool), settings)
    lines = finder.lines(surface.mesh.vertices, pose)
    suggestive = [line.points for line in lines if np.isfinite(line.strength)]
    contours = [line.points for line in lines if np.isinf(line.strength)]
    nothing = np.zeros((0, 3))
    return np.concatenate([*suggestive, nothing]), np.concatenate([*contours, nothing])


def edge_length(surface: Surface) -> float:
    corners = surface.mesh.vertices[surface.mesh.faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())


def lines_by_hand(surface: Surface, view: np.ndarray, steep: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the mesh, moved onto the suggestive contour next to them where they lie near one, that pass every
    threshold by a margin; and whether each is seen."""
    points = surface.onto(surface.mesh.vertices)
    way = surface.along(points, view)
    slope = surface.derivative(points, view, way)
    distance = surface.radial(points, view) / np.where(np.abs(slope) > 1e-3, slope, np.nan)
    near = np.abs(distance) < edge_length(surface)
    points = points[near]
    for _ in range(4):
        way = surface.along(points, view)
        slope = surface.derivative(points, view, way)
        points = surface.onto(points - (surface.radial(points, view) / slope)[:, None] * way)
    height = np.ptp(surface.mesh.vertices[:, 1])
    slope = surface.derivative(points, view, surface.along(points, view)) * height**2
    facing = surface.normals(points) @ view
    # Straight from the side, a step along the surface and a step in the picture have nothing to do with each other.
    good = (slope > 1.2 * steep) & (facing > 0.12) & (facing < np.cos(np.radians(SETTINGS.facing + 3)))
    return points[good], surface.is_seen(points[good], view, SETTINGS.lift * height)


# A torus that lies is low, and steepness is counted in its height.
SEEN = [
    (torus(), (0, 25), 0.5),
    (torus(), (0, 35), 0.5),
    (bump(), (0, 40), 8.0),
    (bump(), (35, 40), 8.0),
    (bump(), (0, 60), 8.0),
]


@pytest.mark.parametrize(
    ("surface", "turn", "steep"), SEEN, ids=["torus-25", "torus-35", "bump-40", "bump-35", "bump-60"]
)
def test_lines_are_those_of_the_slow_computation(surface, turn, steep):
    pose = camera(*turn)
    view = -pose.rotation[2]
    ours, _ = drawn(surface, pose, replace(SETTINGS, steep=steep, keep=steep))
    edge = edge_length(surface)
    assert len(ours) > 20
    # Every drawn point lies on a zero of the radial curvature, where it rises towards the viewer.
    exact = surface.onto(ours)
    slope = surface.derivative(exact, view, surface.along(exact, view))
    assert np.percentile(np.abs(surface.radial(exact, view) / slope), 98) < 0.5 * edge
    assert (slope * np.ptp(surface.mesh.vertices[:, 1]) ** 2 > 0.7 * steep).mean() > 0.98
    assert surface.is_seen(exact, view, SETTINGS.lift * np.ptp(surface.mesh.vertices[:, 1])).mean() > 0.97
    # Every point that passes by the slow computation is drawn.
    theirs, seen = lines_by_hand(surface, view, steep)
    assert seen.sum() > 20
    assert (KDTree(ours).query(theirs)[0][seen] < 2 * edge).mean() > 0.97


@pytest.mark.parametrize("pitch", [10, 20])
def test_hidden_lines_are_left_out(pitch):
    surface = torus()
    pose = camera(0, pitch)
    view = -pose.rotation[2]
    _, ours = drawn(surface, pose)
    edge = edge_length(surface)
    # Contours by hand: for every turn around the axis, the angle around the tube where normal and view are at right
    # angles, n = (cos b sin a, sin b, cos b cos a).
    around = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    flat = np.sin(around) * view[0] + np.cos(around) * view[2]
    both = [np.arctan2(-flat, view[1]) + shift for shift in (0, np.pi)]
    points = np.concatenate(
        [
            np.stack(
                [(1 + 0.4 * np.cos(b)) * np.sin(around), 0.4 * np.sin(b), (1 + 0.4 * np.cos(b)) * np.cos(around)], 1
            )
            for b in both
        ]
    )
    assert np.abs(surface.normals(points) @ view).max() < 1e-9
    seen = surface.is_seen(points, view, SETTINGS.lift * np.ptp(surface.mesh.vertices[:, 1]))
    away = KDTree(ours).query(points)[0]
    assert seen.sum() > 100 and (~seen).sum() > 50
    assert (away[seen] < edge).mean() > 0.97 and (away[~seen] > edge).mean() > 0.9


def test_an_ellipsoid_has_contours_alone():
    surface = ellipsoid()
    pose = camera(30, 20)
    ours, contours = drawn(surface, pose)
    assert len(ours) == 0 and len(contours) > 100
    # In closed form it is the plane of points whose normal is at right angles to the view.
    weights = surface.gradient(-pose.rotation[2][None])[0]
    assert np.abs(contours @ weights / np.linalg.norm(weights)).max() < 0.5 * edge_length(surface)


def test_thresholds_take_lines_away():
    surface = torus()
    pose = camera(0, 25)
    counts = [len(drawn(surface, pose, replace(SETTINGS, steep=steep, keep=steep))[0]) for steep in (0.1, 0.5, 2, 1e5)]
    assert counts == sorted(counts, reverse=True) and counts[0] > counts[-1] == 0


def test_lines_do_not_depend_on_where_the_mesh_stands():
    surface = torus(counts=(80, 40))
    pose = camera(0, 25)
    moved = Camera(37.0, pose.rotation, np.array([5.0, -9.0]))
    finder = ContourFinder(surface.mesh, np.ones(len(surface.mesh.vertices), bool), SETTINGS)
    first = finder.lines(surface.mesh.vertices, pose)
    second = finder.lines(0.3 * surface.mesh.vertices, moved)
    assert len(first) == len(second) > 0
    for line, other in zip(first, second, strict=True):
        assert np.allclose(0.3 * line.points, other.points, atol=1e-9)


def test_lines_stay_in_their_region():
    surface = torus()
    region = surface.mesh.vertices[:, 0] > 0
    lines = ContourFinder(surface.mesh, region, SETTINGS).lines(surface.mesh.vertices, camera(0, 25))
    assert lines and all((line.points[:, 0] > 0).all() for line in lines)
    assert (
        ContourFinder(surface.mesh, np.zeros(len(region), bool), SETTINGS).lines(surface.mesh.vertices, camera(0, 25))
        == []
    )
