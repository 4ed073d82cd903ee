import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.interpolate_shapes import interpolate_shapes


def test_ends_are_the_shapes(ball, ball_gradients):
    first, second = ball[0], 1.3 * ball[0] + 0.2
    assert (interpolate_shapes(first, second, 0, ball_gradients) == first).all()
    assert (interpolate_shapes(first, second, 1, ball_gradients) == second).all()


def test_half_a_turn_is_a_turn_by_half_the_angle(ball, ball_gradients):
    vertices = ball[0]
    turn = Rotation.from_rotvec([0.3, -1.0, 0.4])
    half = interpolate_shapes(vertices, vertices @ turn.as_matrix().T, 0.5, ball_gradients)
    middle = vertices @ Rotation.from_rotvec(turn.as_rotvec() / 2).as_matrix().T
    assert half - half.mean(0) == pytest.approx(middle - middle.mean(0), abs=1e-6)


def test_never_flips_more_than_its_ends(people, head_template):
    gradients = head_template.gradients
    for first, second in zip(people[::4], people[1::4], strict=True):
        ends = max(flipped_triangles(shape, gradients).sum() for shape in (first, second))
        for weight in (0.25, 0.5, 0.75):
            between = interpolate_shapes(first, second, weight, gradients)
            assert flipped_triangles(between, gradients).sum() <= ends
            # Repairs stay small: the blend of the vertices is nowhere far away.
            assert np.abs(between - ((1 - weight) * first + weight * second)).max() < 0.02
