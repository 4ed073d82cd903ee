"""Colours for the part of a head that a picture does not show."""

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp

from caricli.geometry.cholesky import Cholesky
from caricli.geometry.triangle_normals import triangle_normals
from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.geometry.weighted_medians import weighted_medians
from caricli.methods.texture.picture_view import SeenColours, likeness
from caricli.structures import Mesh
from caricli.template.annotation import CAVITIES, EARS
from caricli.template.template import Template

FEATURES = ("brow_left", "brow_right", "lips", "nostril_left", "nostril_right", *CAVITIES)
"""Regions whose colours are not those of the skin around them."""

REGIONS = (EARS, ("neck",), ("scalp",))
"""Regions that keep a colour of their own."""


@dataclass(frozen=True)
class FillSettings:
    """How what is not seen takes its colour.

    reach: share of the head's height, how far what is seen goes on into what is not, before the colour of the region
    takes its place. other: standard deviation of colours, of full scale, from that of the region, by which they count
    as another thing and do not go on. proof: share of a region that has to be seen for its own colour to count as much
    as that of the skin. hair: share of what is seen of the scalp that is unlike skin, from which on it is hair. strand:
    as proof, of the scalp. soft: rounds of blurring the borders between regions. hold: stiffness of colours that are
    seen. faint: pull towards the usual colour, so that a mesh in pieces has an answer.
    """

    reach: float = 0.06
    other: float = 0.08
    proof: float = 0.1
    hair: float = 0.4
    strand: float = 0.002
    soft: int = 2
    hold: float = 1e4
    faint: float = 1e-6


def skin_weights(head: Template, seen: np.ndarray) -> np.ndarray:
    """(V,) square metres of plain skin of the face around every vertex, as far as it is seen, (V,) from 0 to 1."""
    face = head.mask("face") if "face" in head.annotation.regions else np.ones(len(head.vertices), bool)
    return vertex_areas(head) * seen * (face & ~head.mask(*FEATURES))


def skin_colour(head: Template, vertices: SeenColours) -> np.ndarray:
    """(3,) sRGB, the median of the face's plain skin. vertices: SeenColours of the head, without light."""
    return weighted_medians(vertices.colours, skin_weights(head, vertices.seen) + 1e-12 * vertex_areas(head))


def vertex_areas(head: Mesh) -> np.ndarray:
    """(V,) a third of the areas of the triangles around every vertex, square metres."""
    areas = np.linalg.norm(triangle_normals(head.vertices, head.faces), axis=1) / 6
    return np.bincount(head.faces.ravel(), np.repeat(areas, 3), len(head.vertices))


def fill_unseen(head: Template, vertices: SeenColours) -> np.ndarray:
    """Continue the colours that are seen over all of the surface.

    Near to what is seen its colours go on, and farther off those that are usual for the region: skin, ears, neck and
    scalp have one each, as far as enough of them is seen. What looks like another thing than its region, as a strand
    of hair on a temple, a collar on the neck or an edge of light, stays where it is seen.

    head: Template in the shape of the face. vertices: SeenColours of its vertices, without light.
    Returns (V, 3) sRGB, 0 to 255.
    """
    settings = FillSettings()
    areas = vertex_areas(head)
    usual = region_colours(head, vertices, areas, settings)
    own = likeness(vertices.colours, usual, settings.other) ** 2
    pockets = head.mask(*CAVITIES, "nostril_left", "nostril_right", "lips")
    like = np.where(pockets, 1, own)
    hold = settings.hold * vertices.seen**2 * like
    laplacian = sp.csr_matrix(-igl.cotmatrix(head.vertices, head.faces))
    pull = np.where(pockets, 0, areas / (settings.reach * head.height) ** 2) + settings.faint
    beyond = Cholesky(laplacian + sp.diags(hold + pull)).solve(hold[:, None] * (vertices.colours - usual))
    return np.clip(usual + beyond, 0, 255)


def region_colours(head: Template, vertices: SeenColours, areas: np.ndarray, settings: FillSettings) -> np.ndarray:
    """(V, 3) the colour that is usual around each vertex, of areas (V,); for the arguments see `fill_unseen`."""
    skin = skin_colour(head, vertices)
    usual = np.tile(skin, (len(areas), 1))
    plain = ~head.mask(*FEATURES)
    like = likeness(vertices.colours, skin, settings.other)
    for names in REGIONS:
        region = head.mask(*names)
        if not region.any():
            continue
        seen = areas * vertices.seen * (region & plain)
        proof = settings.proof
        if names == ("scalp",):
            # Hair or skin, never a mixture of both.
            hairy = seen @ (1 - like) > settings.hair * seen.sum()
            seen = seen * (1 - like if hairy else like) ** 2
            proof = settings.strand
        else:
            seen = seen * like**2
        share = seen.sum() / areas[region].sum()
        own = weighted_medians(vertices.colours, seen + 1e-12 * areas * region)
        usual[region] += share / (share + proof) * (own - skin)
    _, mean = vertex_neighbours(head.faces, len(areas))
    for _ in range(settings.soft):
        usual = (usual + mean @ usual) / 2
    return usual
