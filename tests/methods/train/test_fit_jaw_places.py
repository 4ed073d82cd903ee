import numpy as np

from caricli.geometry.space_jaw import carry_jaw, space_jaw
from caricli.methods.train.fit_jaw_places import fit_jaw_places
from caricli.structures.landmarks import MIRRORED
from tests.drawn_pictures import mean_shape


def faces_with_chins(shape, count, seed):
    """(N, L, 2) a face whose chin is drawn out, narrow or wide, and everything shaken."""
    generator = np.random.default_rng(seed)
    faces = []
    for _ in range(count):
        long, wide = generator.uniform(-0.2, 1, 2)
        low = np.maximum(shape[:, 1] - shape[:, 1].mean(), 0)
        face = shape + np.stack([wide * low * np.sign(shape[:, 0]) / 2, long * low], 1)
        faces.append(face + 0.002 * np.ptp(shape) * generator.normal(size=shape.shape))
    return np.array(faces)


def test_jaws_of_other_faces_are_marked_nearer_to_where_their_shape_carries_the_points(head_template):
    shape = mean_shape(head_template)
    jaw = fit_jaw_places(faces_with_chins(shape, 60, 0))
    evenly, told = [], []
    for face in faces_with_chins(shape, 20, 1):
        true = carry_jaw(face)
        # What is known of it is the line that its jaw is.
        evenly.append(np.linalg.norm(space_jaw(face) - true, axis=1)[:17].mean())
        told.append(np.linalg.norm(jaw.mark(space_jaw(face)) - true, axis=1)[:17].mean())
    assert np.mean(told) < 0.5 * np.mean(evenly)


def test_mirrored_faces_are_marked_as_in_a_mirror(head_template):
    shape = mean_shape(head_template)
    jaw = fit_jaw_places(faces_with_chins(shape, 30, 0))
    face = faces_with_chins(shape, 1, 2)[0]
    mirrored = face[list(MIRRORED)[: len(face)]] * [-1, 1]
    there = jaw.mark(mirrored)[list(MIRRORED)[: len(face)]] * [-1, 1]
    np.testing.assert_allclose(there, jaw.mark(face), atol=1e-6 * np.ptp(face))
