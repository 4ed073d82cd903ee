import numpy as np
import pytest

from caricli.errors import NumericsError
from caricli.methods.expressions.optimise_blendshapes import (
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


def dense_operator(mesh):
    """Cotangent Laplacian (V, V) over Voronoi areas (V,), triangle by triangle, in units of the mesh's height."""
    vertices = mesh.vertices / np.ptp(mesh.vertices[:, 1])
    stiffness, area = np.zeros((len(vertices), len(vertices))), np.zeros(len(vertices))
    for face in mesh.faces:
        twice = np.linalg.norm(np.cross(vertices[face[1]] - vertices[face[0]], vertices[face[2]] - vertices[face[0]]))
        edges = [vertices[face[(k + 2) % 3]] - vertices[face[(k + 1) % 3]] for k in range(3)]  # opposite of corners
        cotangents = [-edges[(k + 1) % 3] @ edges[(k + 2) % 3] / twice for k in range(3)]
        for k in range(3):
            first, second = (k + 1) % 3, (k + 2) % 3
            for i, j in ((face[first], face[second]), (face[second], face[first])):
                stiffness[i, j] -= cotangents[k] / 2
                stiffness[i, i] += cotangents[k] / 2
            if min(cotangents) < 0:
                area[face[k]] += twice / (4 if cotangents[k] < 0 else 8)
            else:
                squares = edges[first] @ edges[first], edges[second] @ edges[second]
                area[face[k]] += (squares[0] * cotangents[first] + squares[1] * cotangents[second]) / 8
    return stiffness / area[:, None], area


def paper_masks(normal):
    """Equation 6, vertex by vertex."""
    lengths = [[sum(x * x for x in vertex) ** 0.5 for vertex in shape] for shape in normal]
    return np.array([[length / max(row) for length in row] for row in lengths])


def own_masks(normal):
    """What takes the place of equation 6: four times as much, and nowhere more than 1."""
    return np.minimum(1, 4 * paper_masks(normal))


def paper_cosines(normal):
    """Equation 8, pair by pair."""
    return np.array(
        [[(a * b).sum() / ((a * a).sum() * (b * b).sum()) ** 0.5 for b in normal] for a in normal],
    )


def energy(candidate, initial, normal, mesh):
    """Equation 11 with our masks, weights and signs, pair by pair, by nothing that the module computes."""
    (operator, area), cosine = dense_operator(mesh), paper_cosines(normal)

    def squared(field):
        return (area[:, None] * field**2).sum()

    total = 0.0
    for i, shape in enumerate(candidate):
        total += 1.0 * squared(operator @ (shape - own_masks(normal)[i][:, None] * initial[i]))
        total += 0.05 * squared(operator @ shape)
        for j, other in enumerate(candidate):
            total += 0.1 * abs(cosine[i, j]) * squared(shape - np.sign(cosine[i, j]) * other)
    return total


def free_vertices(normal):
    """(V,) bool: moved by some expression by a twentieth of its farthest way or more."""
    return paper_masks(normal).max(0) >= 0.05


def test_the_operator_is_the_cotangent_laplacian_over_voronoi_areas(problem):
    mesh = problem[2]
    operator, area = laplace_beltrami(mesh)
    expected, areas = dense_operator(mesh)
    assert (np.abs(expected @ np.ones(len(areas))) < 1e-9 * np.abs(expected).max()).all()
    np.testing.assert_allclose(area, areas, rtol=1e-9)
    np.testing.assert_allclose(operator.toarray(), expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("weights", [BlendshapeWeights(), BlendshapeWeights(1, 3, 0), BlendshapeWeights(2, 0, 0.5)])
def test_the_solution_is_that_of_the_dense_system(problem, weights):
    initial, normal, mesh = problem
    operator, area = dense_operator(mesh)
    square = operator.T @ np.diag(area) @ operator
    free, cosine = np.flatnonzero(free_vertices(normal)), paper_cosines(normal)
    whole = np.kron(np.eye(SHAPES), (weights.deformation + weights.smoothness) * square)
    whole += np.kron(2 * weights.structure * (np.diag(np.abs(cosine).sum(1)) - cosine), np.diag(area))
    right = np.concatenate([weights.deformation * square @ d for d in own_masks(normal)[..., None] * initial])
    chosen = np.concatenate([k * SIDE**2 + free for k in range(SHAPES)])
    expected = np.zeros((SHAPES * SIDE**2, 3))
    expected[chosen] = np.linalg.solve(whole[np.ix_(chosen, chosen)], right[chosen])
    found = optimise_blendshapes(initial, normal, mesh, weights)
    assert np.abs(found.reshape(-1, 3) - expected).max() < 1e-8 * np.abs(expected).max()
    assert not found[:, :SIDE].any()


def test_nothing_near_it_has_less_energy_and_the_gradient_vanishes(problem):
    initial, normal, mesh = problem
    found, generator = optimise_blendshapes(*problem), np.random.default_rng(1)
    free = free_vertices(normal)[None, :, None]
    least = energy(found, *problem)
    for size in (1e-1, 1e-3):
        ways = [size * free * generator.normal(size=found.shape) for _ in range(10)]
        assert min(energy(found + way, *problem) for way in ways) > least
    # Along any way the least energy of a parabola is here, and on that to where it started most of all.
    for way in (free * generator.normal(size=found.shape), found, free * initial - found):
        ends = energy(found + way, *problem), energy(found - way, *problem)
        assert abs(ends[0] - ends[1]) / 2 < 1e-7 * (ends[0] - 2 * least + ends[1])


def test_displacement_masks_and_cosines_are_those_of_the_paper(problem):
    normal = np.concatenate([problem[1], -2 * problem[1][:1]])
    moved, found = displacement_masks(normal), cosines(normal)
    np.testing.assert_allclose(moved, paper_masks(normal))
    np.testing.assert_allclose(moved.max(1), 1)
    np.testing.assert_allclose(found, paper_cosines(normal), atol=1e-12)
    assert found[0, -1] == pytest.approx(-1)


def test_what_moves_nothing_has_no_mask_and_is_like_no_other(problem):
    normal = np.concatenate([problem[1], 0 * problem[1][:1]])
    assert not displacement_masks(normal)[-1].any() and not masks(normal)[-1].any()
    np.testing.assert_array_equal(cosines(normal)[-1], [*[0] * SHAPES, 1])


def test_masks_that_are_used_are_ours_and_those_of_the_paper_where_little_moves(problem):
    normal = problem[1]
    moved, kept = paper_masks(normal), masks(normal)
    np.testing.assert_allclose(kept, own_masks(normal))
    assert (kept >= moved).all() and (kept[moved >= 0.25] == 1).all() and (kept[moved == 0] == 0).all()
    far = np.linalg.norm(normal[0], axis=1).max()
    damped = masks(normal, np.where(np.arange(len(normal)) == 0, 8 * far, 0))
    np.testing.assert_allclose(damped[0], 4 * moved[0] / 8)
    np.testing.assert_array_equal(damped[1:], kept[1:])


def test_the_structure_is_that_of_the_paper_for_expressions_that_are_alike(problem):
    """Equation 9, pair by pair; of those that are opposite it falls without bound, so ours is another."""
    normal = np.abs(problem[1])
    numbers = np.random.default_rng(2).normal(size=SHAPES)
    pairs = [
        cosine * (numbers[i] - numbers[j]) ** 2
        for (i, j), cosine in np.ndenumerate(paper_cosines(normal))
        if cosine > 0
    ]
    assert len(pairs) == SHAPES**2
    assert 2 * numbers @ structure(normal) @ numbers == pytest.approx(sum(pairs))
    assert np.linalg.eigvalsh(structure(problem[1])).min() > -1e-12
    # Opposite expressions that are each other's reverse cost nothing, and neither do equal ones that are the same.
    pair = structure(np.array([problem[1][0], -problem[1][0]]))
    assert np.array([1.0, -1]) @ pair @ [1, -1] == pytest.approx(0, abs=1e-12)
    assert np.array([1.0, 1]) @ pair @ [1, 1] == pytest.approx(4)


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
