"""The faces that a generated dataset's meshes were exaggerated from."""

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.expressions import expand_sides
from caricli.geometry.similarity import similarity
from caricli.io.bundled import asset_path
from caricli.io.config import read_yaml
from caricli.template.head import load_head


def regular_faces(data: Dataset, rows: np.ndarray) -> np.ndarray:
    """The faces that the meshes of a generated Dataset were exaggerated from, drawn again.

    rows: (n,) numbers of the meshes.
    Returns (n, V, 3) metres.
    """
    head = load_head()
    template = data.template
    place = template.region("face")
    actions = list(read_yaml(asset_path("expressions.yaml")).values())
    shapes = []
    for row in rows:
        factors = {name: float(data.factors[name][row]) for name in ("gender", "age", "weight")}
        changes = data.factors["changes"][row].astype(float).tolist()
        factors["changes"] = dict(zip(data.manifest["changes"], changes, strict=True))
        scale, rotation, shift = similarity(head.evaluate(**factors)[place], template.vertices[place])
        acting = head.evaluate(**factors, actions=expand_sides(actions[data.expression[row]], head.action_names))
        shapes.append(scale * acting @ rotation.T + shift)
    return np.array(shapes)


def has_partners(data: Dataset) -> bool:
    """Whether ``regular_faces`` can be drawn for a Dataset."""
    return {"gender", "age", "weight", "changes"} <= set(data.factors) and "changes" in data.manifest
