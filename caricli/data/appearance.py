"""What is drawn at random of a head's colours before anything is painted."""

from dataclasses import dataclass

import numpy as np

STYLES = ("soft", "flat")
"""Painted softly, or in the clear areas of a cartoon."""

DARK_HAIR = np.array([1.15, 1.5, 1.9])
RED_HAIR = np.array([0.1, 0.75, 1.6])
"""How much of linear red, green and blue a unit of either pigment of hair absorbs."""

WAVES = 24
"""Waves that the mottled skin is made of."""


@dataclass(frozen=True)
class AppearanceSettings:
    """How often heads have what not all of them have: chances from 0 to 1.

    flat: a cartoon's clear areas. grey: hair. dyed: a cartoon's hair of any colour. stubble, makeup, freckles. hair: on
    the scalp.
    """

    flat: float = 0.4
    grey: float = 0.1
    dyed: float = 0.12
    stubble: float = 0.35
    makeup: float = 0.4
    hair: float = 0.75
    freckles: float = 0.3


_CHANCES = AppearanceSettings()


@dataclass(frozen=True, eq=False)
class Appearance:
    """What is drawn at random before anything is painted.

    melanin, blood: of the skin. hair: linear RGB. scalp, stubble, flush (of cheeks, nose and ears), lips, lash,
    shadow: strengths from 0 to 1. lipstick: linear RGB, or None. brow: width and density. spots: freckles. waves: of
    the mottled skin, wave vectors, phases. flat: a cartoon's clear areas. seed: of the places of the freckles.
    """

    flat: bool
    melanin: float
    blood: float
    hair: np.ndarray
    scalp: float
    stubble: float
    flush: tuple[float, ...]
    lips: float
    lipstick: np.ndarray | None
    lash: float
    shadow: float
    brow: tuple[float, ...]
    spots: int
    waves: tuple[np.ndarray, np.ndarray]
    seed: int


def random_appearance(generator: np.random.Generator, style: str | None = None) -> Appearance:
    """Draw an Appearance. style: of STYLES, or None for either."""
    flat = generator.random() < _CHANCES.flat if style is None else style == "flat"
    melanin = generator.beta(1, 1.9)
    blood = generator.uniform(0.02, 0.35)
    hair = _random_hair(generator, melanin, flat)
    bearded = generator.random() < _CHANCES.stubble
    painted = generator.random() < _CHANCES.makeup and not bearded
    lipstick = np.array([generator.uniform(0.3, 0.6), *generator.uniform([0.03, 0.03], [0.1, 0.14])])
    return Appearance(
        flat=bool(flat),
        melanin=float(melanin),
        blood=float(blood),
        hair=hair,
        scalp=float(generator.random() < _CHANCES.hair),
        stubble=float(bearded * generator.uniform(0.15, 0.75)),
        flush=tuple(generator.uniform([0.1, 0.1, 0.15], [0.6, 0.5, 0.5]) * (0.8 if flat else 1)),
        lips=float(generator.uniform(0.35, 0.9)),
        lipstick=lipstick if painted else None,
        lash=float(generator.uniform(0.5, 1) if flat else generator.uniform(0.3, 0.9)),
        shadow=float(painted * generator.uniform(0, 0.8)),
        brow=tuple(generator.uniform([0.035, 0.55], [0.07, 0.95]) * np.array([1.1 if flat else 1, 1])),
        spots=int((generator.random() < _CHANCES.freckles) * generator.integers(25, 60 if flat else 160)),
        waves=(generator.normal(0, 9, (WAVES, 3)), generator.uniform(0, 2 * np.pi, WAVES)),
        seed=int(generator.integers(2**32)),
    )


def _random_hair(generator: np.random.Generator, melanin: float, flat: bool) -> np.ndarray:
    # Dark skin seldom goes with fair hair.
    dark = generator.uniform(0.25, 2.8) + 1.6 * melanin
    hair = 0.8 * np.exp(-dark * DARK_HAIR - generator.beta(1, 4) * 1.6 * RED_HAIR)
    if generator.random() < _CHANCES.grey:
        hair += (0.32 - hair) * generator.uniform(0.4, 0.95)
    if flat and generator.random() < _CHANCES.dyed:
        hair = generator.dirichlet([2, 2, 2]) * 0.6
    return hair
