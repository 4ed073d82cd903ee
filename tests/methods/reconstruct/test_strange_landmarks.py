"""Landmarks far from every face of the model: what they pull at follows, what they do not show is as usual."""

from dataclasses import replace

import numpy as np
import pytest

from caricli.data.move_parts import move_parts, random_hand, random_part_changes
from caricli.methods.reconstruct.fit_landmarks_intrinsic import fit_landmarks_intrinsic
from caricli.methods.reconstruct.settings import IntrinsicSettings
from caricli.structures import Camera
from caricli.structures.landmarks import EAR_LEFT, MOUTH

ALONE = replace(IntrinsicSettings(), turns=0)
"""Without turns of correction and latent."""
STRENGTH = 2.5
"""Of changes and hand, about twice those of the training faces."""


@pytest.fixture(scope="module")
def drawings(intrinsic):
    """Two drawings, 81 landmarks (81, 2) each, bolder than any face of the model."""
    camera = Camera(1500.0, np.diag([1.0, -1.0, -1.0]), np.array([310.0, 540.0]))
    usual = intrinsic.template.vertices[intrinsic.template.annotation.landmarks]
    generators = [np.random.default_rng(seed) for seed in range(2)]
    bold = [move_parts(usual, random_part_changes(each, STRENGTH)) for each in generators]
    hands = [random_hand(usual, each, STRENGTH) for each in generators]
    return [camera.project(moved + hand) for moved, hand in zip(bold, hands, strict=True)]


def ear_height(vertices, template):
    return np.ptp(vertices[template.mask("ear_left"), 1])


def test_ears_that_nothing_shows_are_more_usual_than_the_latent_has_them(drawings, intrinsic):
    template = intrinsic.template
    usual = ear_height(intrinsic.decode(intrinsic.prior.mean), template)
    for points in drawings:
        fit = fit_landmarks_intrinsic(points[:68], intrinsic)
        told = ear_height(intrinsic.decode(fit.face.require_latent()), template)
        assert abs(ear_height(fit.face.vertices, template) - usual) < 0.65 * abs(told - usual)


def test_an_ear_that_landmarks_show_is_where_they_show_it(drawings, intrinsic):
    points = drawings[0].copy()
    ear = list(EAR_LEFT)
    points[ear] = points[ear].mean(0) + 1.5 * (points[ear] - points[ear].mean(0))
    fit = fit_landmarks_intrinsic(points, intrinsic)
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert np.linalg.norm(fit.face.landmarks[ear] - points[ear], axis=1).max() < 0.02 * diagonal


def test_turns_bring_the_surface_nearer_to_a_face(drawings, intrinsic):
    face = intrinsic.template.region("face")
    for points in drawings:
        fits = [fit_landmarks_intrinsic(points[:68], intrinsic, settings) for settings in (IntrinsicSettings(), ALONE)]
        with_turns, alone = (np.linalg.norm(fit.face.residual[face], axis=1).mean() for fit in fits)
        assert with_turns < 0.85 * alone
        assert fits[0].nme_latent < 0.8 * fits[1].nme_latent
        assert fits[0].nme < 0.6


def test_a_face_that_the_model_explains_needs_none(intrinsic, seen):
    latent = 0.5 * np.random.default_rng(5).normal(size=len(intrinsic.prior.mean))
    points = seen(intrinsic.decode(latent)).points
    faces = [fit_landmarks_intrinsic(points, intrinsic, settings).face for settings in (IntrinsicSettings(), ALONE)]
    assert np.array_equal(faces[0].vertices, faces[1].vertices)


def test_doubtful_landmarks_within_a_strange_face_are_met_nearly(drawings, intrinsic):
    for points in drawings:
        diagonal = np.linalg.norm(np.ptp(points, axis=0))
        doubts = np.tile((0.012 * diagonal) ** 2 * np.eye(2), (len(points), 1, 1))
        gaps = fit_landmarks_intrinsic(points, intrinsic, spreads=doubts).face.landmarks - points
        assert np.linalg.norm(gaps[list(MOUTH)], axis=1).mean() < 0.005 * diagonal
