"""Textures of many expressions for the people of a dataset."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np

from caricli.data.build_settings import EXPONENTS
from caricli.data.dataset import SPLITS, Dataset
from caricli.data.regular_face import has_partners, person_of
from caricli.data.texture_set import TextureWriter
from caricli.data.unseen import people_entry
from caricli.data.worker_pool import worker_pool
from caricli.errors import InputError
from caricli.methods.creases.act_textures import ActSettings, Role, TextureSource
from caricli.methods.creases.crease_pattern import KINDS
from caricli.methods.train.stages import Report, unwatched
from caricli.seeds import TextureSeed
from caricli.template.head import load_head

_TURNS = ("train", "test", "train", "train", "validation", "train", "train", "train", "train", "train")
"""Splits that people are taken from in turn."""


@dataclass(frozen=True)
class TextureSetSettings:
    """count: people. expressions: of each, the neutral one among them. size: texels of a side of the chart. seed: of
    everything random."""

    count: int
    expressions: int = 20
    size: int = 128
    seed: int = 0


def build_textures(
    writer: TextureWriter,
    dataset: Dataset,
    settings: TextureSetSettings,
    workers: int | None = None,
    progress: Report = unwatched,
) -> dict[str, float]:
    """Draw people of a generated dataset with expressions and take their textures (expressions paper, section 4.2.2,
    generated instead of gathered). The same settings give the same bytes, whatever the number of workers.

    writer: of an empty folder. workers: processes; None for one per usable core. progress: called with the number of
    people and their total.
    Returns how many people there are, and the share of their textures that pictures showed. Raises InputError where the
    dataset is not one of the open head.
    """
    if not has_partners(dataset):
        raise InputError("expected a dataset that was built, with its people's measures, found one that was imported")
    if dataset.template.topology_id != load_head().template().topology_id:
        raise InputError("expected a dataset of the open head's topology, found another")
    make = partial(TextureSource, dataset.template, settings.size, settings.seed)
    seen = 0.0
    with worker_pool(workers, make) as run:
        for person in run(TextureSource.act, _roles(dataset, settings)):
            writer.add(person)
            seen += float(person.seen.mean())
            progress(writer.count, settings.count)
    writer.finish(
        {
            "settings": asdict(settings),
            "size": settings.size,
            "expressions": settings.expressions,
            "acting": asdict(ActSettings()),
            "creases": {name: asdict(kind) for name, kind in KINDS.items()},
            "topology_id": dataset.template.topology_id,
            "splits": dataset.manifest["splits"],
        }
        | people_entry(dataset)
    )
    return {"people": writer.count, "seen": seen / writer.count}


def _roles(dataset: Dataset, settings: TextureSetSettings) -> Iterator[Role]:
    """Who acts: people of every split in turn, again with another look where there are no more."""
    generator = np.random.default_rng([settings.seed, TextureSeed.ORDER])
    head = load_head()
    present = {name: np.intersect1d(dataset.manifest["splits"][name], dataset.identity) for name in SPLITS}
    order = {name: generator.permutation(people) for name, people in present.items()}
    used = dict.fromkeys(SPLITS, 0)
    exponents = EXPONENTS[: len(dataset.manifest["exponents"])]
    for number in range(settings.count):
        split = _TURNS[number % len(_TURNS)]
        split = split if len(order[split]) else max(order, key=lambda name: len(order[name]))
        identity = int(order[split][used[split] % len(order[split])])
        used[split] += 1
        row = int(np.flatnonzero(dataset.identity == identity)[0])
        level = int(generator.integers(len(exponents)))
        person = person_of(dataset, row, head)
        yield Role(number, identity, person, level + 1, exponents[level], split, settings.expressions)
