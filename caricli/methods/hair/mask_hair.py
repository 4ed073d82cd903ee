"""Which pixels of a picture show hair: what stands out from skin and background around a face."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from caricli.methods.hair.colour_mixture import AskedColours, ColourMixture
from caricli.methods.hair.picture_zones import PictureZones
from caricli.methods.hair.settings import MaskSettings
from caricli.render.in_parallel import do_in_parallel
from caricli.render.pixels.distance_to import exact_distance_to
from caricli.render.pixels.widen_mask import widen_mask
from caricli.structures import Face
from caricli.template.template import Template

SKIN = 0
HAIR = 1
BACKGROUND = 2

_COMPONENTS = (4, 4, 6)  # Gaussians of each class
_SURE = 0.6  # posterior from which on a pixel teaches its class
_APART = 0.5  # of hair's usual distance from the background: what is nearer does not teach how hair looks
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


def mask_hair(face: Face, template: Template, image: np.ndarray) -> HairMask:
    """Tell hair, headwear among it, from skin and background.

    Each class has a mixture of Gaussians over CIELAB; skin starts from inside the landmarks, background from far above
    the chin, hair from what neither explains. A pixel's score is its likelihood, where in the picture such things are,
    and the edges on the shortest way from the class (a geodesic distance, after Criminisi et al. 2008); scores become
    probabilities, a guided filter makes neighbours agree (Hosni et al. 2013), and the mixtures are fitted again.

    face: Face with camera and landmarks. template: of its topology. image: (H, W, 3) uint8.
    Returns HairMask, an empty one where the picture shows no skin within the landmarks, as in a profile, or nothing
    around the head. Raises InputError when the face has no camera or no landmarks.
    """
    settings = MaskSettings()
    zones = PictureZones(face, template, image, settings)
    if not (zones.inner.any() and zones.behind.any()):
        nowhere = np.zeros(image.shape[:2], bool)
        return HairMask(nowhere, nowhere, 1.0, False)
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
        self.asked = AskedColours(smooth.astype(np.float32))
        slopes = [cv2.Sobel(self.asked.colours, cv2.CV_32F, *way, ksize=3) / 8 for way in ((1, 0), (0, 1))]
        gradient = np.sqrt(np.square(slopes).sum((0, -1)))
        width = 2 * max(2, round(settings.radius * zones.size)) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
        self.edges = cv2.morphologyEx(gradient, cv2.MORPH_TOPHAT, disc)
        quiet = min(np.quantile(self.edges[zones.behind], settings.quiet), settings.loudest)
        self.quiet = quiet
        self.ways = np.zeros((*zones.shape, 3))
        self.ways[..., SKIN] = self._way(
            zones.inner, np.quantile(self.edges[zones.inner], settings.quiet) / 2, _SKIN_STEP
        )
        self.ways[..., SKIN] = np.where(zones.ears > 0.1, np.minimum(self.ways[..., SKIN], 1.5), self.ways[..., SKIN])
        self.ways[..., BACKGROUND] = self._way(zones.behind, 1.2 * quiet, 4 + quiet / 2)
        self.likelihoods = np.full((*zones.shape, 3), settings.strange)
        self._fit({SKIN: zones.inner, BACKGROUND: zones.behind})
        self.probabilities = self._probabilities()

    def learn(self) -> bool:
        """Fit the classes to the pixels that are surely theirs, and label all anew; False where none is hair."""
        zones = self.zones
        sure = self.probabilities > _SURE
        hair = sure[..., HAIR]
        teaching = hair & zones.above_brows
        away = self.ways[..., BACKGROUND]
        if teaching.any():
            teaching &= away > _APART * np.median(away[teaching])
        core = ~widen_mask(~hair, 1)
        if core.sum() < _FEWEST:
            return False
        behind = sure[..., BACKGROUND] & zones.above_chin | zones.behind
        self._fit({HAIR: teaching, BACKGROUND: behind, SKIN: sure[..., SKIN] & ~zones.features | zones.inner})
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

    def _fit(self, examples: Mapping[int, np.ndarray]) -> None:
        """Fit classes to pixels (H, W) bool of theirs."""
        jobs = []
        for kind, pixels in examples.items():
            colours = self.asked.colours[pixels]
            if len(colours) > self.settings.samples:
                colours = colours[self.generator.choice(len(colours), self.settings.samples, replace=False)]
            if len(colours) >= _FEWEST:
                jobs.append(partial(self._ask, kind, colours))
        do_in_parallel(*jobs)

    def _ask(self, kind: int, colours: np.ndarray) -> None:
        mixture = ColourMixture(colours, _COMPONENTS[kind], self.settings.spread)
        self.likelihoods[..., kind] = self.asked.log_likelihoods(mixture)

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
    hair &= ~_bridges(hair, zones.above_brows, round(settings.bridge * zones.size))
    parts, areas = _parts(hair)
    above = np.bincount(parts[zones.above_brows], minlength=len(areas)) > 0
    close = np.bincount(parts[zones.close], minlength=len(areas)) > 0
    kept = (areas > settings.speckle * zones.size**2) & above & close
    kept[0] = False
    mask = kept[parts]
    holes, areas = _parts(~mask)
    return mask | (areas < settings.speckle * zones.size**2 / 4)[holes]


def _bridges(hair: np.ndarray, above: np.ndarray, width: int) -> np.ndarray:
    """(H, W) bool: what of a mask is thinner than a width and leads from what begins above to what does not.

    So a halo leads from hair to a collar.
    """
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width | 1, width | 1))
    thick = cv2.morphologyEx(hair.astype(np.uint8), cv2.MORPH_OPEN, disc) > 0
    parts, areas = _parts(thick)
    begins = np.bincount(parts[above], minlength=len(areas)) > 0
    thin, areas = _parts(hair & ~thick)
    leads = np.ones(len(areas), bool)
    for ends in (thick & begins[parts], thick & ~begins[parts]):
        leads &= np.bincount(thin[widen_mask(ends, 1)], minlength=len(areas)) > 0
    leads[0] = False
    return leads[thin]


def _parts(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of a mask that hang together: (H, W) their numbers, 0 outside, and their areas."""
    _, parts = cv2.connectedComponents(mask.astype(np.uint8))
    return parts, np.bincount(parts.ravel())


def _near(mask: np.ndarray, reach: float) -> np.ndarray:
    return exact_distance_to(mask) <= reach if mask.any() else mask
