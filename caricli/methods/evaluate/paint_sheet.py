"""A sheet of textures that painters made for other expressions."""

from collections.abc import Mapping

import numpy as np
import torch

from caricli.methods.evaluate.evaluate_texture import Painter
from caricli.methods.train.texture.texture_losses import TextureBatch


@torch.no_grad()
def paint_sheet(painters: Mapping[str, Painter], batch: TextureBatch) -> np.ndarray:
    """Pairs, a row each: what there is, what each painter makes of it, and what is true.

    Returns (B S, (2 + painters) S, 3) uint8.
    """
    columns = [batch.source, *(painter(batch) for painter in painters.values()), batch.target]
    picture = torch.cat(columns, 3).permute(0, 2, 3, 1).flatten(0, 1)
    return np.rint(255 * picture.numpy()).astype(np.uint8)
