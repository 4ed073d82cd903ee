import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.methods.expressions.optimise_blendshapes import (
    UNMOVED,
    WHOLE,
    cosines,
    displacement_masks,
    laplace_beltrami,
    masks,
    optimise_blendshapes,
    structure,
)
from caricli.methods.expressions.settings import BlendshapeWeights
from caricli.structures import Mesh

SIDE, SHAPES = 8, 5


@pytest.fixture(scope="module")
def problem():
    """A bumpy sheet, random displacements of a caricature, and of a normal face that does not move one of its rims."""
    generator = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), -1).reshape(-1, 2).astype(float)
    vertices = np.column_stack([grid, 0.3 * np.sin(grid[:, 0])]) + generator.normal(0, 0.05, (SIDE**2, 3))
    corners = (SIDE * np.arange(SIDE - 1)[:, None] + np.arange(SIDE - 1)).reshape(-1, 1)
    faces = np.concatenate([corners + [0, 1, SIDE], corners + [1, SIDE + 1, SIDE]])
    initial, normal = generator.normal(size=(2, SHAPES, SIDE**2, 3))
    normal[:, :SIDE] = 0
    return initial, normal, Mesh(vertices, faces)


def energy(candidate, initial, normal, mesh):
    """Equation 11 with the usual weights, pair by pair."""
    weights, (operator, area), cosine = BlendshapeWeights(), laplace_beltrami(mesh), cosines(normal)

    def squared(field):
        return (area[:, None] * field**2).sum()

    total = 0.0
    for i, shape in enumerate(candidate):
        total += weights.deformation * squared(operator @ (shape - masks(normal)[i][:, None] * initial[i]))
        total += weights.smoothness * squared(operator @ shape)
        for j, other in enumerate(candidate):
            gap = shape - np.sign(cosine[i, j]) * other
            total += weights.structure * abs(cosine[i, j]) * squared(gap)
    return total


@pytest.mark.parametrize("weights", [BlendshapeWeights(), BlendshapeWeights(1, 3, 0), BlendshapeWeights(2, 0, 0.5)])
def test_the_solution_is_that_of_the_dense_system(problem, weights):
    initial, normal, mesh = problem
    operator, area = laplace_beltrami(mesh)
    operator = operator.toarray()
    square = operator.T @ np.diag(area) @ operator
    free = np.flatnonzero(displacement_masks(normal).max(0) >= UNMOVED)
    whole = np.kron(np.eye(SHAPES), (weights.deformation + weights.smoothness) * square)
    whole += np.kron(2 * weights.structure * structure(normal), np.diag(area))
    right = np.concatenate([weights.deformation * square @ d for d in masks(normal)[..., None] * initial])
    chosen = np.concatenate([k * SIDE**2 + free for k in range(SHAPES)])
    expected = np.zeros((SHAPES * SIDE**2, 3))
    expected[chosen] = np.linalg.solve(whole[np.ix_(chosen, chosen)], right[chosen])
    found = optimise_blendshapes(initial, normal, mesh, weights)
    assert np.abs(found.reshape(-1, 3) - expected).max() < 1e-8 * np.abs(expected).max()
    assert not found[:, :SIDE].any()


def test_nothing_near_it_has_less_energy_and_the_gradient_vanishes(problem):
    initial, normal, mesh = problem
    found, generator = optimise_blendshapes(*problem), np.random.default_rng(1)
    free = (displacement_masks(normal).max(0) >= UNMOVED)[None, :, None]
    least = energy(found, *problem)
    for size in (1e-1, 1e-3):
        ways = [size * free * generator.normal(size=found.shape) for _ in range(10)]
        assert min(energy(found + way, *problem) for way in ways) > least
    way = free * generator.normal(size=found.shape)
    slope = (energy(found + 1e-4 * way, *problem) - energy(found - 1e-4 * way, *problem)) / 2e-4
    assert abs(slope) < 1e-6 * energy(0 * found, *problem)


def test_masks_and_cosines_are_those_of_the_paper(problem):
    normal = np.concatenate([problem[1], 0 * problem[1][:1], -problem[1][:1]])
    moved, found = displacement_masks(normal), cosines(normal)
    np.testing.assert_allclose(moved[:SHAPES].max(1), 1)
    assert not moved[SHAPES].any() and moved.min() >= 0
    kept = masks(normal)
    assert kept.max() == 1 and (kept >= moved).all() and (kept[moved == 0] == 0).all()
    far = np.linalg.norm(normal[0], axis=1).max()
    damped = masks(normal, np.where(np.arange(len(normal)) == 0, 8 * far, 0))
    np.testing.assert_allclose(damped[0], moved[0] / 8 / WHOLE)
    np.testing.assert_array_equal(damped[1:], kept[1:])
    np.testing.assert_allclose(np.diag(found), 1)
    assert found[0, -1] == pytest.approx(-1) and not found[SHAPES, :SHAPES].any()
    assert np.linalg.eigvalsh(structure(normal)).min() > -1e-12
    # Opposite expressions that are each other's reverse cost nothing, and neither do equal ones that are the same.
    pair = structure(normal[[0, -1]])
    assert np.array([1.0, -1]) @ pair @ [1, -1] == pytest.approx(0, abs=1e-12)


def test_without_structure_and_smoothness_the_masked_shapes_come_back(problem):
    initial, normal, mesh = problem
    everywhere = np.ones_like(normal)
    everywhere[:, 0] = 0
    initial = initial * masks(everywhere)[..., None]
    found = optimise_blendshapes(initial, everywhere, mesh, BlendshapeWeights(1, 0, 0))
    np.testing.assert_allclose(found, initial, atol=1e-7)


def test_size_place_and_order_of_shapes_do_not_matter(problem):
    initial, normal, mesh = problem
    found = optimise_blendshapes(*problem)
    larger = optimise_blendshapes(7 * initial, 7 * normal, mesh.with_vertices(7 * mesh.vertices + [1, 2, 3]))
    np.testing.assert_allclose(larger, 7 * found, atol=1e-8)
    back = optimise_blendshapes(initial[::-1], normal[::-1], mesh)[::-1]
    np.testing.assert_allclose(back, found, atol=1e-9)


def test_where_nothing_moves_there_is_nothing_to_optimise(problem):
    initial, normal, mesh = problem
    with pytest.raises(NumericsError, match="above 0"):
        optimise_blendshapes(initial, normal, mesh, BlendshapeWeights(0, 1, 1))
    with pytest.raises(NumericsError, match="found none"):
        optimise_blendshapes(initial, 0 * normal, mesh)
    flat = np.array(mesh.vertices)
    flat[mesh.faces[0]] = flat[mesh.faces[0, 0]]
    with pytest.raises(NumericsError):
        optimise_blendshapes(initial, normal, mesh.with_vertices(flat))


def test_what_moves_as_a_whole_hangs_on_the_rest(problem):
    initial, normal, mesh = problem
    rows = 3 * SIDE
    part = mesh.faces[(mesh.faces < rows).all(1)] + len(mesh.vertices)
    both = Mesh(np.concatenate([mesh.vertices, mesh.vertices[:rows] + 0.3]), np.concatenate([mesh.faces, part]))
    moves = [np.concatenate([m, np.full((SHAPES, rows, 3), 0.5)], axis=1) for m in (initial, normal)]
    found = optimise_blendshapes(*moves, both)
    assert found.shape == moves[0].shape and np.abs(found).max() < 10 * np.abs(moves[0]).max()
    with pytest.raises(NumericsError, match="vertices that no expression moves"):
        optimise_blendshapes(initial, normal + 10, mesh)
