"""What reconstructions are tuned by; light to import, because the command line takes its defaults from here."""

from dataclasses import dataclass

METHODS = ("intrinsic", "latent")
"""Ways to fit landmarks: elastically, or inside the model; the first is the default."""

COARSE = ("elastic", "network", "morphable")
"""How a head may begin that is made of a picture."""


@dataclass(frozen=True)
class IntrinsicSettings:
    """Weights of the elastic fit.

    strength: of the landmarks against the surface; 10 meets them to about a tenth of a percent of their diagonal.
    misfit: expected distance of a landmark from where the model alone puts it, in root mean squares of these distances:
    the farther a drawing is from every face of the model, the less it tells of what it does not show.
    least: such a distance at least, as a share of the landmarks' diagonal: what the model leaves out of usual faces.
    step: share of the way to the likeliest latent that a round goes.
    rounds: of camera, outline and latent; after ten of them nothing moves that is seen.
    again: further rounds, where something was found in the picture.
    follow: of the likeliest latent against what a correction makes of the surface, in mean squares of its features.
    turns: of correction and latent after the rounds.
    corrections: of the surface at the end, each with the outline and the neck that the one before it left.
    exact: spread of a landmark at which it pulls the surface half as strongly as an exact one, as a share of the
    landmarks' diagonal; of brows, nose, eyes and mouth larger, by the square of how much farther than usual a face is
    from the model's.
    Strength, misfit, follow and turns were set with six real drawings in sight, see benchmarks/RESULTS.md.
    """

    strength: float = 10.0
    misfit: float = 1.2
    least: float = 0.008
    step: float = 0.7
    rounds: int = 10
    again: int = 5
    follow: float = 5e-5
    turns: int = 3
    corrections: int = 3
    exact: float = 0.002


@dataclass(frozen=True)
class LatentSettings:
    """Weights of the fit inside a model.

    noise: expected error of a landmark as a share of the landmarks' diagonal; set with six real drawings in sight.
    rounds: of camera, outline and latent in turns, from far away.
    refinements: steps on camera and latent together after them.
    """

    noise: float = 0.0125
    rounds: int = 4
    refinements: int = 6


@dataclass(frozen=True)
class OutlierSettings:
    """How landmarks that are far off lose their weight (Geman and McClure).

    tolerance: usual errors that an error may have before its weight is a quarter.
    floor: smallest usual error, as a share of the diagonal: a fit that meets most landmarks must not drop the others.
    least: weight that the worst landmark keeps, so that every system stays solvable.
    first_round: from which on weights are trusted; before it the camera explains most of the errors.
    """

    tolerance: float = 4.0
    floor: float = 0.02
    least: float = 1e-4
    first_round: int = 2


@dataclass(frozen=True)
class DampingSettings:
    """How careful the steps inside a model are (Levenberg and Marquardt).

    start: damping of the first step, of the system's diagonal: nearly a full step.
    ease: divides it after a step that helped; tighten: multiplies it after one that did not.
    tries: steps of a round before it leaves all as it is.
    """

    start: float = 1e-3
    ease: float = 3
    tighten: float = 5
    tries: int = 6


@dataclass(frozen=True)
class MorphableWeights:
    """Weights of equation 6 of the portrait paper; their common scale is that of ``LatentSettings.noise``.

    identity: of who it is, above zero. expression: of what the face does, above zero; both as published.
    """

    identity: float = 1.2
    expression: float = 1.0


@dataclass(frozen=True)
class RefineSettings:
    """How a face is aligned with its landmarks; shares are of the diagonal of the given landmarks.

    weight: of a landmark against the shape of the surface (the paper's lambda).
    laplacian: how neighbours count: "cotangent", by the angles between them, or "uniform", all the same, as published.
    rounds: how often the surface's rotations are estimated; 0 keeps every detail upright, as published.
    farthest: share, mean distance of landmarks that can be those of the same picture.
    crossed: share, how far lids may have passed each other, or two landmarks may want one vertex apart: a slip of the
    hand. lips_crossed: the same for lips, which are drawn as one thick line.
    same: share below which two landmarks are in one place.
    still: share of the head's height below which nothing has moved: the rounding of a solve.
    """

    weight: float = 1.0
    laplacian: str = "cotangent"
    rounds: int = 4
    farthest: float = 0.25
    crossed: float = 0.02
    lips_crossed: float = 0.06
    same: float = 1e-4
    still: float = 1e-6


@dataclass(frozen=True)
class SnapSettings:
    """How eye landmarks go to the parsed eyes.

    farthest: share of an eye's width that a landmark moves at most; farther away is the other eye, or none.
    """

    farthest: float = 0.5


