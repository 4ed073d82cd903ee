"""Bulges and depressions by rolls of the pen (sketch paper, section 3.3)."""

import igl
import numpy as np
import scipy.sparse as sp

from caricli.errors import InputError
from caricli.geometry.smooth_step import smooth_step
from caricli.methods.gesture.changed import Changed
from caricli.methods.gesture.held_deformation import solved, sound_move
from caricli.methods.gesture.selection import Selection, around_handles
from caricli.methods.gesture.settings import GestureSettings
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Face
from caricli.structures.gesture import LEVELS
from caricli.template.annotation import CAVITIES
from caricli.template.template import Template


def bulge(
    face: Face,
    template: Template,
    selection: Selection,
    level: int,
    symmetric: bool = False,
    settings: GestureSettings = GestureSettings(),  # noqa: B008 (frozen)
) -> Changed:
    """Raise a region along its normals, or press it in.

    Without handles the height is a dome: the solution of ``L w = 1`` on the skin of the region, zero at its border,
    eased so that it leaves the border and passes its top without a crease. With handles all of them go the whole way,
    and ``L w = 0`` between them and the border. Directions are normals averaged over a share of the region's radius;
    what is hidden behind the skin, lips' inner sides and nostrils, goes along less the deeper it lies.

    face: Face. template: Template of its topology. selection: Selection with a region, or handles. level: 1 to 3
    raises, -1 to -3 presses in. symmetric: the same on the other side.
    Returns Changed. Raises InputError for another level, where nothing is selected, or no skin, and where all handles
    are outside of the region.
    """
    if not 1 <= abs(level) <= LEVELS:
        raise InputError(f"expected a level from 1 to {LEVELS}, or from -{LEVELS} to -1, found {level}")
    if not len(selection.region):
        if not len(selection.handles):
            raise InputError("expected a region or handles to bulge, found neither")
        ids = around_handles(face, selection.handles, template.height, settings)
        selection = Selection(selection.handles, ids, np.setdiff1d(ids, _hidden(template)))
    radius = _Patch(face, selection).radius
    if radius == 0:
        raise InputError("expected skin to bulge, found only what is hidden behind it")
    if symmetric:
        selection = selection.with_other(selection.mirrored(template))
    handles = np.intersect1d(selection.handles, selection.region)
    if len(selection.handles) and not len(handles):
        raise InputError("expected handles within the region, found all of them outside")
    patch = _Patch(face, selection, radius)
    heights = patch.heights(handles, settings.fades[level < 0] * radius)
    size = radius * (settings.raised[level - 1] if level > 0 else -settings.pressed[-level - 1])
    ways = size * heights[:, None] * patch.directions(settings.smooth * radius)
    vertices, share = sound_move(face.vertices, face.vertices + ways, patch.region, template, settings)
    return Changed.of(face, vertices, share, patch.region)


def _hidden(template: Template) -> np.ndarray:
    """Ids of the pockets, which a region without a view has no skin in."""
    regions = template.annotation.regions
    return np.concatenate([np.zeros(0, np.int64), *(regions[name] for name in CAVITIES if name in regions)])


class _Patch:
    """A region of a face, on which smooth functions are found.

    region: (V,) bool. radius: metres, of a disc of its skin's area, or as it is given.
    """

    def __init__(self, face: Face, selection: Selection, radius: float | None = None) -> None:
        vertices = np.asarray(face.vertices, np.float64)
        self.region, self.skin = np.zeros((2, len(vertices)), bool)
        self.region[selection.region] = True
        self.skin[selection.skin] = True
        self.stiffness = -igl.cotmatrix(vertices, face.faces)
        self.mass = igl.massmatrix(vertices, face.faces, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
        self.normals = smooth_normals(vertices, face.faces)
        self.radius = float(np.sqrt(self.mass[self.skin].sum() / np.pi)) if radius is None else radius

    def heights(self, handles: np.ndarray, depth: float) -> np.ndarray:
        """(V,) 0 to 1, zero outside the region. handles: (K,) ids that have 1; none for a dome. depth: metres, in which
        they fade behind the skin."""
        height = np.zeros(len(self.skin))
        height[handles] = 1
        free = np.setdiff1d(np.flatnonzero(self.region), handles)
        system = self.stiffness + sp.diags(self.mass * ~self.skin / depth**2)
        right = -(system @ height) if len(handles) else self.mass * self.skin
        if len(free):
            height[free] = solved(system.tocsr()[free][:, free], right[free, None])[:, 0]
        return smooth_step(height, 0, max(float(height.max()), 1e-30))

    def directions(self, length: float) -> np.ndarray:
        """(V, 3) unit normals of the skin, averaged over a length in metres; behind it those of its rim."""
        skin = sp.diags(self.mass * self.skin)
        mean = solved(skin + length**2 * self.stiffness, skin @ self.normals)
        size = np.linalg.norm(mean, axis=1, keepdims=True)
        return np.where(size > 0, mean / np.where(size > 0, size, 1), self.normals)
