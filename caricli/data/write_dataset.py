"""Write a dataset folder, shard by shard."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.dataset import MANIFEST, SCHEMA
from caricli.io.npz import write_npz
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import write_json
from caricli.structures.frame import AXES, UNITS
from caricli.template.own_parts import parts_to_arrays
from caricli.template.template import Template

SHARD_SIZE = 512
"""Meshes of one file, at most: about 26 MB for the open head."""


class DatasetWriter:
    """Writes a dataset into an empty folder, the manifest last: without it the folder is none."""

    def __init__(self, folder: Path, template: Template) -> None:
        """template: of all meshes; its file is written at once."""
        self.folder = folder
        self.template = template
        self.shards: list[dict[str, Any]] = []
        arrays = {"vertices": template.vertices, "faces": template.faces, "polygons": template.polygons}
        if template.uvs is not None and template.uv_polygons is not None:
            arrays |= {"uvs": template.uvs, "uv_polygons": template.uv_polygons}
        write_npz(folder / "template.npz", arrays | parts_to_arrays(template.parts))

    def add_shard(self, columns: Mapping[str, np.ndarray]) -> None:
        """Write one file of meshes.

        columns: vertices (n, V, 3) metres, identity, expression, level (n,) ints, and further ones (n, ...).
        """
        name = f"shard-{len(self.shards):04d}.npz"
        vertices = columns["vertices"].astype(np.float32)
        write_npz(self.folder / name, {**columns, "vertices": vertices})
        self.shards.append({"file": name, "count": len(vertices), "sha256": sha256_file(self.folder / name)})

    def finish(self, manifest: Mapping[str, Any], labels: Mapping[str, np.ndarray]) -> None:
        """Write labels and manifest.

        manifest: its entries beside those that every dataset has. labels: attributes (A,), measures and labels (N, A).
        """
        write_npz(self.folder / "labels.npz", dict(labels))
        value = {
            "schema": SCHEMA,
            "units": UNITS,
            "axes": AXES,
            "topology_id": self.template.topology_id,
            **manifest,
            "annotation": self.template.annotation.source,
            "template": {"file": "template.npz", "sha256": sha256_file(self.folder / "template.npz")},
            "labels": {"file": "labels.npz", "sha256": sha256_file(self.folder / "labels.npz")},
            "shards": self.shards,
        }
        write_json(self.folder / MANIFEST, value)
