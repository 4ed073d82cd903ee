import numpy as np

from caricli.methods.hair.continue_strands import continue_strands


def striped():
    """Strands of random colours that run down, seen in the first third."""
    generator = np.random.default_rng(0)
    image = np.repeat(generator.uniform(0, 255, (1, 120, 3)), 40, axis=0)
    seen = np.zeros((40, 120), bool)
    seen[5:35, :40] = True
    return image, seen


def test_strands_go_on_from_top_to_bottom():
    image, seen = striped()
    filled = continue_strands(image, seen, np.random.default_rng(1))
    np.testing.assert_allclose(filled[seen], image[seen])
    # Every column is one strand, whose colour is among those that are seen, but where strips are joined.
    plain = np.ptp(filled, axis=0).max(-1) < 1e-6
    assert plain.mean() > 0.6
    away = np.abs(filled[20, plain, None] - image[0, None, :40]).max(-1).min(1)
    assert (away < 1e-4).mean() > 0.7


def test_what_is_not_seen_never_enters():
    image, seen = striped()
    image[~seen] = 1e4
    assert continue_strands(image, seen, np.random.default_rng(1)).max() <= 255


def test_the_generator_decides():
    _, seen = striped()
    image = np.random.default_rng(0).normal(100, 5, (40, 120, 3))
    first, again, other = (continue_strands(image, seen, np.random.default_rng(k)) for k in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_nothing_seen_and_all_seen():
    image, seen = striped()
    np.testing.assert_array_equal(continue_strands(image, ~seen & seen, np.random.default_rng(0)), image)
    np.testing.assert_array_equal(continue_strands(image, seen | True, np.random.default_rng(0)), image)
