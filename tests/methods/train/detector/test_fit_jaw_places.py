import numpy as np

from caricli.geometry.lines.space_jaw import carry_jaw, space_jaw
from caricli.methods.train.detector.fit_jaw_places import fit_jaw_places
from caricli.models.detector.jaw_places import face_shape
from caricli.structures.landmarks import MIRRORED
from tests.drawn_pictures import mean_shape


def faces_with_chins(shape, count, seed, most=1.0):
    """(N, L, 2) a face whose chin is drawn out, narrow or wide, and everything shaken."""
    generator = np.random.default_rng(seed)
    faces = []
    for _ in range(count):
        long, wide = most * generator.uniform(-0.2, 1, 2)
        low = np.maximum(shape[:, 1] - shape[:, 1].mean(), 0)
        face = shape + np.stack([wide * low * np.sign(shape[:, 0]) / 2, long * low], 1)
        faces.append(face + 0.002 * np.ptp(shape) * generator.normal(size=shape.shape))
    return np.array(faces)


def test_jaws_of_other_faces_are_marked_nearer_to_where_their_shape_carries_the_points(head_template):
    shape = mean_shape(head_template)
    jaw = fit_jaw_places(np.concatenate([faces_with_chins(shape, 60, 0), faces_with_chins(shape, 40, 0, 0.05)]))
    evenly, told = [], []
    for face in faces_with_chins(shape, 20, 1):
        true = carry_jaw(face)
        # What is known of it is the line that its jaw is.
        evenly.append(np.linalg.norm(space_jaw(face) - true, axis=1)[:17].mean())
        told.append(np.linalg.norm(jaw.mark(space_jaw(face)) - true, axis=1)[:17].mean())
    assert np.mean(told) < 0.5 * np.mean(evenly)


def test_jaws_of_usual_faces_are_marked_evenly(head_template):
    """Most alike are those whose chins are hardly drawn out, whatever the others are."""
    shape = mean_shape(head_template)
    usual, others = faces_with_chins(shape, 200, 0, 0.05), faces_with_chins(shape, 300, 0)
    jaw = fit_jaw_places(np.concatenate([others, usual]))
    shapes = np.array([face_shape(space_jaw(face)) for face in np.concatenate([usual, others])])
    near = jaw.usual.distances(shapes)
    assert np.median(near[:200]) < 1.5 and np.median(near[200:]) > 3
    long = faces_with_chins(shape, 1, 1)[0]
    for face, is_even in ((shape, True), (long, False)):
        assert np.allclose(jaw.mark(face), space_jaw(space_jaw(face)), atol=1e-3 * np.ptp(face)) is is_even


def test_mirrored_faces_are_marked_as_in_a_mirror(head_template):
    shape = mean_shape(head_template)
    jaw = fit_jaw_places(faces_with_chins(shape, 30, 0))
    face = faces_with_chins(shape, 1, 2)[0]
    mirrored = face[list(MIRRORED)[: len(face)]] * [-1, 1]
    there = jaw.mark(mirrored)[list(MIRRORED)[: len(face)]] * [-1, 1]
    np.testing.assert_allclose(there, jaw.mark(face), atol=1e-6 * np.ptp(face))
