import numpy as np

from caricli.methods.texture.lay_out_head import GRID, lay_out_head
from caricli.template.layout import bundled_layout
from caricli.template.template import Template


def test_the_bundled_layout_is_what_this_makes(head_template):
    bare = Template(head_template.vertices, head_template.polygons, annotation=head_template.annotation)
    mesh = lay_out_head(bare)
    np.testing.assert_array_equal(mesh.polygons, head_template.polygons)
    corners = mesh.uvs[mesh.uv_polygons[mesh.polygons >= 0]]
    bundled = bundled_layout()
    expected = bundled["uvs"][bundled["uv_polygons"][mesh.polygons >= 0]]
    # Another machine rounds in another order; three hundredths of a texel of 2048 are nothing.
    np.testing.assert_allclose(corners, expected, atol=1.5e-5)
    np.testing.assert_array_equal(mesh.uvs * GRID % 1, 0)
