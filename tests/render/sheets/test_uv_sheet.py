from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.render.sheets.uv_sheet import uv_sheet

SIZE = 1024


@pytest.fixture(scope="module")
def sheet(head_template):
    return uv_sheet(head_template, SIZE)


def colour_at(sheet, template, vertices):
    """The most frequent colour, not grey, around vertices of a region."""
    used = template.polygons >= 0
    uv_of = np.zeros(len(template.vertices), int)
    uv_of[template.polygons[used]] = template.uv_polygons[used]
    x, y = (template.uvs[uv_of[vertices]] * [1, -1] + [0, 1]).T * SIZE
    rows = np.clip(np.add.outer(y, np.arange(-3, 4)), 0, SIZE - 1).astype(int).ravel()
    columns = np.clip(np.add.outer(x, np.arange(-3, 4)), 0, SIZE - 1).astype(int).ravel()
    seen = sheet[rows, columns]
    colours, counts = np.unique(seen[np.ptp(seen, axis=1) > 20], axis=0, return_counts=True)
    return colours[counts.argmax()].astype(int)


def test_it_is_a_layer_of_the_size_of_the_texture(sheet):
    assert sheet.shape == (SIZE, SIZE, 3) and sheet.dtype == np.uint8
    assert (sheet[[0, -1]] == 255).all(), "nothing lies on the border"


def test_regions_have_colours_both_sides_the_same(sheet, head_template):
    regions = head_template.annotation.regions
    colours = {name: colour_at(sheet, head_template, regions[name]) for name in ("forehead", "scalp", "neck", "chin")}
    for name in ("cheek", "ear"):
        left, right = (colour_at(sheet, head_template, regions[f"{name}_{side}"]) for side in ("left", "right"))
        assert np.abs(left - right).max() <= 1
        colours[name] = left
    values = np.array(list(colours.values()))
    apart = np.abs(values[:, None] - values[None]).max(-1) + 255 * np.eye(len(values))
    assert apart.min() > 10


def test_seams_are_red_and_names_are_written(sheet, head_template):
    red = (sheet[..., 0] > 150) & (sheet[..., 1] < 90)
    assert 1000 < red.sum() < 0.03 * SIZE**2
    # The seam on the back of the head is on both sides of the picture.
    assert red[:, : SIZE // 50].any(1).sum() > SIZE / 4 and red[:, -SIZE // 50 :].any(1).sum() > SIZE / 4
    assert (sheet.max(-1) < 60).sum() > 100


def test_a_mesh_without_uvs_is_refused(head_template):
    with pytest.raises(InputError, match="needs a mesh with UVs"):
        uv_sheet(replace(head_template, uvs=None, uv_polygons=None))
