"""Which pixels of a picture show hair: what stands out from skin and background around a face."""

import warnings
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt
from threadpoolctl import threadpool_limits

from caricli.methods.hair.picture_zones import PictureZones
from caricli.methods.hair.settings import MaskSettings
from caricli.structures import Face
from caricli.template.template import Template

SKIN = 0
HAIR = 1
BACKGROUND = 2

_COMPONENTS = (4, 4, 6)  # Gaussians of each class
_SURE = 0.6  # posterior from which on a pixel teaches its class
_FEWEST = 50  # pixels that a colour model takes
_STEP = 7  # every so many-th pixel of a class starts a way
_SMALLEST_STEP = 0.02  # CIELAB a pixel: even a plain way costs a little
_SKIN_STEP = 12.0  # CIELAB that count one nat on the way from the skin, whose wrinkles are edges, too


@dataclass(frozen=True, eq=False)
class HairMask:
    """What is hair in a picture.

    pixels, behind: (H, W) bool, hair, and background. doubt: from 0 to 1, one minus the expected intersection over
    union with what is hair, by the probabilities of the pixels. trusted: whether there is enough of it, and little
    doubt.
    """

    pixels: np.ndarray
    behind: np.ndarray
    doubt: float
    trusted: bool


def mask_hair(
    face: Face,
    template: Template,
    image: np.ndarray,
    settings: MaskSettings = MaskSettings(),  # noqa: B008 (frozen)
) -> HairMask:
    """Tell hair, headwear among it, from skin and background.

    Each class has a mixture of Gaussians over CIELAB; skin starts from inside the landmarks, background from far above
    the chin, hair from what neither explains. A pixel's score is its likelihood, where in the picture such things are,
    and the edges on the shortest way from the class (a geodesic distance, after Criminisi et al. 2008); scores become
    probabilities, a guided filter makes neighbours agree (Hosni et al. 2013), and the mixtures are fitted again.

    face: Face with camera and landmarks. template: of its topology. image: (H, W, 3) uint8.
    Returns HairMask. Raises InputError when the face has no camera or no landmarks.
    """
    zones = PictureZones(face, template, image, settings)
    classes = _Classes(zones, settings)
    for _ in range(settings.rounds - 1):
        if not classes.learn():
            break
    mask = _hanging_together(classes, zones, settings)
    probability = np.where(_near(mask, zones.size * settings.radius), classes.probabilities[..., HAIR], 0)
    probability[zones.features] = mask[zones.features]
    doubt = 1 - np.minimum(mask, probability).sum() / max(np.maximum(mask, probability).sum(), 1e-9)
    enough = mask.sum() >= settings.least * zones.enclosed.sum()
    behind = (classes.probabilities.argmax(-1) == BACKGROUND) & ~mask
    return HairMask(
        zones.enlarged(mask), zones.enlarged(behind, 1.0), float(doubt), bool(enough and doubt <= settings.doubt)
    )


