import numpy as np

from caricli.render.sheets.texture_sheet import texture_sheet
from caricli.structures import Pictures, Rig


def test_a_picture_and_a_textured_head_from_six_sides(head_template):
    red = np.full((16, 16, 3), (200, 40, 40), np.uint8)
    still = np.zeros((0, *head_template.vertices.shape), np.float32)
    mesh = head_template.with_vertices(head_template.vertices.astype(np.float32))
    blue = np.full((60, 60, 3), (20, 40, 220), np.uint8)
    points = np.array([[15.0, 15], [45, 45]])
    sheet = texture_sheet(blue, points, Rig((), mesh, still, pictures=Pictures(red)), 48).astype(int)
    assert sheet.shape[0] > 2 * 48 and sheet.shape[1] > 4 * 48
    reddish = (sheet[..., 0] - sheet[..., 1:].max(-1)) > 80
    bluish = (sheet[..., 2] - sheet[..., :2].max(-1)) > 80
    cells = [np.s_[row : row + 48, column : column + 48] for row in (2, 52) for column in (2, 52, 102, 152)]
    assert bluish[cells[0]].mean() > 0.9 and bluish.sum() == bluish[cells[0]].sum()
    assert [bool(reddish[cell].mean() > 0.1) for cell in cells] == [False, *[True] * 6, False]
