from itertools import product

import igl
import numpy as np
import pytest

from caricli.geometry.deformation.deformation_transfer import DeformationTransfer
from caricli.geometry.repair.contact_solver import SOFTNESS, Conditions, ContactSolver

PAIRS = np.array([[30, 33], [31, 33], [30, 34]])  # neighbours, whose conditions break and meet each other


@pytest.fixture(scope="module")
def solver(patch):
    held = np.zeros(len(patch[0]), dtype=bool)
    held[:5] = True
    return ContactSolver(DeformationTransfer(*patch, held), PAIRS)


@pytest.fixture(scope="module")
def dense(patch, solver):
    """Solve for conditions (directions (R, 3) on pairs (R,)) with all unknowns; returns displacements and forces."""
    vertices, faces = patch
    energy = np.kron(-igl.cotmatrix(vertices, faces).toarray(), np.eye(3))
    free = np.flatnonzero(np.repeat(np.arange(len(vertices)) >= 5, 3))

    def solve(moved, which, directions, values):
        rows = np.zeros((len(which), *vertices.shape))
        order = np.arange(len(which))
        rows[order, PAIRS[which, 0]], rows[order, PAIRS[which, 1]] = directions, -directions
        rows = rows.reshape(len(which), vertices.size)
        missing = values - rows @ moved.ravel()
        system = energy + rows.T @ rows / solver.softness
        change = np.zeros(vertices.size)
        change[free] = np.linalg.solve(system[np.ix_(free, free)], (rows.T @ missing / solver.softness)[free])
        return moved + change.reshape(vertices.shape), (missing - rows @ change) / solver.softness

    return solve


@pytest.fixture(scope="module")
def moved(patch):
    made = 0.05 * np.random.default_rng(2).normal(size=patch[0].shape)
    made[:5] = 0
    return made


NORMALS = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, -0.8, 0.6]])
NONE = np.zeros(3, dtype=bool)
FAR = np.full(3, -9.0)


def gaps(displacements):
    return displacements[PAIRS[:, 0]] - displacements[PAIRS[:, 1]]


def test_without_a_condition_nothing_changes(solver, moved, patch):
    assert solver.solve(moved, Conditions(NONE, np.zeros((3, 3)), NORMALS, FAR)) is moved
    none = ContactSolver(DeformationTransfer(*patch, np.arange(63) < 5), np.zeros((0, 2), int))
    given = Conditions(np.zeros(0, bool), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    np.testing.assert_array_equal(none.solve(moved, given), moved)


def test_pairs_that_close_agree_with_a_dense_penalty(solver, dense, moved):
    closed, targets = np.array([True, False, True]), np.array([[0.3, -0.1, 0.2], [9, 9, 9], [0.0, 0.1, -0.4]])
    found = solver.solve(moved, Conditions(closed, targets, NORMALS, FAR))
    which = np.repeat([0, 2], 3)
    expected, _ = dense(moved, which, np.tile(np.eye(3), (2, 1)), targets[closed].ravel())
    np.testing.assert_allclose(found, expected, atol=1e-9)
    missed, asked = np.abs(gaps(found) - targets)[closed], np.abs(gaps(moved) - targets)[closed]
    assert missed.max() < 5 * SOFTNESS * asked.max()
    np.testing.assert_array_equal(found[:5], 0)


@pytest.mark.parametrize("seed", range(12))
def test_what_may_not_come_nearer_is_the_best_of_all_active_sets(solver, dense, moved, seed):
    generator = np.random.default_rng(seed)
    normals = generator.normal(size=(3, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    start = (gaps(moved) * normals).sum(1)
    # Between them conditions that are met from the start, that are not, and that others break or meet.
    floors = start + generator.uniform(-0.1, 0.2, 3)
    found = solver.solve(moved, Conditions(NONE, np.zeros((3, 3)), normals, floors))
    kept = []
    for choice in product([False, True], repeat=3):
        active = np.flatnonzero(choice)
        made, forces = dense(moved, active, normals[active], floors[active])
        along = (gaps(made) * normals).sum(1)
        if (forces >= 0).all() and (np.delete(along - floors, active) >= -1e-5).all():
            kept.append(made)
    assert len(kept) == 1
    np.testing.assert_allclose(found, kept[0], atol=1e-9)
    # No floor asks for more than 0.2.
    assert ((gaps(found) * normals).sum(1) > floors - 5 * SOFTNESS * 0.2).all()


def test_closing_and_keeping_apart_together(solver, dense, moved):
    closed, targets = np.array([True, False, False]), np.full((3, 3), 0.2)
    floors = np.array([9.0, *(gaps(moved) * NORMALS).sum(1)[1:]]) + [0, 0.1, -0.3]
    found = solver.solve(moved, Conditions(closed, targets, NORMALS, floors))
    directions = np.vstack([np.eye(3), NORMALS[1]])
    expected, _ = dense(moved, np.array([0, 0, 0, 1]), directions, np.r_[targets[0], floors[1]])
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_what_was_given_stays_as_it_was(solver, moved):
    given = moved, np.array([True, False, False]), np.ones((3, 3)), NORMALS, np.ones(3)
    copies = [array.copy() for array in given]
    solver.solve(moved, Conditions(*given[1:]))
    for array, copy in zip(given, copies, strict=True):
        np.testing.assert_array_equal(array, copy)


def test_vertices_take_their_share_of_the_correction(solver, moved):
    conditions = Conditions(np.array([True, False, False]), np.full((3, 3), 0.2), NORMALS, FAR)
    share = np.random.default_rng(4).uniform(0, 1, len(moved)) * (np.arange(len(moved)) % 3 > 0)
    whole = solver.solve(moved, conditions)
    found = solver.solve(moved, conditions, share)
    np.testing.assert_allclose(found, moved + share[:, None] * (whole - moved), atol=1e-12)
    np.testing.assert_array_equal(found[share == 0], moved[share == 0])


def test_what_is_held_stays_and_its_partner_makes_the_whole_way(patch, moved):
    held = np.arange(len(patch[0])) < 5
    pairs = np.array([[2, 30], [31, 4]])
    targets = np.array([[0.1, 0.2, 0.3], [-0.2, 0.0, 0.1]])
    solver = ContactSolver(DeformationTransfer(*patch, held), pairs)
    found = solver.solve(moved, Conditions(np.ones(2, bool), targets, NORMALS[:2], FAR[:2]))
    np.testing.assert_array_equal(found[:5], 0)
    np.testing.assert_allclose(found[pairs[:, 0]] - found[pairs[:, 1]], targets, atol=5 * SOFTNESS)
