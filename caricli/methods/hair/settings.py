"""What hair is tuned by; light to import."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MaskSettings:
    """How hair is told from skin and background. Lengths are shares of the face's size, the longer side of its outline.

    side: pixels, longest side of what is looked at; finer outlines than this are no hair's.
    around, below: how far beyond the outline a picture is looked at, and how far below it.
    core: as far inside the outline a pixel is surely skin. features: as far around brows, eyes and mouth it is not.
    far: as far outside outline and skull a pixel is surely background.
    reach, blur: how far outside hair ends usually, and over what length that is said.
    forehead: height above the brows over which skin is usual.
    ear: how near the projected ears a pixel is likely skin.
    radius, smoothness: of the edge-keeping filter that makes neighbours agree; smoothness in shares of full scale.
    rounds: of colour models and labels in turns.
    samples: pixels that a colour model is fitted to. spread: variance added to it, of CIELAB.
    quiet: quantile of the background's gradients that are no edges; loudest: CIELAB a pixel, the most that it counts.
    strange: log-likelihood that any colour has for hair before hair is known, and floor: for the background, whose
    colour drifts where it is shaded. lowest: for skin and for known hair, so that no single pixel decides.
    apart: the most that edges on the way from a class to a pixel count against it.
    least: share of the face's area that hair fills at least. speckle: of the squared size, smaller parts of the
    mask are dropped.
    bridge: parts that nothing wider than this joins do not hang together.
    doubt: from 0 to 1; with more the mask is not trusted. unsure: the same of what a network takes for hair; with more
    colours alone decide.
    beyond: how far from the border of what a network takes for hair colours are asked. colour: natural logarithm of the
    odds that a colour counts at most there; place: the same of the distance, per face's size. nearby, alike: radius and
    smoothness of the filter there. crumb: of the squared size, smaller parts of what a network takes for hair are
    dropped. gap: per face's size, what is no farther apart is one part of it. over: the least share of hair that is
    before the head.
    """

    side: int = 300
    around: float = 1.0
    below: float = 0.6
    core: float = 0.04
    features: float = 0.02
    far: float = 0.5
    reach: float = 0.3
    blur: float = 0.06
    forehead: float = 0.38
    ear: float = 0.12
    radius: float = 0.03
    smoothness: float = 0.03
    rounds: int = 5
    samples: int = 4000
    spread: float = 4.0
    quiet: float = 0.8
    loudest: float = 5.5
    strange: float = -15.0
    floor: float = -12.8
    lowest: float = -20.0
    apart: float = 8.0
    least: float = 0.035
    speckle: float = 0.02
    bridge: float = 0.03
    doubt: float = 0.4
    unsure: float = 0.3
    beyond: float = 0.1
    colour: float = 4.0
    place: float = 40.0
    nearby: float = 0.02
    alike: float = 0.02
    crumb: float = 0.005
    gap: float = 0.03
    over: float = 0.25


@dataclass(frozen=True)
class ShellSettings:
    """How a shell of hair is built. Lengths are shares of the head's height.

    columns, rows: of the shell's quads, around the head and from the whorl to the edge.
    coarse, fine: rows and columns of directions, for the surface and for its edge.
    tilt: degrees that the whorl is behind the top of the head. deepest: degrees from the whorl to where hair ends at
    most, as seen from the middle of the head.
    least: thickness of hair at least. usual: where nothing is seen of it.
    smooth: how much bending of the surface counts beside its outline; faint: pull towards the usual thickness.
    facets: radians, standard deviation of a blur that leaves no edges of the skin's triangles in the surface.
    bins: directions in which the outline is compared. rounds: of surface and outline in turns.
    hidden: how much a place that the picture does not show counts for the hairline, beside one that it shows.
    steady: how much the hairline's ups and downs count.
    calm: columns over which the hairline is blurred; soft: the same where the picture does not show it.
    even: rows and columns over which distances to it are blurred, so that it is no saw.
    slack: how far outside the mask the outline may be.
    rim: length over which a shell reaches its thickness at least; round_: the same for its thickness; thin: the same
    where nothing is seen of it.
    slope: radians that the hairline falls at most for each around the head, where it is not seen.
    clear: how far hair ends before a bare ear. tuft: how far the hairline goes up and down, where it is not seen.
    under: how far below the skin its edge ends. deep: the same, at most, of what is between its edge and the last hair.
    below: radians below the edge down to which the picture says where hair ends.
    aside: cosine between surface and view from which on it says so in full: what is seen from aside is easily another
    place of the head; with 0 all that is seen does. overlap: least intersection over union of a shell with the hair of
    the picture; with less of it heads are bare at the sides, and all that is seen counts.
    """

    columns: int = 192
    rows: int = 48
    coarse: tuple[int, int] = (48, 64)
    fine: tuple[int, int] = (156, 192)
    tilt: float = 25.0
    deepest: float = 155.0
    least: float = 0.005
    usual: float = 0.04
    smooth: float = 0.02
    faint: float = 0.001
    facets: float = 0.07
    bins: int = 240
    rounds: int = 6
    hidden: float = 0.15
    steady: float = 0.4
    calm: float = 0.8
    soft: float = 8.0
    even: tuple[float, float] = (0.5, 0.8)
    slack: float = 0.03
    rim: float = 0.012
    round_: float = 1.2
    thin: float = 3.0
    slope: float = 2.0
    clear: float = 0.02
    tuft: float = 0.01
    under: float = 0.006
    deep: float = 0.06
    below: float = 0.15
    aside: float = 0.4
    overlap: float = 0.75
