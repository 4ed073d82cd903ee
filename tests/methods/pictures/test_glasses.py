import numpy as np
import pytest

from caricli.methods.pictures.glasses import random_glasses
from caricli.structures.parsing import Region


@pytest.mark.parametrize("seed", range(8))
def test_glasses_stand_before_both_eyes_alike_and_reach_to_the_ears(head_template, seed):
    marks = head_template.vertices[head_template.annotation.landmarks]
    clear, dark = (random_glasses(marks, shut, np.random.default_rng(seed)) for shut in (False, True))
    assert len(clear) == 5 and len(dark) == 7
    for piece in dark:
        assert (piece.region == Region.GLASSES).all() and piece.thin.all() and np.isfinite(piece.vertices).all()
    rims, arms, bridge = (clear[0], clear[2]), (clear[1], clear[3]), clear[4]
    for rim, eye in zip(rims, (slice(36, 42), slice(42, 48)), strict=True):
        # A ring around the eye, before the lashes.
        assert (rim.vertices[:, 2] > marks[eye, 2].max()).all()
        low, high = rim.vertices.min(0)[:2], rim.vertices.max(0)[:2]
        assert (low < marks[eye, :2].mean(0)).all() and (marks[eye, :2].mean(0) < high).all()
    sizes = [np.ptp(rim.vertices, axis=0) for rim in rims]
    np.testing.assert_allclose(*sizes, atol=1e-3)
    for arm, rim, ear in zip(arms, rims, (marks[:17][0], marks[:17][-1]), strict=True):
        assert np.abs(arm.vertices[:, 0]).min() == pytest.approx(np.abs(rim.vertices[:, 0]).max(), rel=0.05)
        back = arm.vertices[arm.vertices[:, 2].argmin()]
        assert np.sign(back[0]) == np.sign(ear[0]) and back[2] < marks[[27], 2].min() - 0.03
    # Between the eyes, from one rim to the other.
    assert np.abs(bridge.vertices[:, 0]).max() < min(np.abs(rim.vertices[:, 0]).min() for rim in rims) + 0.02
