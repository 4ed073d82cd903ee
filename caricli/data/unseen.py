"""Tests with people whom no model has seen: the same seed gives the same people to every dataset."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from typing import TYPE_CHECKING, Any

import numpy as np

from caricli.data.dataset import SPLITS, Dataset
from caricli.data.regular_face import has_partners
from caricli.errors import InputError, naming
from caricli.structures import SeenPeople
from caricli.structures.seen_people import BY, MAKING, MESHES
from caricli.structures.seen_people import KEY as PEOPLE

if TYPE_CHECKING:
    from caricli.data.picture_set import PictureSet
    from caricli.data.texture_set import TextureSet

DIGITS = 12
"""Hexadecimal ones of a fingerprint: among a million people two have the same by a chance of one in five hundred."""

STEP = 1e-4
"""Of what people are made of, all of it between -2 and 2: what machines make of the same draw differs by less."""

MEASURED_STEP = 1e-4
"""Metres, of what meshes measure: the same mesh in files of other units differs by less."""


@dataclass(frozen=True, eq=False)
class UnseenData:
    """A dataset whose splits name nobody whom models have seen before.

    data: Dataset. test: people of its test split; of: how many there were. note: one line about them, or None where
    there is nothing to say.
    """

    data: Dataset
    test: int
    of: int
    note: str | None

    @property
    def figures(self) -> dict[str, dict[str, int]]:
        """JSON object for a report."""
        return {"test_people": {"unseen": self.test, "of": self.of}}


def fingerprints(data: Dataset, split: str, older: bool = False) -> dict[int, frozenset[str]]:
    """What tells everybody of a split from others, whatever the number in the dataset.

    A generated person is what the head was made of, so every expression and exaggeration is the same person. An
    imported one is the set of meshes, by what they measure, whatever unit their files are in; one shared mesh is
    enough. older: also give the marks of imported meshes that recipes of before hold, of their very vertices.
    """
    digests: dict[int, set[str]] = {int(person): set() for person in data.manifest["splits"][split]}
    rows = np.flatnonzero(data.rows(split))
    if has_partners(data):
        # All meshes of a person are made of the same.
        rows = rows[np.unique(data.identity[rows], return_index=True)[1]]
    kinds = [_making] if has_partners(data) else [_measures, _shape] if older else [_measures]
    for row, mark in product(rows, kinds):
        digests[int(data.identity[row])].add(hashlib.sha256(mark(data, int(row))).hexdigest()[:DIGITS])
    return {person: frozenset(marks) for person, marks in digests.items()}


def seen_people(data: Dataset) -> SeenPeople:
    """Whom a training on a Dataset sees."""
    uses = ("train", "validation")
    train, validation = (frozenset().union(*fingerprints(data, use).values()) for use in uses)
    return SeenPeople(train, validation, frozenset({_told_by(data)}))


def everybody(datasets: Sequence[Dataset]) -> SeenPeople:
    """Whom a training on datasets sees. Raises InputError where one trains with somebody whom another tries."""
    return replace(different_people([_marks(data) for data in datasets]), by=frozenset(map(_told_by, datasets)))


def different_people(marks: Sequence[Mapping[str, frozenset[str]]]) -> SeenPeople:
    """Whom a training sees on datasets, or on folders made of such, whose people have these fingerprints by split.

    Raises InputError where one trains with somebody whom another tries.
    """
    train, validation, test = (frozenset().union(*(each.get(split, ()) for each in marks)) for split in SPLITS)
    both = len(train & (validation | test))
    if both:
        raise InputError(
            f"expected datasets of different people, found {both} whom one trains with and another validates or tests "
            "with; those of one --seed share people"
        )
    return SeenPeople(train, validation)


def people_entry(data: Dataset) -> dict[str, Any]:
    """What the manifest of a folder made of a dataset says of its people: fingerprints between blanks, by split, and
    what these are of, as recipes say it."""
    by = {} if _told_by(data) == MAKING else {BY: _told_by(data)}
    return {PEOPLE: {split: " ".join(sorted(marks)) for split, marks in _marks(data).items()}} | by


def told_people(manifest: Mapping[str, Any]) -> dict[str, frozenset[str]]:
    """The fingerprints of a manifest by split, of an older one none. Raises InputError for what is no such entry."""
    people = manifest.get(PEOPLE, {})
    if not isinstance(people, dict) or not all(isinstance(marks, str) for marks in people.values()):
        raise InputError(f"{PEOPLE}: expected fingerprints by split, found others")
    return {split: frozenset(marks.split()) for split, marks in people.items()}


def training_entry(sets: Sequence["PictureSet | TextureSet"]) -> dict[str, Any]:
    """What the recipe of a training on folders made of datasets says of its people: nothing where a folder does not.

    Raises InputError where one trains with somebody whom another tries.
    """
    with naming(", ".join(str(each.folder) for each in sets)):
        told = [told_people(each.manifest) for each in sets]
        people = different_people(told)
    by = frozenset(each.manifest.get(BY, MAKING) for each in sets)
    return replace(people, by=by).as_recipe() if all(told) else {}


def strange_splits(manifest: Mapping[str, Any], seen: SeenPeople) -> list[str]:
    """The splits of a folder made of a dataset among whose people, as far as it says, a model has seen nobody."""
    told = told_people(manifest)
    return [split for split in SPLITS if seen.before("test").isdisjoint(told.get(split, ()))]


def all_tested(data: Dataset) -> Dataset:
    """The dataset with all of its people in the test split, those of the validation split among them."""
    return _with_splits(data, {"train": [], "validation": [], "test": sorted(set(data.identity.tolist()))})


def training_tested(data: Dataset) -> Dataset:
    """The dataset with its training people in the test split, too; on those of the validation split, who stay apart,
    settings of what is measured can be chosen."""
    splits = data.manifest["splits"]
    tested = sorted(splits["train"] + splits["test"])
    return _with_splits(data, {"train": [], "validation": splits["validation"], "test": tested})


def unseen_data(data: Dataset, seen: Mapping[str, SeenPeople | None], everyone: bool = False) -> UnseenData:
    """Leave out of a dataset's splits whom models have seen.

    A person of the test split goes where any of them was trained or validated with it; one of the validation split,
    where trained. The training split stays.

    seen: by what messages call the model; None for one that does not say. everyone: as ``all_tested``.
    Raises InputError when there were test people and none remain.
    """
    data = all_tested(data) if everyone else _without_nobody(data)
    kept = {split: _strangers(data, split, seen) for split in SPLITS}
    people = data.manifest["splits"]["test"]
    left = len(kept["test"])
    guilty = [name for name in seen if len(_strangers(data, "test", {name: seen[name]})) < len(people)]
    if people and not left:
        raise InputError(
            f"expected test people unseen in the training of {' and '.join(guilty)}, found none among {len(people)}; "
            "build another dataset, with another --seed"
        )
    notes = (
        [f"test split: {left} of {len(people)} people, without those whom {', '.join(guilty)} saw"] if guilty else []
    )
    silent = [name for name, own in seen.items() if own is None]
    if silent:
        notes.append(f"{', '.join(silent)}: no word of whom they were trained with, who may be among the test people")
    strange = [name for name, own in seen.items() if own is not None and not _comparable(data, own)]
    if strange:
        one, other = ("generated", "imported") if _told_by(data) == MESHES else ("imported", "generated")
        notes.append(
            f"{', '.join(strange)}: trained with {one} people, who cannot be told among {other} ones and may be among "
            "the test people"
        )
    return UnseenData(_with_splits(data, kept), left, len(people), "; ".join(notes) or None)


def _without_nobody(data: Dataset) -> Dataset:
    """The dataset whose splits name nobody of whom it has no mesh: fewer meshes than people may have been drawn."""
    shown = set(data.identity.tolist())
    splits = data.manifest["splits"]
    return _with_splits(data, {split: [who for who in people if who in shown] for split, people in splits.items()})


def _with_splits(data: Dataset, splits: dict[str, list[int]]) -> Dataset:
    return replace(data, manifest=data.manifest | {"splits": splits})


def _told_by(data: Dataset) -> str:
    """What the fingerprints of a dataset's people are of."""
    return MAKING if has_partners(data) else MESHES


