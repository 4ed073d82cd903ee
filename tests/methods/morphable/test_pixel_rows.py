import numpy as np
import torch

from caricli.methods.morphable.photometric_search import skin_patch
from caricli.methods.morphable.pixel_rows import pixel_rows, vertex_rows
from caricli.methods.morphable.renderer import MorphableRenderer, Sight
from caricli.store.models import load_morphable

SIDE = 64


def test_rows_are_what_automatic_derivatives_of_the_renderer_are():
    model = load_morphable()
    patch, vertex, triangle = skin_patch(model)
    renderer = MorphableRenderer(model)
    generator = np.random.default_rng(0)
    x = np.zeros(renderer.layout.size)
    x[: renderer.layout.face] = 0.5 * generator.normal(size=renderer.layout.face)
    renderer.layout.parts(x)["light"][:] = [2.5, 0.4, -0.5, -1.0, 0.1, 0, 0.2, 0, 0.1]
    renderer.layout.parts(x)["pose"][:] = [0.1, 0.3, -0.1, 31, 30, 220]
    whole = renderer.pose(torch.as_tensor(x, dtype=torch.float32)[None])
    sight = renderer.look(whole, SIDE, SIDE)
    kept = triangle[sight.face] >= 0
    own = Sight(sight.picture[kept], sight.row[kept], sight.column[kept], triangle[sight.face[kept]])
    colours, rows = pixel_rows(patch, vertex_rows(patch, x), own)
    assert len(colours) > 500 and rows.shape == (len(colours), 3, len(x))
    # A patch has the colours of the whole where all triangles around are in it.
    np.testing.assert_allclose(colours, renderer.paint(whole, sight)[kept].numpy(), atol=1e-4)
    for part in ("identity", "expression", "albedo", "light", "pose"):
        way = np.zeros(len(x))
        renderer.layout.parts(way)[part][:] = generator.normal(size=renderer.layout.parts(way)[part].shape)
        point, along = (torch.as_tensor(a, dtype=torch.float32) for a in (x, way))
        _, exact = torch.func.jvp(lambda x: patch.paint(patch.pose(x[None]), own), (point,), (along,))
        np.testing.assert_allclose(rows @ way, exact.numpy(), atol=2e-3 * exact.abs().max().item())
    assert (vertex[model.template.annotation.landmarks] >= 0).all()
