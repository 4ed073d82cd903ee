"""Folders of shards: files of so many things each, and a manifest that says what they are."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from caricli.data.dataset import read_manifest
from caricli.errors import InputError, naming
from caricli.io.strict_json import take, take_whole
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
        manifest = read_manifest(folder, self.manifest, self.schema, f"a folder of {self.kind}")
        with naming(folder / self.manifest):
            count = take_whole(manifest, "count", 1, MAX_VERTICES)
            shards = take(manifest, "shards", list)
            if not all(isinstance(shard, dict) for shard in shards):
                raise InputError("shards: expected objects with file, count and sha256, found others")
            if sum(take_whole(shard, "count", 1, self.largest) for shard in shards) != count:
                raise InputError(f"expected {count} {self.counted} in the shards, found others")
        return manifest
