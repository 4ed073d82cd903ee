"""Coarse and refined reconstructions of many portraits side by side (portrait paper, section 4.2)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from caricli.data.dataset import Dataset
from caricli.errors import InputError, naming
from caricli.methods.evaluate.portrait_studio import Portrait, PortraitStudio
from caricli.methods.evaluate.reconstruct_portrait import (
    ADJUSTED,
    COARSE,
    METHODS,
    REFINED,
    Reconstruction,
    measure_portrait,
    reconstruct_portrait,
)
from caricli.methods.texture.mask_head import mask_head
from caricli.methods.texture.paint_head import paint_head
from caricli.methods.texture.settings import PaintSettings
from caricli.methods.train.stages import Report, unwatched
from caricli.structures import Rig

RENDERED = "rendered"
PICTURES = "pictures"
"""The two sets of portraits: those of a dataset's meshes, and real ones."""


@dataclass(frozen=True)
class RenderSettings:
    """What of a dataset is portrayed.

    count: test meshes, at most. size: pixels, side of their pictures. noise: of their landmarks, standard deviation of
    a coordinate in percent of the diagonal. seed: of the choice and the portraits.
    """

    count: int = 50
    size: int = 512
    noise: float = 0.3
    seed: int = 0


class RenderedPortraits(Sequence[Portrait]):
    """Portraits of a dataset's test meshes, each drawn when it is asked for."""

    def __init__(self, data: Dataset, settings: RenderSettings) -> None:
        """Choose the meshes. Raises InputError when the dataset has none to test with."""
        rows = np.flatnonzero(data.rows("test"))
        if not len(rows):
            raise InputError("expected meshes in the test split, found none")
        self.data = data
        self.settings = settings
        self.rows = np.sort(np.random.default_rng(settings.seed).permutation(rows)[: settings.count])
        self.studio = PortraitStudio(data.template, settings.size)

    def __len__(self) -> int:
        """How many."""
        return len(self.rows)

    def __getitem__(self, number: Any) -> Any:
        """Draw one; it depends on nothing but the mesh and the seed."""
        row = int(self.rows[number])
        generator = np.random.default_rng([self.settings.seed, row])
        vertices = self.data.vertices[row].astype(np.float64)
        return self.studio.portray(f"mesh {row}", vertices, generator, self.settings.noise)


@dataclass(frozen=True, eq=False)
class PortraitResult:
    """What came of one portrait.

    portrait: Portrait. reconstructions, figures: by METHODS. refused: what methods said that refused it. rigs: textured
    heads by the methods that are painted.
    """

    portrait: Portrait
    reconstructions: dict[str, Reconstruction]
    figures: dict[str, dict]
    refused: dict[str, str]
    rigs: dict[str, Rig]


@dataclass(frozen=True, eq=False)
class PortraitTally:
    """Figures of all portraits so far: by set, name of the portrait and METHODS; and what was refused."""

    figures: dict[str, dict[str, dict[str, dict]]] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)

    def add(self, group: str, result: PortraitResult) -> None:
        """Count a portrait of a set."""
        name = result.portrait.name
        self.figures.setdefault(group, {})[name] = result.figures
        self.refused.update({f"{name}, {method}": reason for method, reason in result.refused.items()})

    def count(self, group: str) -> int:
        """Portraits of a set so far."""
        return len(self.figures.get(group, {}))

    @property
    def summary(self) -> dict:
        """JSON object: means, refinement (see ``gains``), refused, and faces, the figures of all."""
        return {"means": self.means, "refinement": self.gains, "refused": self.refused, "faces": self.figures}

    @property
    def means(self) -> dict[str, dict[str, dict]]:
        """Mean figures by set and METHODS."""
        return {group: mean_figures(list(faces.values())) for group, faces in self.figures.items()}

    @property
    def gains(self) -> dict[str, dict[str, float]]:
        """What refining did to the 3D errors of rendered portraits."""
        return refinement_gains(list(self.figures[RENDERED].values()))


def evaluate_portraits(
    sets: Mapping[str, Sequence[Portrait]], models: Mapping[str, Any], texture: int, report: Report = unwatched
) -> Iterator[tuple[str, PortraitResult]]:
    """Evaluate sets of portraits, one after the other.

    models: see ``reconstruct_portrait``. texture: texels, side of the textures. report: called with portraits done and
    all.
    Yields the name of the set and the result. Raises InputError, NumericsError.
    """
    total = sum(map(len, sets.values()))
    done = 0
    for group, portraits in sets.items():
        for portrait in portraits:
            yield group, evaluate_portrait(portrait, models, texture)
            done += 1
            report(done, total)


def evaluate_portrait(portrait: Portrait, models: Mapping[str, Any], texture: int) -> PortraitResult:
    """Reconstruct, refine and paint one portrait by every method, and measure it.

    models: see ``reconstruct_portrait``. texture: texels, side of the textures.
    Raises InputError, NumericsError.
    """
    with naming(portrait.name):
        reconstructions, refused = reconstruct_portrait(portrait, models)
        template = models["intrinsic"].template
        # One mask for all: with a mask of its own a bad fit would be compared where it is good.
        mask = portrait.mask
        if mask is None:
            mask = mask_head(reconstructions["elastic"].face, portrait.image, portrait.points)
    figures = {}
    rigs = {}
    for name, own in reconstructions.items():
        figures[name] = measure_portrait(own, portrait, template)
        # What equation 7 adjusts is compared by its landmarks alone, as published.
        if name not in ADJUSTED:
            painted = paint_head(own.face, template, portrait.image, mask, PaintSettings(size=texture, hair="none"))
            figures[name]["photometric"] = 100 * painted.error
            rigs[name] = painted.rig
    return PortraitResult(portrait, reconstructions, figures, refused, rigs)


def mean_figures(faces: list[dict[str, dict]]) -> dict[str, dict]:
    """Means, by METHODS, of figures by METHODS, over the faces that have them."""
    names = [name for name in METHODS if any(name in face for face in faces)]
    return {name: _mean([face[name] for face in faces if name in face]) for name in names}


def _mean(rows: list[dict]) -> dict:
    keys = dict.fromkeys(key for row in rows for key in row)
    columns = {key: [row[key] for row in rows if key in row] for key in keys}
    return {key: _mean(c) if isinstance(c[0], dict) else float(np.mean(c)) for key, c in columns.items()}


def refinement_gains(faces: list[dict[str, dict]]) -> dict[str, dict[str, float]]:
    """What refining did to the 3D errors, of faces that were refined. faces: figures by METHODS.

    Returns by coarse method faces, better (on how many it is lower), before and after (means).
    """
    gains = {}
    for name in COARSE:
        pairs = [(face[name]["shape"], face[name + REFINED]["shape"]) for face in faces if name + REFINED in face]
        if pairs:
            before, after = np.array(pairs).T
            count = {"faces": len(pairs), "better": int((after < before).sum())}
            gains[name] = count | {"before": float(before.mean()), "after": float(after.mean())}
    return gains
