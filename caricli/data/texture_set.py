"""A folder of textures of people with many expressions, in the chart of the face."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.dataset import SPLITS, read_named
from caricli.data.shards import ShardForm
from caricli.errors import InputError, naming
from caricli.io.npz import npz_holds, take_array, write_npz
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import take_whole, write_json
from caricli.structures.arkit import ARKIT_NAMES
from caricli.structures.checks import number_problem, refuse

SCHEMA = "caricli.textures/1"
MANIFEST = "textures.json"
SHARD_SIZE = 8
"""People of one file, at most."""

FORM = ShardForm(MANIFEST, SCHEMA, "textures", "people", SHARD_SIZE)

MAX_SIDE = 1024
MAX_SHOWN = 100
"""Texels of a side, and expressions of a person, at most."""


@dataclass(frozen=True, eq=False)
class ActedTextures:
    """Textures of one person in one light, with E expressions, the neutral one first.

    pictures: (E, S, S, 3) uint8 sRGB, of the chart. seen: (E, S, S) bool, where the picture showed it. weights:
    (E, 52) float32 of ``arkit.ARKIT_NAMES``. vertices: (E, V, 3) float32, metres. neutral: (V, 3) float32. person:
    number in the dataset. level: of exaggeration, from 1. split: of SPLITS. age: of the skin, 0 to 1.
    """

    pictures: np.ndarray
    seen: np.ndarray
    weights: np.ndarray
    vertices: np.ndarray
    neutral: np.ndarray
    person: int
    level: int
    split: str
    age: float


COLUMNS: dict[str, tuple[str, type]] = {
    "pictures": ("u", np.uint8),
    "seen": ("b", bool),
    "weights": ("f", np.float32),
    "vertices": ("f", np.float32),
    "neutral": ("f", np.float32),
    "person": ("iu", np.int32),
    "level": ("iu", np.int32),
    "age": ("f", np.float32),
}
"""Of a shard: kinds of what is read, and what is written."""


@dataclass(frozen=True, eq=False)
class TextureSet:
    """People with textures.

    folder: where they are. manifest: JSON object; its splits map SPLITS to people. count: people, each as often as
    another look or level of theirs is there. size: texels of a side. shown: expressions of each.
    """

    folder: Path
    manifest: dict[str, Any]
    count: int
    size: int
    shown: int

    def people(self, split: str | None = None) -> Iterator[ActedTextures]:
        """All of a split of SPLITS, or of all, shard by shard. Raises InputError where a file is missing or damaged."""
        for number in range(len(self.manifest["shards"])):
            yield from (one for one in self.shard(number) if split is None or one.split == split)

    def shard(self, number: int) -> list[ActedTextures]:
        """All people of a file. Raises InputError where it is missing or damaged."""
        entry = self.manifest["shards"][number]
        arrays = read_named(self.folder, entry, MANIFEST)
        with naming(self.folder / entry["file"]):
            columns = self._checked(arrays, entry["count"])
            splits = {person: name for name in SPLITS for person in self.manifest["splits"][name]}
            rows = [{name: column[k] for name, column in columns.items()} for k in range(entry["count"])]
            return [
                ActedTextures(
                    **row
                    | {"person": int(row["person"]), "level": int(row["level"]), "age": float(row["age"])}
                    | {"split": splits[int(row["person"])]}
                )
                for row in rows
            ]

    def _checked(self, arrays: Mapping[str, np.ndarray], count: int) -> dict[str, np.ndarray]:
        pixels = (count, self.shown, self.size, self.size)
        points = take_array(arrays, "neutral", "f", (count, None, 3)).shape[1]
        shapes: dict[str, tuple[int, ...]] = {
            "pictures": (*pixels, 3),
            "seen": pixels,
            "weights": (count, self.shown, len(ARKIT_NAMES)),
            "vertices": (count, self.shown, points, 3),
            "neutral": (count, points, 3),
        }
        columns = {
            name: take_array(arrays, name, kind, shapes.get(name, (count,))) for name, (kind, _) in COLUMNS.items()
        }
        refuse(*(number_problem(name, column) for name, column in columns.items() if column.dtype.kind == "f"))
        named = {person for people in self.manifest["splits"].values() for person in people}
        if not set(columns["person"].tolist()) <= named:
            raise InputError("person: expected people of the splits, found others")
        return columns


class TextureWriter:
    """Writes textures into an empty folder, the manifest last: without it the folder is none."""

    def __init__(self, folder: Path) -> None:
        """folder: Path."""
        self.folder = folder
        self.count = 0
        self.shards: list[dict[str, Any]] = []
        self.waiting: list[ActedTextures] = []

    def add(self, person: ActedTextures) -> None:
        """Write those of one person."""
        self.waiting.append(person)
        self.count += 1
        size = sum(np.asarray(getattr(person, key), kind).nbytes for key, (_, kind) in COLUMNS.items())
        if len(self.waiting) >= min(SHARD_SIZE, npz_holds(size)):
            self._flush()

    def _flush(self) -> None:
        name = f"shard-{len(self.shards):04d}.npz"
        arrays: dict[str, np.ndarray] = {
            key: np.array([getattr(one, key) for one in self.waiting], kind) for key, (_, kind) in COLUMNS.items()
        }
        write_npz(self.folder / name, arrays)
        self.shards.append({"file": name, "count": len(self.waiting), "sha256": sha256_file(self.folder / name)})
        self.waiting = []

    def finish(self, manifest: Mapping[str, Any]) -> None:
        """Write what is left and the manifest. manifest: its entries beside those that every folder of textures has."""
        if self.waiting:
            self._flush()
        value = {"schema": SCHEMA, "count": self.count, **manifest, "actions": list(ARKIT_NAMES)}
        write_json(self.folder / MANIFEST, value | {"shards": self.shards})


def read_texture_set(folder: Path) -> TextureSet:
    """Read a folder of textures; these themselves are read when they are asked for.

    Raises InputError when a part is missing, damaged or does not fit the others.
    """
    folder = Path(folder)
    manifest = FORM.load_manifest(folder)
    with naming(folder / MANIFEST):
        size = take_whole(manifest, "size", 1, MAX_SIDE)
        expressions = take_whole(manifest, "expressions", 1, MAX_SHOWN)
        if manifest.get("actions") != list(ARKIT_NAMES):
            raise InputError("actions: expected those of ARKit in their usual order, found others")
    return TextureSet(folder, manifest, manifest["count"], size, expressions)
