from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.texture.texels import Texels
from caricli.structures import Mesh


@pytest.mark.parametrize("share", [0.0, 1e-4])
def test_uvs_that_cover_no_texel_are_refused(share):
    faces = np.array([[0, 1, 2]], np.int32)
    uvs = np.array([[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]])
    mesh = Mesh(np.eye(3), faces, uvs, faces)
    assert Texels(mesh, 64).covered.any()
    with pytest.raises(InputError, match="expected UVs that cover some of 64 x 64 texels, found some that cover none"):
        Texels(replace(mesh, uvs=share * uvs), 64)