class _Classes:
    """Skin, hair and background: what each looks like, and how likely each pixel is of each (H, W, 3)."""

    def __init__(self, zones: PictureZones, settings: MaskSettings) -> None:
        self.zones = zones
        self.settings = settings
        self.generator = np.random.RandomState(0)
        smooth = cv2.GaussianBlur(cv2.cvtColor(zones.picture, cv2.COLOR_RGB2LAB), (0, 0), max(0.5, 0.004 * zones.size))
        self.lab = smooth.astype(np.float32)
        slopes = [cv2.Sobel(self.lab, cv2.CV_32F, *way, ksize=3) / 8 for way in ((1, 0), (0, 1))]
        self.edges = np.sqrt(np.square(slopes).sum((0, -1)))
        quiet = min(np.quantile(self.edges[zones.behind], settings.quiet), settings.loudest)
        self.quiet = quiet
        self.ways = np.zeros((*zones.shape, 3))
        self.ways[..., SKIN] = self._way(
            zones.inner, np.quantile(self.edges[zones.inner], settings.quiet) / 2, _SKIN_STEP
        )
        self.ways[..., SKIN] = np.where(zones.ears > 0.1, np.minimum(self.ways[..., SKIN], 1.5), self.ways[..., SKIN])
        self.ways[..., BACKGROUND] = self._way(zones.behind, 1.2 * quiet, 4 + quiet / 2)
        self.likelihoods = np.full((*zones.shape, 3), settings.strange)
        self._fit(SKIN, zones.inner)
        self._fit(BACKGROUND, zones.behind)
        self.probabilities = self._probabilities()

    def learn(self) -> bool:
        """Fit the classes to the pixels that are surely theirs, and label all anew; False where none is hair."""
        zones = self.zones
        sure = self.probabilities > _SURE
        hair = sure[..., HAIR]
        core = cv2.erode(hair.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        if core.sum() < _FEWEST:
            return False
        self._fit(HAIR, hair)
        self._fit(BACKGROUND, sure[..., BACKGROUND] & zones.above_chin | zones.behind)
        self._fit(SKIN, sure[..., SKIN] & ~zones.features | zones.inner)
        self.ways[..., HAIR] = self._way(core, self.quiet, _SKIN_STEP)
        self.probabilities = self._probabilities()
        return True

    def _probabilities(self) -> np.ndarray:
        settings = self.settings
        lowest = [settings.lowest, settings.lowest, settings.floor]
        scores = np.maximum(self.likelihoods, lowest) - self.ways + self.zones.prior
        chances = np.exp(scores - scores.max(-1, keepdims=True))
        chances = (chances / chances.sum(-1, keepdims=True)).astype(np.float32)
        radius = max(2, int(settings.radius * self.zones.size))
        epsilon = (255 * settings.smoothness) ** 2
        filtered = [cv2.ximgproc.guidedFilter(self.zones.picture, chances[..., k], radius, epsilon) for k in range(3)]
        return np.clip(np.stack(filtered, -1), 0, 1)

    def _fit(self, kind: int, pixels: np.ndarray) -> None:
        colours = self.lab[pixels]
        if len(colours) < _FEWEST:
            return
        if len(colours) > self.settings.samples:
            colours = colours[self.generator.choice(len(colours), self.settings.samples, replace=False)]
        from sklearn.mixture import GaussianMixture

        mixture = GaussianMixture(_COMPONENTS[kind], reg_covar=self.settings.spread, random_state=0, tol=1e-2)
        # Plain walls have fewer colours than Gaussians; threads for so few wait for each other.
        with warnings.catch_warnings(action="ignore"), threadpool_limits(1):
            mixture.fit(colours)
        self.likelihoods[..., kind] = mixture.score_samples(self.lab.reshape(-1, 3)).reshape(self.zones.shape)

    def _way(self, start: np.ndarray, quiet: float, step: float) -> np.ndarray:
        """(H, W) edges on the shortest way from pixels (H, W) bool: what is above quiet, in steps, up to a bound."""
        from skimage.graph import MCP_Geometric

        costs, _ = MCP_Geometric(np.maximum(self.edges - quiet, 0) + _SMALLEST_STEP).find_costs(
            np.argwhere(start)[::_STEP]
        )
        return np.minimum(costs / step, self.settings.apart)


def _hanging_together(classes: _Classes, zones: PictureZones, settings: MaskSettings) -> np.ndarray:
    """(H, W) bool: the parts of the hair that begin above the brows, next to the head, without speckles and holes."""
    hair = (classes.probabilities.argmax(-1) == HAIR) & ~zones.features
    _, parts = cv2.connectedComponents(hair.astype(np.uint8))
    areas = np.bincount(parts.ravel())
    rows = np.where(hair, np.arange(len(parts))[:, None], len(parts))
    tops = np.full(len(areas), len(parts))
    np.minimum.at(tops, parts.ravel(), rows.ravel())
    close = np.bincount(parts[zones.close], minlength=len(areas)) > 0
    kept = (areas > settings.speckle * zones.size**2) & (tops < zones.brows) & close
    kept[0] = False
    mask = kept[parts]
    holes, labels = cv2.connectedComponents((~mask).astype(np.uint8))
    small = np.bincount(labels.ravel(), minlength=holes) < settings.speckle * zones.size**2 / 4
    return mask | small[labels]


def _near(mask: np.ndarray, reach: float) -> np.ndarray:
    return distance_transform_edt(~mask) <= reach if mask.any() else mask
