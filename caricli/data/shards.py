"""Folders of shards: files of so many things each, and a manifest that says what they are."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.dataset import SPLITS, are_people
from caricli.errors import InputError, naming, shown
from caricli.io.npz import read_npz
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import read_json, take, take_whole
from caricli.limits import MAX_VERTICES


@dataclass(frozen=True)
class ShardForm:
    """One kind of folder.

    manifest: its file's name. schema: of the manifest. kind: what the folder holds, and counted: what its shards count,
    for messages. largest: of a shard.
    """

    manifest: str
    schema: str
    kind: str
    counted: str
    largest: int

    def load_manifest(self, folder: Path) -> dict[str, Any]:
        """The manifest of a folder: ``count``, ``splits`` of people, and ``shards``, which hold so many together.

        Raises InputError when it is missing, damaged or of another kind.
        """
        where = folder / self.manifest
        if folder.is_dir() and not where.exists():
            missing = f"not a folder of {self.kind}, or its making was stopped"
            raise InputError(f"{folder}: no {self.manifest} in this folder: {missing}")
        manifest = read_json(where)
        with naming(where):
            schema = manifest.get("schema") if isinstance(manifest, dict) else None
            if schema != self.schema:
                raise InputError(f"expected schema {self.schema!r}, found {shown(schema, 60)!r}")
            count = take_whole(manifest, "count", 1, MAX_VERTICES)
            splits = take(manifest, "splits", dict)
            shards = take(manifest, "shards", list)
            if set(splits) != set(SPLITS) or not all(map(are_people, splits.values())):
                raise InputError(f"expected splits {', '.join(SPLITS)}, found others")
            if not all(isinstance(shard, dict) for shard in shards):
                raise InputError("shards: expected objects with file, count and sha256, found others")
            if sum(take_whole(shard, "count", 1, self.largest) for shard in shards) != count:
                raise InputError(f"expected {count} {self.counted} in the shards, found others")
        return manifest

    def load_shard(self, folder: Path, shard: Mapping[str, Any]) -> dict[str, np.ndarray]:
        """The arrays of a shard, an entry of the manifest. Raises InputError where its bytes are others than there."""
        name = shard.get("file")
        if not isinstance(name, str) or Path(name).name != name:
            where = folder / self.manifest
            raise InputError(f"{where}: expected the name of a file in the folder, found {shown(name, 40)!r}")
        if sha256_file(folder / name) != shard.get("sha256"):
            raise InputError(f"{folder / name}: its SHA-256 is not the one in {self.manifest}: the file was changed")
        return read_npz(folder / name)
