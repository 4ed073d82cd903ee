"""How a face is drawn in what it wears."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from caricli.geometry.comb_hair import CombedHair, comb_hair
from caricli.geometry.join_meshes import join_meshes
from caricli.geometry.mouth_light import mouth_light
from caricli.render.coat import mesh_coat
from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.render.pixels.srgb import to_linear, to_srgb
from caricli.render.shade import Look
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Face, Material, Mesh, Part, Pictures
from caricli.template.annotation import bundled_annotation
from caricli.template.template import Template, WholeHead


def face_look(face: Face, eyeballs: bool = True) -> Look:
    """The Look of a face: its pictures, and clay and white eyes where it has none.

    eyeballs: whether heads of the bundled topology get eyes, where they have none of their own.
    """
    materials = face.triangle_materials
    has_eyes = materials is not None and bool((materials == Material.EYE).any())
    return Look(
        vertex_colours=None if materials is None else plain_colours(face.mesh, materials, face.pictures),
        eyeballs=place_eyeballs(face.mesh, bundled_annotation()) if eyeballs and not has_eyes else (),
        coat=mesh_coat(face.mesh, face.pictures, materials),
        hair=None if materials is None else combed_hair(face.mesh, materials),
    )


def head_eyeballs(head: Template) -> list[tuple[np.ndarray, float]]:
    """Centres and radii of the eyeballs that a head is drawn with, where its annotation knows its lids."""
    wanted = not isinstance(head, WholeHead) or head.eyes
    return place_eyeballs(head, head.annotation) if wanted else []


def head_look(head: Template) -> tuple[Mesh, Look]:
    """A head with its parts, where it is a WholeHead, as one mesh, and its plain Look with eyeballs."""
    parts = head.dressed if isinstance(head, WholeHead) else ()
    return with_parts(head, Look(eyeballs=head_eyeballs(head)), parts)


def with_parts(mesh: Mesh, look: Look, parts: Sequence[Part]) -> tuple[Mesh, Look]:
    """A mesh joined with parts, and the Look of both, which these have in their own colours and pictures.

    look: of the mesh, no eyes among its materials, its visibility not known.
    """
    if not parts:
        return mesh, look
    joined = join_meshes([mesh, *(part.mesh for part in parts)])
    added = join_meshes([part.mesh for part in parts])
    own = np.full(len(mesh.faces), Material.SKIN) if look.coat is None else look.coat.materials
    materials = np.concatenate([own, *(np.repeat(part.materials, part.mesh.triangles_of_polygons) for part in parts)])
    colours = np.broadcast_to(look.colour if look.vertex_colours is None else look.vertex_colours, mesh.vertices.shape)
    pictures = Pictures() if look.coat is None else look.coat.pictures
    return joined, replace(
        look,
        vertex_colours=np.concatenate([colours, plain_colours(added, materials[len(own) :], pictures)]),
        coat=mesh_coat(joined, pictures, materials),
        hair=combed_hair(joined, materials),
    )


def combed_hair(mesh: Mesh, materials: np.ndarray) -> CombedHair | None:
    """How the hair of a mesh is shaded; None where it has none. materials: (F,) of the triangles."""
    hair = materials == Material.HAIR
    if not hair.any():
        return None
    normals = smooth_normals(mesh.vertices, mesh.faces)
    return comb_hair(mesh.vertices, mesh.faces, normals, hair, materials == Material.SKIN)


def plain_colours(mesh: Mesh, materials: np.ndarray, pictures: Pictures) -> np.ndarray:
    """(V, 3) sRGB of vertices where no picture is, by their finish, darker far back in the mouth.

    materials: (F,) of the triangles. pictures: what is worn beside them.
    """
    colours = np.tile(np.array(pictures.finish(Material.SKIN).colour, float), (len(mesh.vertices), 1))
    for material in np.unique(materials):
        colours[mesh.faces[materials == material]] = pictures.finish(material).colour
    light = mouth_light(mesh.vertices, mesh.faces, materials, pictures.coloured)
    inside = (light < 1).any(1)
    colours[inside] = 255 * to_srgb(light[inside] * to_linear(colours[inside] / 255))
    return colours
