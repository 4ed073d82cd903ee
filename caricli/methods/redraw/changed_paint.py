"""What an expression does to the paint of a head, where a picture shows it."""

from dataclasses import dataclass

import cv2
import numpy as np

from caricli.methods.redraw.moved_head import MovedHead
from caricli.render.pixels.sample_texture import uv_pixels
from caricli.structures.texture_change import TextureChange

_MIDDLING = 160.0


@dataclass(frozen=True, eq=False)
class ChangedPaint:
    """Paint T that becomes T + G T + O (expressions paper, equation 12), sample by sample of a window.

    gain: G, (H, W, 3) float32, attention in it. offset: O, (H, W, 3) float32, in levels of 255, in the light there.
    """

    gain: np.ndarray
    offset: np.ndarray

    @property
    def strength(self) -> np.ndarray:
        """(H, W) float32 levels of 255 by which paint of a middling colour changes."""
        red, green, blue = np.moveaxis(np.abs(_MIDDLING * self.gain + self.offset), 2, 0)
        return np.maximum(np.maximum(red, green), blue)

    def paint(self, colours: np.ndarray) -> np.ndarray:
        """Lit colours (H, W, 3), 0 to 255, as they become."""
        return np.clip(colours * (1 + self.gain) + self.offset, 0, 255)


def changed_paint(head: MovedHead, change: TextureChange) -> ChangedPaint:
    """A change of texture in the chart of a head's face, at the samples that show the head."""
    original = head.original
    places = head.view.carried(original.charted)
    size = len(change.gain)
    columns, rows = np.moveaxis(uv_pixels(places[..., :2], (size, size)), -1, 0)

    # What is drawn between lips, teeth above all, is no paint of the skin.
    skin = (places[..., 2] * (1 - head.look(original.openings)))[..., None]

    def at_samples(values: np.ndarray) -> np.ndarray:
        there = cv2.remap(values.astype(np.float32), columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return there * skin

    return ChangedPaint(at_samples(change.gain), 255 * at_samples(change.offset) * head.shade)
