"""What `caricli texture` reads, makes and writes besides its options."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.commands.rigging import EYES
from caricli.errors import InputError, shown
from caricli.io.face import write_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image, write_png
from caricli.io.obj import write_obj
from caricli.methods.rig.add_eyeballs import TEXTURE, add_eyeballs, fit_eyeballs
from caricli.methods.texture.texture_face import texture_face
from caricli.render.contact_sheet import contact_sheet
from caricli.render.diffuse_background import diffuse_background
from caricli.render.draw_textured import ANGLES, draw_textured, render_textured
from caricli.render.eye_colours import eye_colours
from caricli.render.head_views import head_views
from caricli.render.mask_face import mask_face
from caricli.render.paint_eye import paint_eye
from caricli.render.rasterise import rasterise
from caricli.structures import Mesh, Rig
from caricli.template.template import Template

SKIN, VIEW = "texture.png", 320


@dataclass(frozen=True, eq=False)
class Painted:
    """rig: Rig of the textured head with its eyes, without expressions; error: mean difference to the picture where
    both show the head, of full scale; seen: share of the surface that the picture shows."""

    rig: Rig
    error: float
    seen: float


def head_mask(path, picture, face, pose, template, sources):
    """(H, W) bool: the head in a picture, of a mask file or cut out by colours.

    sources: paths of the face and of the picture, for messages.
    """
    if face.landmarks is None:
        raise InputError(
            f"{shown(sources[0])}: expected a face with fitted landmarks, found none; make one with caricli "
            "reconstruct-from-landmarks"
        )
    placed = pose.place(face.vertices)
    raster = rasterise(placed, template.faces, picture.shape[1], picture.shape[0])
    if (raster.face >= 0).mean() < 1e-4:
        raise InputError(f"{shown(sources[1])}: expected the picture that the face was fitted to, found it outside")
    if path is None:
        mask = mask_face(picture, placed, template.faces, face.landmarks)
    else:
        given = read_image(path)
        if given.shape != picture.shape:
            expected, found = (f"{image.shape[1]} x {image.shape[0]}" for image in (picture, given))
            raise InputError(f"{shown(path)}: expected the picture's size, {expected}, found {found}")
        mask = given.mean(2) > 127
    if not (mask & (raster.face >= 0)).any():
        expected = "the head where the face was fitted" if path is None else "white where the head is"
        raise InputError(f"{shown(path or sources[1])}: expected {expected}, found none there")
    return mask


def paint(face, pose, picture, mask, template, size, flat, generator):
    """Painted: the head with its texture, or, if flat, with the picture itself (portrait paper, equation 12)."""
    vertices = face.vertices
    if template.uvs is None and not flat:
        raise InputError("expected a model whose mesh has UVs, found none; --project-uv needs none")
    if flat:
        places = pose.project(vertices) + 0.5
        uvs = places / picture.shape[1::-1]
        uvs[:, 1] = 1 - uvs[:, 1]
        mesh = Template(vertices, template.polygons, uvs, template.polygons, annotation=template.annotation)
        image, seen = diffuse_background(picture, mask), 1.0
    else:
        mesh, found = template, texture_face(vertices, pose, picture, mask, template, size)
        image, seen = found.image, float(found.seen[found.covered].mean())
    still = np.zeros((0, *vertices.shape), np.float32)
    rig = Rig((), mesh.with_vertices(vertices.astype(np.float32)), still, texture=image)
    placed = pose.place(vertices)
    again = render_textured(rig, placed, picture.shape[1], picture.shape[0])
    both = mask & (rasterise(placed, mesh.faces, picture.shape[1], picture.shape[0]).face >= 0)
    error = float(np.abs(again.astype(float) - picture)[both].mean() / 255)
    balls = fit_eyeballs(mesh.with_vertices(vertices), mesh.annotation, still)
    eyes = paint_eye(TEXTURE, generator, *eye_colours(picture, face.landmarks))
    return Painted(add_eyeballs(rig, balls, generator, eyes), error, seen)


def write_textured(folder, painted, face, model):
    """Write the mesh as OBJ with material and pictures, as NPZ for the next command, as GLB with eyes, and a sheet."""
    rig, template, count = painted.rig, model.template, len(face.vertices)
    own = slice(None, len(template.polygons))
    width = template.polygons.shape[1]
    uv_polygons = rig.mesh.uv_polygons[own, :width]
    mesh = Mesh(face.vertices, rig.mesh.polygons[own, :width], rig.mesh.uvs[: uv_polygons.max() + 1], uv_polygons)
    write_png(folder / SKIN, rig.texture)
    if rig.eye_texture is not None:
        write_png(folder / EYES, rig.eye_texture)
    write_obj(folder / "face.obj", mesh, SKIN)
    write_face(folder / "face.npz", replace(face, mesh=mesh))
    write_gltf(folder / "face.glb", rig)
    views = ("front", "three-quarter", "profile")
    plain = head_views(template.with_vertices(rig.neutral[:count].astype(float)), views, VIEW)
    rows = [plain, draw_textured(rig, views, VIEW), draw_textured(rig, [*ANGLES][3:], VIEW)]
    labels = ["before", "", "", "after", "", "", "", "", ""]
    write_png(folder / "sheet.png", contact_sheet([picture for row in rows for picture in row], 3, labels))
