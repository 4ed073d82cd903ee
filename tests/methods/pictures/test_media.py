import numpy as np
import pytest

from caricli.methods.pictures.media import MEDIA


@pytest.fixture
def scene():
    """A disc with a light and a dark half before a grey ground, and its regions."""
    rows, columns = np.mgrid[:96, :96] - 47.5
    disc = rows**2 + columns**2 < 30**2
    image = np.full((96, 96, 3), 0.6, np.float32)
    image[disc] = [0.9, 0.7, 0.5]
    image[disc & (columns > 0)] = [0.3, 0.2, 0.1]
    return image, disc.astype(np.uint8)


@pytest.mark.parametrize("medium", MEDIA)
def test_every_medium_shows_the_scene_and_leaves_it_as_it_is(scene, medium):
    image, region = scene
    before = image.copy()
    draw, share = MEDIA[medium]
    assert share > 0
    for seed in range(6):
        drawn = np.clip(draw(image, region, np.random.default_rng(seed)), 0, 1)
        assert drawn.shape == image.shape and np.isfinite(drawn).all()
        # Whatever it is made with, the shape can be told.
        grey = drawn.mean(2)
        assert grey.std() > 0.02
        np.testing.assert_array_equal(
            draw(image, region, np.random.default_rng(seed)), draw(image, region, np.random.default_rng(seed))
        )
    np.testing.assert_array_equal(image, before)


def test_media_share_out_all_pictures():
    assert sum(share for _, share in MEDIA.values()) == pytest.approx(1)


EDGES = (slice(0, 8), slice(88, 96))


def drawings(medium, image, region=None, seeds=24):
    """(K, S, S, 3) the same picture by several generators."""
    region = np.ones(image.shape[:2], np.uint8) if region is None else region
    draw = MEDIA[medium][0]
    drawn = [draw(image.astype(np.float32), region, np.random.default_rng(seed)) for seed in range(seeds)]
    return np.clip(drawn, 0, 1)


@pytest.mark.parametrize("medium", MEDIA)
def test_what_is_lighter_stays_lighter_where_it_is(scene, medium):
    image, region = scene
    drawn = drawings(medium, image, region).mean(3)
    light, dark = drawn[:, 38:58, 24:40].mean((1, 2)), drawn[:, 38:58, 56:72].mean((1, 2))
    assert (light - dark).min() > -0.05 and (light - dark).mean() > 0.1


@pytest.mark.parametrize("medium", ["photograph", "painted", "flat", "halftone"])
def test_media_of_colours_keep_them(scene, medium):
    """Some photographs and prints are black and white."""
    image, region = scene
    drawn = drawings(medium, image, region)
    inside = drawn[:, 38:58, 26:40].mean((1, 2))
    outside = drawn[:, 4:14, 4:90].mean((1, 2))
    warm = inside[:, 0] - inside[:, 2] - (outside[:, 0] - outside[:, 2])
    assert warm.min() > -0.05 and np.median(warm) > 0.15
    assert np.abs(inside.mean(0) - [0.9, 0.7, 0.5]).max() < 0.2 and np.abs(outside.mean(0) - 0.6).max() < 0.15


@pytest.mark.parametrize("medium", ["inked", "hatched", "pencil", "flat"])
def test_media_of_lines_draw_them_around_regions_too(scene, medium):
    """Where nothing else tells one from the other, and darker than what they part."""
    _, region = scene
    drawn = drawings(medium, np.full((96, 96, 3), 0.8), region).mean(3)
    rows, columns = np.mgrid[:96, :96] - 47.5
    away = np.abs(np.hypot(rows, columns) - 30)
    darker = drawn[:, away > 8].mean(1) - drawn[:, away < 1].mean(1)
    assert darker.min() > -0.03 and (darker > 0.1).mean() > 0.3
    assert (drawn[:, (away > 6) & region.astype(bool)].mean(1) > 0.45).mean() > 0.8, "lines, not areas"


def test_photographs_are_darker_in_their_corners_and_have_grain():
    drawn = drawings("photograph", np.full((96, 96, 3), 0.5), seeds=40).mean(3)
    corners = np.stack([drawn[:, rows, columns].mean((1, 2)) for rows in EDGES for columns in EDGES])
    middle = drawn[:, 38:58, 38:58].mean((1, 2))
    assert (corners < middle + 0.01).all() and (corners.mean(0) < 0.93 * middle).mean() > 0.4
    assert np.ptp(corners, axis=0).max() < 0.04
    assert np.median(drawn[:, 38:58, 38:58].std((1, 2))) > 0.01
    assert np.abs(middle - 0.5).max() < 0.25


def test_the_darker_a_place_the_more_it_is_hatched_in_lines():
    image = np.repeat(np.repeat([0.9, 0.5, 0.34, 0.1], 24)[None, :, None], 96, 0).repeat(3, 2)
    drawn = drawings("hatched", image).mean(3)
    levels = np.array([drawn[:, :, k + 6 : k + 18].mean((1, 2)) for k in (0, 24, 48, 72)])
    assert (np.diff(levels.mean(1)) < -0.03).all() and (np.diff(levels, axis=0) < 0.02).all()
    assert drawn[:, :, 30:42].std((1, 2)).min() > 0.05


@pytest.mark.parametrize("tone", [0.25, 0.5, 0.75])
def test_prints_are_of_dots_as_dark_as_what_they_show(tone):
    drawn = drawings("halftone", np.full((240, 240, 3), tone)).mean(3)
    for each in drawn:
        assert each.std() > 0.05
        cells = each.reshape(12, 20, 12, 20).mean((1, 3))
        assert cells.std() < 0.3 * each.std() and abs(each.mean() - tone) < 0.15
        # Dots, not stripes: along any row or column it changes.
        assert min(each.std(0).min(), each.std(1).min()) > 0.02


def test_flat_pictures_are_of_few_steps_of_light(scene):
    ramp = np.linspace(0.05, 0.95, 96)[None, :, None] * np.ones((96, 1, 3))
    for drawn in drawings("flat", ramp)[:, 48]:
        steps = np.abs(np.diff(drawn.mean(1)))
        assert (steps > 0.03).sum() < 24 and (steps < 0.004).mean() > 0.6


def test_a_pencil_leaves_paper_light_and_its_dark_has_grain(scene):
    image, region = scene
    drawn = drawings("pencil", image, region).mean(3)
    assert drawn[:, 4:14, 4:90].mean((1, 2)).min() > 0.5
    dark, light = (np.median(part.std((1, 2))) for part in (drawn[:, 38:58, 56:72], drawn[:, 4:14, 4:90]))
    assert dark > 0.02 and dark > 2 * light


def test_hatching_is_as_fine_in_large_pictures():
    """How often hatching of a dark ground crosses its mean along a row."""
    counts = []
    for size in (256, 1024):
        image = np.full((size, size, 3), 0.1, np.float32)
        rows = drawings("hatched", image, seeds=4).mean(3)
        crossings = np.diff(np.sign(rows - rows.mean((1, 2), keepdims=True)), axis=2) != 0
        counts.append(crossings.sum(2).mean())
    assert counts[1] == pytest.approx(counts[0], rel=0.25)
