"""What the fit to a picture's colours is tuned by."""

from dataclasses import dataclass

from caricli.methods.morphable.energy import EnergyWeights

_PUBLISHED = EnergyWeights()


@dataclass(frozen=True)
class PhotometricSettings:
    """Weights and steps of the photometric fit.

    photometric: of the mean squared difference of sRGB over the face against the regularisation of the shape, as
    published. albedo: of the squared coefficients of the colours, which are in standard deviations; with the published
    1.2e-3, for another scale, colours take the shading from the shape.
    light: of squared harmonics, hardly any, which keeps them finite where a face is seen from one side.
    diagonal: pixels of the landmarks in the window that is compared. margin: around them, as a share of it.
    colours: steps on colours and light alone, rounds: on everything, at most. settled: a step that lowers the energy by
    a smaller share is the last one.
    outlier: usual differences that a pixel's may have before its weight is a quarter. floor: smallest usual difference.
    least: pixels of skin without which nothing is told.
    """

    photometric: float = _PUBLISHED.photometric / _PUBLISHED.regularisation
    albedo: float = 1.0
    light: float = 1e-3
    diagonal: float = 128.0
    margin: float = 0.15
    colours: int = 3
    rounds: int = 8
    settled: float = 2e-3
    outlier: float = 3.0
    floor: float = 0.02
    least: int = 200
