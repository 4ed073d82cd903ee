from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.move_skull import lower_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.parts.close_neck import BELOW, neck_edge
from caricli.store.models import load_model


@pytest.mark.parametrize("coarse", [(6, 8), (5, 12)])
def test_bending_is_that_of_a_slow_computation(sitter, coarse):
    sphere = HeadSphere(sitter.head, ShellSettings(coarse=coarse))
    diagonals, areas = sphere.bending
    rows, columns = coarse
    count = rows * columns
    matrix = np.zeros((count, count))
    for offset, diagonal in enumerate(diagonals[::-1]):
        matrix += np.diag(diagonal[offset:], offset) + (np.diag(diagonal[offset:], -offset) if offset else 0)
    values = np.random.default_rng(3).normal(size=(rows, columns))
    step, turn = np.pi / rows, 2 * np.pi / columns
    bending = 0.0
    for row in range(rows):
        for column in range(columns):
            # Flow out of a cell: over each of its sides its length times the slope across it.
            flow = 0.0
            for beside in (-1, 1):
                slope = values[row, column] - values[row, (column + beside) % columns]
                flow += step * slope / (turn * np.sin(sphere.angles[row]))
                if 0 <= row + beside < rows:
                    between = (sphere.angles[row] + sphere.angles[row + beside]) / 2
                    flow += np.sin(between) * turn * (values[row, column] - values[row + beside, column]) / step
            bending += flow**2 / (np.sin(sphere.angles[row]) * step * turn)
    assert values.ravel() @ matrix @ values.ravel() == pytest.approx(bending)
    assert areas.sum() == pytest.approx(4 * np.pi, rel=0.05)


def test_points_are_so_far_above_the_skin_in_their_direction(sitter):
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    generator = np.random.default_rng(1)
    longitudes = generator.uniform(-np.pi, np.pi, 200)
    angles = generator.uniform(0.1, 2, 200)
    heights = generator.uniform(-0.02, 0.05, 200)
    points = sphere.points(longitudes, angles, sphere.ground(longitudes, angles) + heights)
    np.testing.assert_allclose(sphere.heights(points), heights, atol=1e-9)
    # On the grid it is the map itself.
    grid = np.meshgrid(sphere.longitudes, sphere.angles)
    np.testing.assert_allclose(sphere.ground(*grid), sphere.radii)


def test_a_head_whose_skull_has_moved_is_seen_as_if_anew(sitter):
    sphere = HeadSphere(sitter.head, ShellSettings())
    assert sphere.radii.any()
    most = np.where(sphere.region("scalp") > 0.5, 0.8 * sphere.radii, np.inf)
    lower = lower_skull(sitter.head, sphere, most)
    moved, anew = sphere.with_head(lower), HeadSphere(lower, ShellSettings())
    assert np.abs(anew.radii - sphere.radii).max() > 0.1 * sitter.head.height
    np.testing.assert_allclose(moved.radii, anew.radii, atol=1e-4 * sitter.head.height)
    np.testing.assert_allclose(moved.region("scalp"), anew.region("scalp"), atol=0.01)


def test_the_neck_goes_on_to_the_foot_that_a_head_stands_on(sitter):
    head = sitter.head
    sphere = HeadSphere(head, ShellSettings())
    rim = head.vertices[neck_edge(head)]
    middle = rim.mean(0)
    down = np.array([0, head.vertices[:, 1].min() - BELOW / 2 * head.height - middle[1], 0])
    beside = middle + [2 * np.ptp(rim[:, 0]), 0, 0]
    places = np.array([middle, middle + down, middle + 3 * down, beside, [middle[0], rim[:, 1].max() + 1.0, middle[2]]])
    assert sphere.in_neck(places).tolist() == [True, True, False, False, False]


def test_a_head_without_an_end_has_no_neck_below_it(sitter):
    head = sitter.head
    elsewhere = {name: ids for name, ids in head.annotation.regions.items() if name != "neck"}
    nameless = replace(head, annotation=replace(head.annotation, regions=elsewhere))
    assert not HeadSphere(nameless, ShellSettings()).in_neck(head.vertices - [0, 0.01, 0]).any()


@pytest.mark.parametrize("number", [32, 138, 188])
def test_a_chin_below_the_middle_hides_no_direction_at_an_ear(sitter, number):
    # Heads of which a triangle beside the lower pole was in front of the holes that ears leave.
    model = load_model()
    latent = 1.5 * np.random.default_rng(7).normal(size=(200, len(model.prior.mean)))[number]
    sphere = HeadSphere(sitter.head.with_vertices(model.decode(latent)), ShellSettings(), fine=True)
    longitudes, angles = (each.ravel() for each in np.meshgrid(sphere.longitudes, sphere.angles))
    roots, weights = sphere.roots(longitudes, angles)
    feet = np.einsum("nk,nkc->nc", weights, sphere.head.vertices[roots]) - sphere.middle
    cosines = (feet * sphere.directions(longitudes, angles)).sum(1) / np.linalg.norm(feet, axis=1)
    assert cosines[angles < np.radians(115)].min() > np.cos(np.radians(55))
