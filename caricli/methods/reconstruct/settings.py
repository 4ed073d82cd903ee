"""What reconstructions are tuned by; light to import, because the command line takes its defaults from here."""

from dataclasses import dataclass

METHODS = ("intrinsic", "latent")
"""Ways to fit landmarks: elastically, or inside the model; the first is the default."""


@dataclass(frozen=True)
class IntrinsicSettings:
    """Weights of the elastic fit.

    strength: of the landmarks against the surface; 10 meets them to about a tenth of a percent of their diagonal.
    misfit: expected distance of a landmark from where the model alone puts it, in root mean squares of these distances:
    the farther a drawing is from every face of the model, the less it tells of what it does not show.
    least: such a distance at least, as a share of the landmarks' diagonal: what the model leaves out of usual faces.
    step: share of the way to the likeliest latent that a round goes.
    rounds: of camera, outline and latent; after ten of them nothing moves that is seen.
    corrections: of the surface, each with the outline and the neck that the one before it left.
    """

    strength: float = 10.0
    misfit: float = 1.2
    least: float = 0.008
    step: float = 0.7
    rounds: int = 10
    corrections: int = 3

    @property
    def iterations(self) -> int:
        """All rounds of a fit."""
        return self.rounds


@dataclass(frozen=True)
class LatentSettings:
    """Weights of the fit inside a model.

    noise: expected error of a landmark as a share of the landmarks' diagonal.
    rounds: of camera, outline and latent in turns, from far away.
    refinements: steps on camera and latent together after them.
    """

    noise: float = 0.0125
    rounds: int = 4
    refinements: int = 6

    @property
    def iterations(self) -> int:
        """All rounds of a fit."""
        return self.rounds + self.refinements


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
    farthest: share, mean distance of landmarks that can be those of the same picture.
    crossed: share, how far lids may have passed each other, or two landmarks may want one vertex apart: a slip of the
    hand. lips_crossed: the same for lips, which are drawn as one thick line.
    same: share below which two landmarks are in one place.
    still: share of the head's height below which nothing has moved: the rounding of a solve.
    """

    weight: float = 1.0
    laplacian: str = "cotangent"
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
