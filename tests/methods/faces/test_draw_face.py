import numpy as np
import pytest

from caricli.methods.faces.draw_face import FaceDrawing
from caricli.methods.parts.whole_head import whole_head
from caricli.render.head_views import head_views
from caricli.structures import Face
from caricli.template.fine_mesh import fine_mesh


@pytest.mark.parametrize("levels", [0, 1])
def test_a_face_is_drawn_as_it_is_written(pca, strangers, levels):
    drawing = FaceDrawing(pca, fine_mesh(pca.template, levels), 48)
    latent = pca.encode(strangers[0])
    face = Face(pca.template.with_vertices(strangers[0]), latent=latent)
    views = drawing.draw(face, ("front", "profile"))
    expected = head_views(whole_head(face, pca.template), ("front", "profile"), 48, drawing.finer(face))
    assert len(views) == 2 and all(np.array_equal(*pair) for pair in zip(views, expected, strict=True))
    assert drawing.finer(face).levels == levels and len(drawing.draw(face)) == 2
