import numpy as np

from caricli.render.sheets.error_maps import error_maps
from caricli.structures import Mesh


def test_heads_have_one_scale_and_their_front_is_shown(sphere):
    vertices, faces = sphere
    mesh = Mesh(vertices, faces)
    errors = {"small": np.full(len(vertices), 1.0), "large": np.full(len(vertices), 4.0)}
    picture = error_maps(mesh, errors).astype(int)
    assert picture.ndim == 3 and picture.shape[1] > 2 * 360
    yellow = (picture[..., 0] > 200) & (picture[..., 1] > 200) & (picture[..., 2] < 120)
    purple = (picture[..., 2] > picture[..., 1] + 20) & (picture[..., 0] < 110)
    left, right = np.s_[:, :360], np.s_[:, 360:640]
    assert purple[left].mean() > 0.2 and not yellow[left].any() and yellow[right].mean() > 0.2

    behind = np.where(vertices[:, 2] < -0.2, 4.0, 0.0)
    beside = np.where(vertices[:, 0] > 0.2, 4.0, 0.0)
    picture = error_maps(mesh, {"behind": behind, "on its left": beside}).astype(int)
    yellow = (picture[..., 0] > 200) & (picture[..., 1] > 200) & (picture[..., 2] < 120)
    assert not yellow[left].any()
    columns = np.nonzero(yellow[:, 360:640].any(0))[0]
    whole = np.nonzero((picture[:, 360:640].max(2) - picture[:, 360:640].min(2) > 30).any(0))[0]
    assert columns.mean() > whole.mean() + 20