@dataclass(frozen=True)
class EvidenceSettings:
    """How a picture is looked at; lengths are pixels of a window in which the landmarks have a common diagonal.

    diagonal: of the landmarks in the window. reach: how far around them it goes, as a share of that. bins: of the
    histogram of colours, along L, a and b. skin_spread, rest_spread: bins, standard deviations, by which the colours of
    the skin and of the rest are spread: ears lie in other light than cheeks. rare: share of a colour that was never
    seen. certain: logarithm of the odds that counts as sure. blur, edge_blur: standard deviations, before colours and
    edges are read. margin: around eyes, brows and mouth. line: half the width of a drawn outline. label: how
    much it counts beside colours that a network takes something for an ear, or for no part of a face; label_blur:
    standard deviation, before what is an ear by the network is read.
    """

    diagonal: float = 220.0
    reach: float = 0.75
    bins: tuple[int, int, int] = (16, 32, 32)
    skin_spread: tuple[float, float, float] = (2.0, 1.5, 1.5)
    rest_spread: tuple[float, float, float] = (1.0, 1.0, 1.0)
    rare: float = 2e-6
    certain: float = 3.0
    blur: float = 1.0
    edge_blur: float = 1.2
    margin: int = 4
    line: int = 3
    label: float = 0.5
    label_blur: float = 2.0


@dataclass(frozen=True)
class EarSettings:
    """How ears are looked for.

    spread: standard deviations of an ear's numbers from those of the fitted head, see ``EarShapes``. likeness: of those
    of the second ear from those of the first. step: of the search, shares of the ear's height and logarithms.
    edge, contrast, colour: weights of the edge along the rim, of the difference in colour across it, and of the colour
    inside. strong: change of colour, levels a pixel, that is a clear edge. near, far: pixels from the rim, where
    colours are read. trust: of a score against the deviations. growth: power of the ear's size by which it counts.
    tries: ears at first; kept, children: of every round, how many go on with how many changes; rounds; calm: factor of
    the steps from round to round. hidden_from: degrees by which an ear is turned away until the face may hide it.
    """

    spread: tuple[float, ...] = (0.15, 1.0, 0.35, 0.3, 0.3, 0.2, 0.2)
    likeness: tuple[float, ...] = (0.15, 0.5, 0.15, 0.1, 0.2, 0.1, 0.1)
    step: tuple[float, ...] = (0.06, 0.2, 0.15, 0.1, 0.12, 0.06, 0.06)
    edge: float = 0.8
    contrast: float = 1.0
    colour: float = 0.5
    strong: float = 6.0
    near: float = 3.0
    far: float = 6.6
    trust: float = 12.0
    growth: float = 0.3
    tries: int = 3000
    kept: int = 60
    children: int = 10
    rounds: int = 4
    calm: float = 0.6
    hidden_from: float = 8.0


@dataclass(frozen=True)
class TrustSettings:
    """When an ear is believed.

    least: colour inside, contrast and edge, see ``ear_shapes.agreement``, below which it is none. rise: how much more
    of them makes it sure. vague: pixels of the window, standard deviation of a landmark that halves its confidence.
    small: heights of the fitted ear, below which confidence falls. inherited: share of an ear's confidence that one has
    which is taken from it, and below which it is. around: distance, in those of its outline from its middle, at which
    is what may hide more of an ear; upper: share of the outline, from above, where that counts; bare: power of the
    share that nothing hides, by which confidence falls.
    """

    least: tuple[float, float, float] = (0.05, 0.3, 0.4)
    rise: tuple[float, float, float] = (0.3, 0.4, 0.3)
    vague: float = 6.0
    small: float = 0.8
    inherited: float = 0.5
    around: float = 1.25
    upper: float = 0.66
    bare: float = 2.0


@dataclass(frozen=True)
class SilhouetteSettings:
    """How the end of a head is looked for, in the window at half its size.

    frame: pixels along the border that show what is behind the head. rounds: of GrabCut. along: first, last and step of
    the rays, in distances of the fitted forehead. sides, change: steps on both sides of an end, and by how many levels
    of Lab their means differ at least. wedge: what belongs to a ray, aside per length. limits: of the ratio of a head's
    height to the fitted one's: farther pulled, foreheads get a ridge above the brows. power: of the ratio by which the
    forehead moves. trust: confidence where all rays agree; vague: difference of their ratios that halves it.
    """

    frame: int = 3
    rounds: int = 3
    along: tuple[float, float, float] = (0.3, 2.5, 0.01)
    sides: int = 8
    change: float = 12.0
    wedge: float = 0.08
    limits: tuple[float, float] = (0.85, 1.2)
    power: float = 0.7
    trust: float = 0.4
    vague: float = 0.15
