import cv2
import numpy as np
import pytest
import torch

from caricli.methods.train.detector.detector_losses import FaceTargets
from caricli.methods.train.detector.window_batch import WindowBatch
from caricli.methods.train.detector.windows import mirrored, moved_window
from caricli.methods.train.detector.windows_again import (
    _random_moves,
    bent_windows,
    joined_windows,
    mirrored_windows,
    picked_windows,
)
from caricli.structures.parsing import BEYOND
from tests.drawn_pictures import drawn_picture, mean_shape

SIZE = 160


@pytest.fixture(scope="module")
def windows(head_template):
    """Pictures as they are, which have the size of windows: three of one face and two of two."""
    shape = mean_shape(head_template)
    generator = np.random.default_rng(3)
    return [drawn_picture(shape, generator, faces) for faces in (1, 1, 1, 2, 2)]


def batch_of(windows, crops):
    return WindowBatch.of([_as_drawn(window) for window in windows], crops).on("cpu")


def _as_drawn(window):
    return type(window)(window.pixels.astype(np.float32) / 255, window.regions, window.landmarks, window.visible)


def test_mirrored_windows_are_those_of_mirrored_pictures(windows):
    turned = [moved_window(window, mirrored(np.eye(2, 3), SIZE), SIZE) for window in windows]
    told = mirrored_windows(batch_of(windows, 3), torch.ones(5, dtype=torch.bool))
    expected = batch_of(turned, 3)
    assert torch.equal(told.pixels, expected.pixels) and torch.equal(told.visible, expected.visible)
    torch.testing.assert_close(told.points, expected.points)
    torch.testing.assert_close(told.targets.heat, expected.targets.heat)
    assert torch.equal(told.targets.counts, expected.targets.counts)
    near = expected.targets.near[:, None]
    assert torch.equal(told.targets.near, expected.targets.near) and near.any()
    torch.testing.assert_close(told.targets.values * near, expected.targets.values * near)
    assert torch.equal(told.regions, expected.regions)


def test_only_some_are_mirrored(windows):
    whole = batch_of(windows, 3)
    told = mirrored_windows(whole, torch.tensor([True, False, False, False, True]))
    assert torch.equal(told.pixels[1:4], whole.pixels[1:4]) and torch.equal(told.points[1:], whole.points[1:])
    assert torch.equal(told.targets.heat[0], whole.targets.heat[0])
    assert not torch.equal(told.targets.heat[1], whole.targets.heat[1])


def test_windows_are_picked_from_all_that_were_joined(windows):
    few = [batch_of([windows[k], windows[3]], 1) for k in range(3)]
    together = joined_windows(few)
    assert len(together.pixels) == 6 and len(together.points) == len(together.targets.heat) == 3
    for k in range(3):
        assert torch.equal(together.pixels[k], few[k].pixels[0])
        assert torch.equal(together.regions[3 + k], few[k].regions[1])
    generator = torch.Generator().manual_seed(0)
    picked = [picked_windows(together, few[0], generator) for _ in range(20)]
    assert {len(each.pixels) for each in picked} == {2} and {len(each.points) for each in picked} == {1}
    faces = torch.stack([together.points, mirrored_windows(together, torch.ones(6, dtype=torch.bool)).points], 1)
    nearest = {int((each.points - faces).abs().sum((2, 3)).amin(1).argmin()) for each in picked}
    assert nearest == {0, 1, 2}, "also of other steps"
    assert len({each.pixels[0].float().mean().item() for each in picked}) == 20, "each in a light of its own"


def test_targets_are_in_the_order_in_which_they_are_made(windows):
    targets = FaceTargets.of(windows, SIZE)
    assert all(a is b for a, b in zip(FaceTargets(*targets.parts).parts, targets.parts, strict=True))


def test_what_is_marked_stays_where_windows_are_bent(windows):
    whole = batch_of(windows, 3)
    moves = _random_moves(3, SIZE, torch.Generator().manual_seed(5))
    assert moves.abs().amax((1, 2, 3)).min() > 3
    bent = bent_windows(whole, moves)
    assert torch.equal(bent.pixels[3:], whole.pixels[3:]) and torch.equal(bent.regions[3:], whole.regions[3:])
    for number in range(3):
        # The same by OpenCV.
        x, y = np.meshgrid(np.arange(SIZE, dtype=np.float32), np.arange(SIZE, dtype=np.float32))
        source = np.stack([x, y], -1) + moves[number].numpy()
        pixels = cv2.remap(
            whole.pixels[number].numpy(), source, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        assert np.abs(pixels.astype(int) - bent.pixels[number].numpy()).mean() < 1
        places = np.rint(source).astype(int)
        inside = ((places >= 0) & (places < SIZE)).all(-1)
        told = bent.regions[number].numpy()
        cells = places.clip(0, SIZE - 1)
        expected = np.where(inside, whole.regions[number].numpy()[cells[..., 1], cells[..., 0]], BEYOND)
        assert (told == expected).mean() > 0.999
        # A landmark is where its place came from.
        for before, after in zip(whole.points[number].numpy(), bent.points[number].numpy(), strict=True):
            if (after > 1).all() and (after < SIZE - 2).all():
                corner = np.floor(after).astype(int)
                (a, b), (c, d) = source[corner[1] : corner[1] + 2, corner[0] : corner[0] + 2]
                right, down = after - corner
                came = (a * (1 - right) + b * right) * (1 - down) + (c * (1 - right) + d * right) * down
                assert np.abs(came - before).max() < 0.02
