import numpy as np

from caricli.render.texture_sheet import texture_sheet
from caricli.structures import Pictures, Rig


def test_three_rows_the_first_of_them_plain(head_template):
    red = np.full((16, 16, 3), (200, 40, 40), np.uint8)
    still = np.zeros((0, *head_template.vertices.shape), np.float32)
    mesh = head_template.with_vertices(head_template.vertices.astype(np.float32))
    sheet = texture_sheet(head_template, Rig((), mesh, still, pictures=Pictures(red)), 48).astype(int)
    assert sheet.shape[0] > 3 * 48 and sheet.shape[1] >= 3 * 48
    reddish = (sheet[..., 0] - sheet[..., 1:].max(-1)) > 80
    third = len(sheet) // 3
    assert not reddish[:third].any()
    assert reddish[third : 2 * third].mean() > 0.1 and reddish[2 * third :].mean() > 0.1