def _comparable(data: Dataset, own: SeenPeople) -> bool:
    """Whether all whom a model has seen would be told among the people of a dataset."""
    if own.by == {MAKING} and _told_by(data) == MESHES:
        # A recipe of before does not say that its fingerprints are of meshes; that they are here does.
        here = (fingerprints(data, split, older=True).values() for split in SPLITS)
        return bool(frozenset().union(*chain.from_iterable(here)) & (own.train | own.validation))
    return own.by == {_told_by(data)}


def measures(vertices: np.ndarray) -> bytes:
    """How far the vertices (V, 3), metres, of an imported mesh lie from their centre along every axis: averages over
    all of them, which the last digits in a file hardly change."""
    vertices = vertices.astype(float)
    away = vertices - vertices.mean(0)
    lengths = np.concatenate([away.std(0), np.abs(away).mean(0)])
    return repr(("measures/1", np.round(lengths / MEASURED_STEP).astype(int).tolist())).encode()


def _marks(data: Dataset) -> dict[str, frozenset[str]]:
    """Fingerprints of everybody in a dataset by split."""
    return {split: frozenset().union(*fingerprints(data, split).values()) for split in SPLITS}


def _strangers(data: Dataset, split: str, seen: Mapping[str, SeenPeople | None]) -> list[int]:
    """Numbers of a split's people whom no model has seen before it."""
    known_marks = frozenset().union(*(own.before(split) for own in seen.values() if own is not None))
    if not known_marks:
        return list(data.manifest["splits"][split])
    return [person for person, marks in fingerprints(data, split, older=True).items() if not marks & known_marks]


def _making(data: Dataset, row: int) -> bytes:
    """What a generated mesh's person is made of; changes that are 0 do not count, so that new ones can come."""
    changes = np.round(np.asarray(data.factors["changes"][row], float) / STEP).astype(int).tolist()
    named = sorted((name, step) for name, step in zip(data.manifest["changes"], changes, strict=True) if step)
    whole = [round(float(data.factors[name][row]) / STEP) for name in ("gender", "age", "weight")]
    return repr((whole, named)).encode()


def _measures(data: Dataset, row: int) -> bytes:
    return measures(data.vertices[row])


def _shape(data: Dataset, row: int) -> bytes:
    # Adding 0 makes of -0 what it is worth.
    return (data.vertices[row].astype("<f4") + np.float32(0)).tobytes()
