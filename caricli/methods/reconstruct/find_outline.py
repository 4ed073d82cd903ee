"""Landmarks beyond the 68 that a picture shows: ears and forehead."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.methods.reconstruct.ear_shapes import EarShapes, agreement
from caricli.methods.reconstruct.head_silhouette import find_forehead
from caricli.methods.reconstruct.outline import SIDES, Outline
from caricli.methods.reconstruct.picture_evidence import PictureEvidence, picture_evidence
from caricli.methods.reconstruct.settings import EarSettings, TrustSettings
from caricli.structures import Face
from caricli.structures.detection import ParsedPicture
from caricli.structures.landmarks import COUNT, EXTRA, FOREHEAD
from caricli.template.template import Template

_EARS = EarSettings()
_TRUST = TrustSettings()


def find_outline(
    face: Face, template: Template, points: np.ndarray, picture: ParsedPicture, generator: np.random.Generator
) -> Outline:
    """Find ears and forehead of a face in its picture.

    An ear is an outline of skin's colours before other colours, with edges along it, at the side of the face; of all
    that this head could have, larger or smaller, higher or lower, the most likely, found by drawing them at random and
    changing the best. The ear that is turned towards the camera comes first, and the other is expected to be like it:
    where it does not show, it is taken from the first. A wrong ear is worse than an average one, so what does not stand
    out clearly has little confidence, or none. The forehead follows from where the head ends, see ``find_forehead``.

    face: Face with the camera of the picture, as the 68 landmarks alone fit it. template: of its topology, see
    ``outline.can_find_outline``. points: (68, 2) pixels. picture: ParsedPicture. generator: of the draws.
    Raises InputError when the landmarks are outside the picture.
    """
    window = picture_evidence(face, points, picture)
    shapes = {side: EarShapes(face, template, side, window) for side in SIDES}
    places = np.full((len(EXTRA), 2), np.nan)
    confidence = np.zeros(len(EXTRA))
    forehead = np.array(FOREHEAD) - COUNT
    places[forehead], confidence[forehead] = find_forehead(face, template, points, window)
    ear = None
    for side in sorted(SIDES, key=lambda side: shapes[side].away):
        ear = _EarSearch(shapes[side], window, ear).find(generator)
        rows = np.array(SIDES[side]) - COUNT
        places[rows] = window.to_picture(shapes[side].landmarks(ear.numbers[None])[0])
        confidence[rows] = ear.confidence
    places[confidence == 0] = np.nan
    return Outline(places, confidence)


@dataclass(frozen=True, eq=False)
class _Ear:
    """numbers: (7,) of EarShapes. unlike: (7,) by which they differ from those of the fitted ear. confidence: (3,)."""

    numbers: np.ndarray
    unlike: np.ndarray
    confidence: np.ndarray


class _EarSearch:
    """Looks for the ear of one side; mean (7,) and spread (7,) say what is expected."""

    def __init__(self, shapes: EarShapes, window: PictureEvidence, other: _Ear | None) -> None:
        """other: the ear of the other side, which this one is like."""
        self.shapes = shapes
        self.window = window
        self.other = other
        self.mean = shapes.fitted
        self.spread = np.array(_EARS.spread)
        if other is not None:
            own = self.spread**-2.0
            alike = np.array(_EARS.likeness) ** -2.0
            self.mean = self.mean + other.unlike * alike / (own + alike)
            self.spread = (own + alike) ** -0.5

    def find(self, generator: np.random.Generator) -> _Ear:
        """The most likely ear, or one like the other where that is much surer; less sure where hair may hide of it."""
        ear = self._likeliest(generator)
        return replace(ear, confidence=ear.confidence * self.bare(ear.numbers) ** _TRUST.bare)

    def _likeliest(self, generator: np.random.Generator) -> _Ear:
        ears, likelihood = self.draw(generator)
        share = np.exp(likelihood - likelihood.max())
        landmarks = self.shapes.landmarks(ears)
        mean = np.average(landmarks, axis=0, weights=share)
        variance = np.average(((landmarks - mean) ** 2).sum(-1), axis=0, weights=share)
        numbers = ears[likelihood.argmax()]
        confidence = self.clearness(numbers) / (1 + variance / _TRUST.vague**2)
        other = self.other
        if other is not None and confidence.mean() < _TRUST.inherited * other.confidence.mean():
            return _Ear(self.shapes.fitted + other.unlike, other.unlike, _TRUST.inherited * other.confidence)
        return _Ear(numbers, numbers - self.shapes.fitted, confidence)

    def draw(self, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Likely ears (N, 7), and logarithms (N,) of how likely they are."""
        ears = self.mean + self.spread * generator.normal(size=(_EARS.tries, len(self.mean)))
        ears[0] = self.shapes.fitted
        ears = self.shapes.limited(ears)
        likelihood = self.likelihood(ears)
        for number in range(_EARS.rounds):
            kept = np.argsort(-likelihood, kind="stable")[: _EARS.kept]
            parents = np.repeat(ears[kept], _EARS.children, axis=0)
            steps = np.array(_EARS.step) * _EARS.calm**number * generator.normal(size=parents.shape)
            children = self.shapes.limited(parents + steps)
            ears = np.concatenate([ears[kept], children])
            likelihood = np.concatenate([likelihood[kept], self.likelihood(children)])
        return ears, likelihood

    def likelihood(self, ears: np.ndarray) -> np.ndarray:
        """(N,) logarithms, of ears (N, 7)."""
        inner, outer, edge = agreement(self.shapes, ears, self.window, _EARS)
        score = _EARS.edge * edge + _EARS.contrast * (inner - outer) / 2 + _EARS.colour * inner
        unusual = (((ears - self.mean) / self.spread) ** 2).sum(1) / 2
        return _EARS.trust * score * self.shapes.sizes(ears) ** _EARS.growth - unusual

    def bare(self, ear: np.ndarray) -> float:
        """Share of what is around the upper part of an ear (7,) that is neither hair nor a hat, from 0 to 1."""
        rim = self.shapes.rims(ear[None])[0]
        around = rim.mean(0) + _TRUST.around * (rim - rim.mean(0))
        upper = np.rint(around[: int(_TRUST.upper * len(rim))]).astype(int)
        hiding = self.window.hiding
        height, width = hiding.shape
        return float(1 - hiding[upper[:, 1].clip(0, height - 1), upper[:, 0].clip(0, width - 1)].mean())

    def clearness(self, ear: np.ndarray) -> float:
        """How clearly an ear (7,) stands out, from 0 to 1."""
        inner, outer, edge = (values[0] for values in agreement(self.shapes, ear[None], self.window, _EARS))
        clear = (np.array([inner, inner - outer, edge]) - _TRUST.least) / _TRUST.rise
        # What looks like a small ear may be the part of one that hair leaves free.
        whole = min(self.shapes.sizes(ear[None])[0] / _TRUST.small, 1) ** 2
        return float(np.clip(clear, 0, 1).prod() * whole)
