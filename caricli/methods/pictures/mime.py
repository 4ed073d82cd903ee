"""What people do with their faces beside the expression that they have in the dataset."""

import numpy as np

from caricli.methods.parts.attachment import attachment_for
from caricli.template.head import load_head
from caricli.template.template import Template

TWISTS = ("jawLeft", "jawRight", "mouthLeft", "mouthRight", "eyeBlinkLeft", "eyeBlinkRight", "browDownLeft",
          "browOuterUpRight", "mouthSmileLeft", "mouthSmileRight", "cheekPuff", "jawOpen", "eyeSquintLeft")  # fmt: skip
"""Actions that pull at a face beside its expression."""

GRIN = {
    "mouthSmileLeft": 0.6, "mouthSmileRight": 0.6, "mouthUpperUpLeft": 0.7, "mouthUpperUpRight": 0.7,
    "mouthLowerDownLeft": 0.7, "mouthLowerDownRight": 0.7, "mouthStretchLeft": 0.3, "mouthStretchRight": 0.3,
}  # fmt: skip
"""Weights of actions that bare the teeth, at the most."""


def is_usual_head(template: Template) -> bool:
    """Whether a template has the topology of the usual head and no parts of its own."""
    return template.parts is None and attachment_for(template) is not None


def random_mime(
    vertices: np.ndarray, template: Template, chances: tuple[float, float], generator: np.random.Generator
) -> np.ndarray:
    """(V, 3) metres: what a few actions of the usual head do to a face (V, 3), in its size.

    chances: that the mouth or an eye is pulled to one side, and that lips bare the teeth.
    """
    twisted, grinning = chances
    head = load_head()
    weights = np.zeros(len(head.action_names))
    if generator.random() < twisted:
        for name in generator.choice(TWISTS, int(generator.integers(1, 3)), replace=False):
            weights[head.action_names.index(name)] += generator.uniform(0.15, 0.6)
    if generator.random() < grinning:
        strength = generator.uniform(0.4, 1.0)
        for name, weight in GRIN.items():
            weights[head.action_names.index(name)] += strength * weight
        weights[head.action_names.index("jawOpen")] += generator.uniform(0, 0.25)
    size = np.ptp(vertices[:, 1]) / np.ptp(template.vertices[:, 1])
    chosen = weights > 0
    return size * np.tensordot(weights[chosen], head.actions[chosen], 1)
