import numpy as np

from caricli.models.detector.usual_shapes import UsualShapes


def test_distances_are_one_in_the_mean_of_what_they_were_found_in():
    rng = np.random.default_rng(0)
    shapes = rng.normal(size=(300, 4)) @ rng.normal(size=(4, 30)) + 0.1 * rng.normal(size=(300, 30))
    usual = UsualShapes.of(shapes, 4)
    np.testing.assert_allclose(usual.distances(shapes).mean(), 1, rtol=1e-9)
    # As far along an axis as usual in the mean square, and as much of what no axis holds.
    along = usual.middle + usual.spreads[0] * usual.axes[0]
    np.testing.assert_allclose(usual.distances(along[None]), 1 / (2 * 4), rtol=1e-9)
    aside = np.linalg.svd(usual.axes)[2][-1]
    np.testing.assert_allclose(
        usual.distances((usual.middle + usual.spreads[-1] * aside)[None]), 1 / (2 * 26), rtol=1e-6
    )


def test_shapes_that_hardly_differ_have_fewer_axes():
    rng = np.random.default_rng(0)
    usual = UsualShapes.of(np.ones((5, 30)), 20)
    assert len(usual.axes) == 4
    alone = UsualShapes.of(np.ones((1, 30)), 20)
    assert all(np.isfinite(each.distances(rng.normal(size=(3, 30)))).all() for each in (usual, alone))
