"""What sketches are read by; light to import, because the command line takes its defaults from here."""

from dataclasses import dataclass

COARSE = ("network", "model")
"""How the face of a sketch begins; the first is the default."""
ELASTIC = "elastic"
"""How it begins where neither of these has a face like that."""

SELDOM = ("eye_fold", "nose_tip", "nostril")
"""What the names of curves begin with that are drawn beside others, the lids and the wings of the nose, if at all."""

ALONE = {"nose_tip": "nose", "eye_fold_left": "eye_upper_left", "eye_fold_right": "eye_upper_right"}
"""Of curves that are drawn beside others those that are drawn where only one of both is."""

BESIDE = "ear"
"""What the names of curves begin with that lie beside the outline."""

MOUTH = "mouth"
"""What the names of the curves of lips begin with."""

MIDDLE = (MOUTH, "nose")
"""What the names of curves begin with that lie in the middle: of two strokes on either side none draws a whole one."""

PARTS = (MOUTH, ("nose", "nostril"), ("brow", "eye"), BESIDE)
"""What the names of curves begin with that are one part of a face; artists move and enlarge each as they like."""

PIECED = "nose"
"""The curve that is often drawn by several strokes: its wings, and what is between them."""

ORDERED = (
    ("brow_left", "eye_fold_left", "eye_upper_left", "eye_lower_left"),
    ("brow_right", "eye_fold_right", "eye_upper_right", "eye_lower_right"),
    ("mouth_upper", "mouth_inner_upper", "mouth_inner_lower", "mouth_lower"),
)
"""Curves that lie one below the other."""

CORNERED = ("brow", "eye_upper", "eye_lower", "eye_fold", "mouth")
"""What the names of curves begin with whose ends everybody draws; others fade out where an artist likes."""

UNUSUAL = 0.03
"""Of the diagonal of the lines: root mean square of their distances from the face that a network sees, from which on it
is none that networks know. Of 100 sketches that unsteady hands drew of people of validation splits 98 are nearer; of
those above 0.02 what the network sees is 5.4 mm off, elastic faces 8.1."""


@dataclass(frozen=True)
class PaperSettings:
    """What is ink on paper. Lengths are shares of the longer side of the picture; speck, stray and area of the
    drawing's.

    side: pixels that larger pictures are made smaller to. light: over how far light and paper change. grain: how many
    times as dark as the paper's grain ink is at least. faint, ink: least darkness, of the paper's brightness, that
    continues a line and that begins one. pale: darkness of a line, of the usual one's, at least. speck: of a line, what
    is shorter is dirt. stray: likewise beside all that is longer. thick: half the width of the widest line. area: the
    same of what is filled, of which the outline is drawn. solid: share of the ink that may be wider than lines. most:
    share of the paper that lines cover at most. coarsest: grain, of the paper's brightness, that paper has at most.
    ruling: of the shorter side, ink along a straight line of the paper's own. ruled: how many of one direction there
    are at least. bold: how many times as dark as these what is drawn on ruled paper is at least. colours: how far, in
    steps of Lab, it may change its colour. table: how much brighter the paper is than what lies around it, where it is
    told from it. margin: of the sheet, what is left out at its edge. black: of the brightness around, that of what is
    filled with ink and no shadow. dot: what is filled with ink of any darkness, as pupils are, at most. small: of the
    longer side, a drawing that is looked at from near. tight: one that is looked at with more paper around it. fill: of
    the canvas, the longer side of the drawing.
    """

    side: int = 1024
    light: float = 0.09
    grain: float = 3.5
    faint: float = 0.05
    ink: float = 0.11
    pale: float = 0.35
    speck: float = 0.014
    stray: float = 0.047
    thick: float = 0.014
    area: float = 0.028
    solid: float = 0.85
    most: float = 0.3
    coarsest: float = 0.09
    ruling: float = 0.4
    ruled: int = 6
    bold: float = 1.4
    colours: float = 40.0
    table: float = 1.15
    margin: float = 0.01
    black: float = 0.35
    dot: float = 0.1
    small: float = 0.7
    tight: float = 0.8
    fill: float = 0.86


@dataclass(frozen=True)
class LineFitSettings:
    """Weights of the fit of a model to lines.

    noise: expected distance of a vertex from its place on its line, as a share of the diagonal of the lines. view:
    degrees, by which a face that is drawn from the front is turned. rounds: of matching, camera and latent. first: of
    matching and camera alone.
    """

    noise: float = 0.02
    view: float = 5.0
    rounds: int = 8
    first: int = 3


@dataclass(frozen=True)
class NamingSettings:
    """How strokes find their curves; distances are shares of the diagonal of a face.

    turn: cost of a stroke across a curve. back: weight of the curve's distance from the stroke against the stroke's
    from the curve. shape: of what is left of the distance without a common shift. missing: distance from which on a
    part of a curve just was not drawn. scrap: of a curve's length, what a stroke that draws all of it has at least:
    junctions of lines in pictures leave shorter ones. dearest: cost above which a stroke draws no curve. piece: the
    same for one that continues a curve. covered: share of a stroke that may lie along what was drawn already when it
    continues a curve. seldom: cost of a curve that is drawn beside others, if at all, and of a piece of ``PIECED``.
    unlikely: cost of a curve that a network finds e times less likely. rounds: of a face that follows the names, and
    names.
    """

    turn: float = 0.1
    back: float = 0.3
    shape: float = 3.0
    missing: float = 0.05
    scrap: float = 0.1
    dearest: float = 0.15
    piece: float = 0.05
    covered: float = 0.3
    seldom: float = 0.03
    unlikely: float = 0.01
    rounds: int = 2


@dataclass(frozen=True)
class FollowSettings:
    """How a surface follows lines.

    weight: of a vertex on a line against the shape of the surface around it. still: share of the template's height
    below which nothing has moved: the rounding of a solve. torn: share of triangles that may be turned over; lines that
    turn over more are followed less far. steps: how far, of what was asked for, one after the other. strange: mean
    distance of lines from the likeliest face, percent of the canvas, from which on it is doubtful that they show one:
    unsteady hands' sketches of generated people were 2.4 away at most, a cat's 14. unlikely: root mean square of the
    whitened latent from which on a face is none that is meant: those of six boldly drawn people have 0.5 to 0.9, of
    hands' sketches without names 0.3 to 1.6, and more where strokes were taken for others.
    """

    weight: float = 3.0
    still: float = 1e-6
    torn: float = 0.005
    steps: tuple[float, ...] = (1.0, 0.5, 0.25, 0.0)
    strange: float = 2.5
    unlikely: float = 3.0
