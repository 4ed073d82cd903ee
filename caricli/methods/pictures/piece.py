"""One surface of a head that is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from caricli.structures.parsing import Region


@dataclass(frozen=True, eq=False)
class Piece:
    """A surface with its colours.

    vertices: (W, 3) metres. faces: (F, 3), counter-clockwise from outside. region: (W,) Region.
    colours: (W, 3) linear light, unlit. gloss: (W,) strength of highlights. strands: (W, 2) where it is in a picture of
    strands, across and along them, NaN where it has none. thin: (F,) bool, triangles whose backs are seen as well.
    """

    vertices: np.ndarray
    faces: np.ndarray
    region: np.ndarray
    colours: np.ndarray
    gloss: np.ndarray
    strands: np.ndarray
    thin: np.ndarray


def make_piece(
    vertices: np.ndarray,
    faces: np.ndarray,
    region: Region | np.ndarray,
    colour: np.ndarray,
    gloss: float = 0.0,
    strands: np.ndarray | None = None,
) -> Piece:
    """A Piece of one region and colour, or of (W,) and (W, 3) of them."""
    count = len(vertices)
    return Piece(
        np.asarray(vertices, float),
        np.asarray(faces, np.int32),
        np.broadcast_to(np.asarray(region, np.uint8), count),
        np.broadcast_to(np.asarray(colour, float), (count, 3)),
        np.full(count, gloss),
        np.full((count, 2), np.nan) if strands is None else strands,
        np.zeros(len(faces), bool),
    )


def seen_from_both_sides(piece: Piece) -> Piece:
    """The same, its back seen as well."""
    return replace(piece, thin=np.ones(len(piece.faces), bool))


def join_pieces(pieces: Sequence[Piece]) -> Piece:
    """Pieces one after the other, as one."""
    starts = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    return Piece(
        np.concatenate([piece.vertices for piece in pieces]),
        np.concatenate([piece.faces + start for piece, start in zip(pieces, starts, strict=False)]).astype(np.int32),
        np.concatenate([piece.region for piece in pieces]),
        np.concatenate([piece.colours for piece in pieces]),
        np.concatenate([piece.gloss for piece in pieces]),
        np.concatenate([piece.strands for piece in pieces]),
        np.concatenate([piece.thin for piece in pieces]),
    )
