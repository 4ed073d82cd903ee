import cv2
import numpy as np
import pytest

from caricli.methods.hair.continue_strands import _Quilt, continue_strands

SIDE = 160


def deep(seen):
    """Of what is seen what no patch fades into."""
    return cv2.distanceTransform(np.pad(seen, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1] > 0.05 * len(seen)


def rays():
    """Strands that run outwards, dark and light in turns, seen in the lower third."""
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    turns = np.arctan2(x, y)
    image = np.repeat(130 + 90 * np.sign(np.sin(24 * turns))[..., None], 3, axis=2)
    return image, (np.abs(turns) < 1.0) & (np.hypot(x, y) < SIDE / 2)


def combed():
    """The same part of a head, its strands combed to the side: they run around the middle."""
    _, seen = rays()
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    return np.repeat(130 + 90 * np.sign(np.sin(np.hypot(x, y)))[..., None], 3, axis=2), seen


@pytest.mark.parametrize("strands", [rays, combed])
def test_strands_run_outwards_all_around(strands):
    image, seen = strands()
    filled = continue_strands(image, seen, np.random.default_rng(1))
    np.testing.assert_allclose(filled[deep(seen)], image[deep(seen)])
    # Behind, a step along a strand changes less than one across.
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    radius = np.hypot(x, y)
    behind = ~seen & (radius > 0.2 * SIDE) & (radius < 0.45 * SIDE)
    down, right = np.gradient(filled[..., 0])
    along = np.abs(right * x + down * y)[behind] / radius[behind]
    across = np.abs(right * y - down * x)[behind] / radius[behind]
    assert filled[behind].std() > 45 and along.mean() < 0.6 * across.mean()


def test_what_is_not_seen_never_enters():
    image, seen = rays()
    image[~seen] = 1e4
    filled = continue_strands(image, seen, np.random.default_rng(1))
    assert filled.max() <= 255


def test_the_smallest_patches_are_of_a_few_pixels():
    image = np.full((64, 64, 3), 80.0)
    seen = np.zeros((64, 64), bool)
    seen[50:56, 30:36] = True
    image[seen] = [90, 60, 30]
    filled = continue_strands(image, seen, np.random.default_rng(1))
    np.testing.assert_allclose(filled, np.broadcast_to([90, 60, 30], image.shape), atol=1)


def test_the_generator_decides():
    _, seen = rays()
    image = np.random.default_rng(0).normal(100, 5, (SIDE, SIDE, 3))
    first, again, other = (continue_strands(image, seen, np.random.default_rng(k)) for k in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_no_patch_is_taken_again_and_again():
    image, seen = rays()
    image = np.clip(image + np.random.default_rng(0).normal(0, 12, (SIDE, SIDE, 1)), 0, 255).astype(np.float32)
    quilt = _Quilt(image, seen, np.random.default_rng(1))
    for _ in range(2):
        for frame in quilt.frames():
            quilt.lay(frame)
    assert (quilt.uses > 0).mean() > 0.7 and quilt.uses.max() < 6


def test_nothing_seen_all_seen_and_too_little():
    image, seen = rays()
    generator = np.random.default_rng(0)
    np.testing.assert_allclose(continue_strands(image, ~seen & seen, generator), image)
    np.testing.assert_allclose(continue_strands(image, seen | True, generator), image)
    few = np.zeros_like(seen)
    few[80:82, 80:82] = True
    np.testing.assert_allclose(continue_strands(image, few, generator)[~few], image[few].mean(), rtol=1e-5)


def test_shadows_are_no_blotches_elsewhere():
    rows, columns = np.mgrid[:192, :192]
    grain = np.random.default_rng(0).normal(0, 10, (192, 192, 1))
    dark = np.hypot((rows - 20) % 40 - 20, (columns - 20) % 40 - 20) < 9
    image = np.clip(np.where(dark[..., None], 60, 150) + grain + np.zeros(3), 0, 255)
    seen = rows < 100
    filled = continue_strands(image, seen, np.random.default_rng(0))
    np.testing.assert_array_equal(filled[deep(seen)], image[deep(seen)].astype(np.float32))
    spread = [
        cv2.blur(picture, (9, 9))[rows][:, 10:-10].std()
        for picture, rows in ((image, slice(90)), (filled, slice(120, 192)))
    ]
    assert spread[1] < 0.5 * spread[0]


def test_what_is_seen_ends_in_no_seam():
    rows, columns = np.mgrid[:192, :192]
    grain = cv2.GaussianBlur(np.random.default_rng(0).normal(0, 60, (192, 192)), (0, 0), 2)
    image = np.repeat((100 + 60 * np.cos(columns / 20) + grain)[..., None], 3, axis=2)
    seen = rows < 100 + 10 * np.sin(columns / 7)
    filled = continue_strands(image, seen, np.random.default_rng(0))[..., 0]
    steps = np.abs(np.diff(filled, axis=0))
    seam = seen[:-1] & ~seen[1:]
    assert steps[seam].mean() < 1.5 * np.abs(np.diff(image[..., 0], axis=0)).mean()
