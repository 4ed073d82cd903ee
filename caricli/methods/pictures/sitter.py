"""Somebody to draw: a face with all that is on and in it."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.data.albedo import mesh_painter
from caricli.data.appearance import Appearance, random_appearance
from caricli.geometry.smooth_step import smooth_step
from caricli.methods.creases.creased_skin import CreasedSkin
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.parts.attachment import attachment_for
from caricli.methods.parts.shoulders import add_shoulders
from caricli.methods.pictures.background import random_colour
from caricli.methods.pictures.eyes import Eyes
from caricli.methods.pictures.glasses import random_glasses
from caricli.methods.pictures.hair import random_beard, random_hat, random_wig
from caricli.methods.pictures.mime import is_usual_head, random_mime
from caricli.methods.pictures.piece import Piece, join_pieces, make_piece
from caricli.methods.pictures.settings import SitterSettings
from caricli.methods.pictures.wrinkles import WrinkleLines
from caricli.render.eyes.place_eyeballs import place_eyeballs
from caricli.render.pixels.paint import mix
from caricli.render.pixels.srgb import to_linear, to_srgb
from caricli.render.sky import DIRECTIONS, sky_visibility
from caricli.render.smooth_normals import smooth_normals
from caricli.structures import Material, Part
from caricli.structures.landmarks import POINT_NAMES
from caricli.structures.materials import FINISHES
from caricli.structures.parsing import Region
from caricli.template.annotation import EARS
from caricli.template.fine_mesh import fine_mesh
from caricli.template.template import Template

REGIONS = {
    Material.TEETH: Region.TEETH,
    Material.GUMS: Region.MOUTH,
    Material.TONGUE: Region.MOUTH,
    Material.LASHES: Region.EYES,
}
"""What parts of a head are in a label map."""

_SPHERE = ShellSettings(coarse=(40, 48))


@dataclass(frozen=True, eq=False)
class Sitter:
    """A head to draw, in its own frame, metres.

    skin: Template in the shape of the face. pieces: Piece of W vertices. normals: (W, 3). transfer: (W, D) how much of
    the light of DIRECTIONS reaches a vertex, cosine included. eyes: Eyes. albedo: (V, 3) sRGB from 0 to 1, unlit, of
    the skin's vertices. creases: CreasedSkin of the first of the pieces, or None.
    """

    skin: Template
    pieces: Piece
    normals: np.ndarray
    transfer: np.ndarray
    eyes: Eyes
    albedo: np.ndarray
    creases: CreasedSkin | None = None


@dataclass(frozen=True, eq=False)
class Shadows:
    """What of the sky a head sees. visibility: (V, D), of the coarse skin's vertices. changing: (V,) bool, those for
    which an expression changes it. parts: vertices in the mouth, after the skin; all further ones see all of it."""

    visibility: np.ndarray
    changing: np.ndarray
    parts: int


class Wardrobe:
    """What all people who are drawn share, prepared once."""

    def __init__(self, template: Template, settings: SitterSettings | None = None) -> None:
        """template: of the faces."""
        self.template = template
        self.settings = settings or SitterSettings()
        self.fine = fine_mesh(template, 1)
        self.painter = mesh_painter(template, self.fine.weights, self.fine.mesh.faces)
        self.wrinkles = WrinkleLines(self.painter)
        self.attachment = attachment_for(template)
        self.open_head = is_usual_head(template)
        self.cartoon = attachment_for(template, "cartoon") if self.open_head else None
        self.regions = self._skin_regions()
        self.beards = self._beards()
        self.stiff = template.mask(*EARS, "inner_mouth", "eye_socket_left", "eye_socket_right")

    def seat(self, vertices: np.ndarray, generator: np.random.Generator) -> Sitter:
        """Dress a face (V, 3), metres, at random."""
        settings = self.settings
        appearance = random_appearance(generator)
        if self.open_head:
            vertices = vertices + random_mime(vertices, self.template, settings, generator)
        head = self.template.with_vertices(vertices)
        worn, scalp = self.headwear(head, appearance, generator)
        skin = self._skin(head, replace(appearance, scalp=scalp), generator)
        pieces = [skin, *self._parts(head, skin, generator), *worn]
        pieces += self.beard(skin, appearance, generator)
        marks = vertices[self.template.annotation.landmarks]
        if self.template.annotation.has_extra and generator.random() < settings.glasses:
            pieces += random_glasses(marks, generator.random() < settings.dark, generator)
        together = join_pieces(pieces)
        normals, transfer = self.light_transfer(head, together, len(skin.vertices))
        iris = generator.random(3) ** 2 * generator.uniform(0.1, 0.6)
        eyes = Eyes(place_eyeballs(head, self.template.annotation), iris, float(generator.uniform(0.34, 0.62)))
        return Sitter(head, together, normals, transfer, eyes, to_srgb(skin.colours[: len(vertices)]))

    def _skin_regions(self) -> np.ndarray:
        """(P,) Region of the finer skin's vertices, but what hair and beard make of it."""
        template = self.template
        labels = np.full(len(self.fine.mesh.vertices), Region.SKIN, np.uint8)
        for region, names in (
            (Region.NECK, ("neck",)),
            (Region.NOSE, ("nose",)),
            (Region.EARS, EARS),
            (Region.MOUTH, ("inner_mouth",)),
        ):
            labels[self.fine.weights @ template.mask(*names).astype(float) > 0.5] = region
        labels[(self.painter.lips < 0) & (labels != Region.MOUTH)] = Region.LIPS
        return labels

    def _beards(self) -> dict[str, np.ndarray]:
        """(V,) by kind of beard how thick it grows at the vertices, 0 to 1."""
        painter = self.painter
        count = len(self.template.vertices)
        marks = painter.marks
        x, y, _ = painter.places[:count].T
        lips = painter.lips[:count]
        below = smooth_step(y, marks[POINT_NAMES["nose_base"], 1] + 0.02, marks[POINT_NAMES["nose_base"], 1] - 0.06)
        above = smooth_step(y, marks[62, 1] - 0.12, marks[62, 1])
        bare = smooth_step(lips, 0.0, 0.03) * below
        bare *= ~self.template.mask("inner_mouth", *EARS, "neck")
        jaw = np.maximum(smooth_step(painter.jaw[:count], 0.4, 0.15), smooth_step(painter.chin[:count], 0.35, 0.15))
        around = smooth_step(lips, 0.28, 0.12)
        front = painter.places[:count, 2] > marks[[0, 16], 2].mean() - 0.1
        moustache = smooth_step(lips, 0.22, 0.1) * above * smooth_step(np.abs(x - marks[62, 0]), 0.5, 0.3)
        goatee = np.maximum(moustache, smooth_step(np.abs(x - marks[62, 0]), 0.35, 0.22) * np.maximum(jaw, around))
        full = np.maximum(jaw, around)
        return {name: field * bare * front for name, field in
                (("full", full), ("goatee", goatee), ("moustache", moustache))}  # fmt: skip

    def _skin(self, head: Template, appearance: Appearance, generator: np.random.Generator) -> Piece:
        colour = to_linear(self.painter.draw(appearance))
        if generator.random() < self.settings.wrinkled:
            colour = colour * self.wrinkles.draw(generator)[:, None] ** np.array([0.8, 1.0, 1.1])
        labels = self.regions.copy()
        width, density = appearance.brow
        if density > 0.4:
            for distance, share in self.painter.brows:
                thick = width * np.interp(share, [0, 0.2, 0.6, 1], [0.55, 1, 0.8, 0.2])
                labels[(distance < thick) & (labels == Region.SKIN)] = Region.BROWS
        if appearance.scalp:
            labels[(self.painter.scalp > 0.5) & (labels == Region.SKIN)] = Region.HAIR
        vertices = self.fine.weights @ head.vertices
        gloss = float(generator.uniform(0, 0.4))
        return make_piece(vertices, self.fine.mesh.faces, labels, colour, gloss)

    def _parts(self, head: Template, skin: Piece, generator: np.random.Generator) -> list[Piece]:
        """Teeth, tongue, lashes, neck and shoulders, as far as the topology has them."""
        if self.attachment is None:
            return []
        settings = self.settings
        lashes = generator.random() < settings.lashes
        cartoon = self.cartoon if generator.random() < settings.cartoon else None
        parts = [part for part in (cartoon or self.attachment).attach(head) if lashes or part.name != "lashes"]
        white = generator.uniform([0.85, 0.8, 0.65], [1.05, 1.03, 1.0])
        longer = generator.uniform(1, settings.longest) if generator.random() < settings.long_teeth else 1.0
        pieces = [_lengthened(part_piece(part, white), part.name, longer) for part in parts]
        return [*pieces, self._bust(head, skin, generator)] if self.open_head else pieces

    def _bust(self, head: Template, skin: Piece, generator: np.random.Generator) -> Piece:
        """Neck and shoulders, clothed below a neckline."""
        mesh = add_shoulders(self.template, head.vertices).mesh
        rim = skin.colours[: len(head.vertices)][self.template.mask("neck")]
        tone = np.median(rim, axis=0)
        depth = (mesh.vertices[:, 1].max() - mesh.vertices[:, 1]) / np.ptp(mesh.vertices[:, 1])
        spread = np.abs(mesh.vertices[:, 0] - mesh.vertices[:, 0].mean()) / np.ptp(mesh.vertices[:, 0])
        line = generator.uniform(0.05, 0.6) - generator.uniform(0, 0.9) * spread
        cloth = depth > line
        colour = mix(np.broadcast_to(tone, mesh.vertices.shape), random_colour(generator), cloth.astype(float))
        return make_piece(mesh.vertices, mesh.faces, np.where(cloth, Region.CLOTH, Region.NECK), colour)

    def headwear(
        self, head: Template, appearance: Appearance, generator: np.random.Generator
    ) -> tuple[list[Piece], float]:
        """Hair and hat, and how much of the scalp is painted with hair."""
        settings = self.settings
        if not {*EARS, "scalp"} <= head.annotation.regions.keys():
            return [], appearance.scalp
        kind = generator.random()
        hatted = generator.random() < settings.hat
        shell = kind > settings.bald + settings.shaved
        if not shell and not hatted:
            return [], float(kind > settings.bald)
        sphere = HeadSphere(head, _SPHERE)
        pieces = []
        thickness: np.ndarray | float = 0.0
        if shell:
            wig, thickness = random_wig(sphere, appearance.hair, generator, settings)
            pieces.append(wig)
        if hatted:
            pieces += random_hat(sphere, thickness, generator)
        return pieces, float(shell or kind > settings.bald)

    def beard(self, skin: Piece, appearance: Appearance, generator: np.random.Generator) -> list[Piece]:
        """A beard on the skin, or none."""
        settings = self.settings
        if generator.random() >= settings.beard:
            return []
        count = len(self.template.vertices)
        grown = self.beards[str(generator.choice(list(self.beards)))]
        coarse = make_piece(skin.vertices[:count], self.template.faces, Region.SKIN, skin.colours[:count])
        normals = smooth_normals(coarse.vertices, coarse.faces)
        thickness = generator.uniform(*settings.beard_thickness) * np.ptp(coarse.vertices[:, 1])
        tone = appearance.hair * generator.uniform(0.6, 1.3)
        beard = random_beard(coarse, normals, grown, tone, thickness)
        return [] if beard is None else [beard]

    def light_transfer(
        self, head: Template, pieces: Piece, skin: int, usual: Shadows | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Normals (W, 3) and transfer (W, D); between the vertices of the coarse skin shadows are interpolated.

        skin: vertices of the fine skin. usual: Shadows on the same head with another expression, to be quicker.
        """
        count = len(head.vertices)
        vertices = np.concatenate([pieces.vertices[:count], pieces.vertices[skin:]])
        others = pieces.faces[(pieces.faces >= skin).all(1)] - (skin - count)
        faces = np.concatenate([head.faces, others])
        coarse = smooth_normals(vertices, faces)
        seen = _visibility(vertices, faces, coarse, usual)
        normals = np.concatenate([self.fine.weights @ coarse[:count], coarse[count:]])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        seen = np.concatenate([self.fine.weights @ seen[:count], seen[count:]])
        cosines = np.maximum(normals @ DIRECTIONS.T, 0)
        return normals, (4 / len(DIRECTIONS) * seen * cosines).astype(np.float32)


def _visibility(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray, usual: Shadows | None) -> np.ndarray:
    """(W, D) of ``sky_visibility``; with usual Shadows only what changes looks around, and what faces the front."""
    if usual is None:
        return sky_visibility(vertices, faces, normals)
    count = len(usual.visibility)
    ids = np.flatnonzero(np.concatenate([usual.changing, normals[count : count + usual.parts, 2] > 0]))
    seen = np.ones((len(vertices), len(DIRECTIONS)), np.float32)
    seen[:count] = usual.visibility
    seen[ids] = sky_visibility(vertices, faces, normals, ids)
    return seen


def _lengthened(piece: Piece, name: str, factor: float) -> Piece:
    """A row of teeth longer by a factor, away from its jaw; any other part as it is."""
    if name not in ("teeth_upper", "teeth_lower"):
        return piece
    heights = piece.vertices[:, 1]
    root = heights.max() if name == "teeth_upper" else heights.min()
    vertices = piece.vertices.copy()
    vertices[:, 1] = root + factor * (heights - root)
    return replace(piece, vertices=vertices)


def part_piece(part: Part, white: np.ndarray) -> Piece:
    """A part of a head in its plain colours; teeth in that of the person."""
    mesh = part.mesh
    colours = np.zeros((len(mesh.vertices), 3))
    regions = np.full(len(mesh.vertices), Region.SKIN, np.uint8)
    for material in np.unique(part.materials):
        used = mesh.polygons[part.materials == material]
        used = used[used >= 0]
        tone = np.array(FINISHES[Material(material)].linear)
        colours[used] = tone * white if material == Material.TEETH else tone
        regions[used] = REGIONS.get(Material(material), Region.SKIN)
    return make_piece(mesh.vertices, mesh.faces, regions, colours, 0.3)
