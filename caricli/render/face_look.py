"""How a face is drawn in what it wears."""

import numpy as np

from caricli.render.coat import mesh_coat
from caricli.render.place_eyeballs import place_eyeballs
from caricli.render.shade import Look
from caricli.structures import Face, Material, Mesh
from caricli.structures.materials import FINISHES
from caricli.template.annotation import bundled_annotation


def face_look(face: Face) -> Look:
    """The Look of a face: its pictures, and clay and white eyes where it has none.

    Heads of the bundled topology get eyeballs unless they have eyes of their own.
    """
    materials = face.triangle_materials
    coat = mesh_coat(face.mesh, face.pictures, materials)
    if materials is None or Material.EYE not in materials:
        return Look(eyeballs=place_eyeballs(face.mesh, bundled_annotation()), coat=coat)
    return Look(vertex_colours=plain_colours(face.mesh, materials), coat=coat)


def plain_colours(mesh: Mesh, materials: np.ndarray) -> np.ndarray:
    """(V, 3) sRGB of vertices where no picture is, by their finish. materials: (F,) of the triangles."""
    colours = np.tile(np.array(FINISHES[Material.SKIN].colour, float), (len(mesh.vertices), 1))
    for material in np.unique(materials):
        colours[mesh.faces[materials == material]] = FINISHES[Material(material)].colour
    return colours
