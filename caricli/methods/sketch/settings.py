"""What sketches are read by; light to import, because the command line takes its defaults from here."""

from dataclasses import dataclass

COARSE = ("network", "model")
"""How the face of a sketch begins; the first is the default."""

CORNERED = ("brow", "eye_upper", "eye_lower", "eye_fold", "mouth")
"""What the names of curves begin with whose ends everybody draws; others fade out where an artist likes."""


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
class FollowSettings:
    """How a surface follows lines.

    weight: of a vertex on a line against the shape of the surface around it. still: share of the template's height
    below which nothing has moved: the rounding of a solve.
    """

    weight: float = 3.0
    still: float = 1e-6
