import numpy as np

from caricli.data.albedo import vertex_painter
from caricli.methods.creases.flushed_skin import FlushedSkin
from caricli.template.head import load_head


def test_anger_reddens_cheeks_and_stretching_pales_lips():
    head = load_head()
    template = head.template()
    skin = FlushedSkin(vertex_painter(template))
    np.testing.assert_allclose(skin.factors({}, 1.0), 1)
    anger = {f"{name}{side}": 1.0 for name in ("browDown", "noseSneer") for side in ("Left", "Right")}
    red, green, _ = skin.factors(anger, 1.0)[template.mask("cheek_left")].mean(0)
    assert green < red - 0.03
    stretched = skin.factors({"mouthStretchLeft": 1.0, "mouthStretchRight": 1.0}, 1.0)
    assert stretched[skin.lips > 0.9, 1].min() > 1.05
    np.testing.assert_allclose(skin.factors(anger, 0.0), 1)
    # Both sides together are as much as an action without sides, one is half of it; lips keep their own colour.
    acts = [{"mouthSmileLeft": 1.0}, {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0}, {"jawOpen": 1.0}]
    half, whole, other = (np.log(skin.factors(act, 1.0)[template.mask("cheek_left"), 1]) for act in acts)
    np.testing.assert_allclose(half, whole / 2)
    np.testing.assert_allclose(whole, other)
    np.testing.assert_allclose(skin.factors({"cheekPuff": 1.0}, 1.0)[skin.lips == 1], 1)
