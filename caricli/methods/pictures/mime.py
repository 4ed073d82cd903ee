"""What people do with their faces beside the expression that they have in the dataset."""

import numpy as np

from caricli.methods.parts.attachment import attachment_for
from caricli.methods.pictures.settings import SitterSettings
from caricli.structures.landmarks import MOUTH
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

LAUGH = {
    "mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "mouthUpperUpLeft": 1.0, "mouthUpperUpRight": 1.0,
    "mouthLowerDownLeft": 1.0, "mouthLowerDownRight": 1.0, "mouthStretchLeft": 0.6, "mouthStretchRight": 0.6,
    "cheekSquintLeft": 0.5, "cheekSquintRight": 0.5, "jawOpen": 0.7,
}  # fmt: skip
"""Weights of actions that draw the lips far apart before the teeth, each at the most, before the loudest laugh."""

_REACH = 0.9
"""How far from its middle the face follows, in widths of the mouth."""


def is_usual_head(template: Template) -> bool:
    """Whether a template has the topology of the usual head and no parts of its own."""
    return template.parts is None and attachment_for(template) is not None


def random_mime(
    vertices: np.ndarray, template: Template, settings: SitterSettings, generator: np.random.Generator
) -> np.ndarray:
    """(V, 3) metres: what a few actions of the usual head do to a face (V, 3), in its size.

    settings: how often people twist their faces, grin and laugh, and how loud and wide.
    """
    head = load_head()
    weights = np.zeros(len(head.action_names))
    wider = 0.0
    if generator.random() < settings.twisted:
        for name in generator.choice(TWISTS, int(generator.integers(1, 3)), replace=False):
            weights[head.action_names.index(name)] += generator.uniform(0.15, 0.6)
    if generator.random() < settings.grinning:
        strength = generator.uniform(0.4, 1.0)
        for name, weight in GRIN.items():
            weights[head.action_names.index(name)] += strength * weight
        weights[head.action_names.index("jawOpen")] += generator.uniform(0, 0.25)
    if generator.random() < settings.laughing:
        strength = generator.uniform(0.6, settings.loudest)
        shares = dict(zip(LAUGH, generator.uniform(0.3, 1.0, len(LAUGH)), strict=True))
        # The jaw is as often closed as dropped; both sides of a mouth laugh nearly alike.
        shares["jawOpen"] *= generator.random() < 0.5
        for name, weight in LAUGH.items():
            other = name.replace("Right", "Left")
            share = 0.25 * shares[name] + 0.75 * shares[other]
            weights[head.action_names.index(name)] += strength * weight * share
        wider = max(generator.uniform(-settings.widest, settings.widest), 0)
    if generator.random() < settings.wide:
        wider = max(wider, generator.uniform(0, settings.widest))
    size = np.ptp(vertices[:, 1]) / np.ptp(template.vertices[:, 1])
    chosen = weights > 0
    moved = size * np.tensordot(weights[chosen], head.actions[chosen], 1)
    return moved + _widened(vertices + moved, template, wider)


def _widened(vertices: np.ndarray, template: Template, wider: float) -> np.ndarray:
    """(V, 3) metres: what a mouth that is wider by a share of its width does to a face, less and less around it."""
    mouth = vertices[template.annotation.landmarks[list(MOUTH)]]
    apart = vertices - mouth.mean(0)
    reach = _REACH * np.ptp(mouth[:, 0])
    follows = np.exp(-((np.linalg.norm(apart, axis=1) / reach) ** 2))
    return np.stack([wider * follows * apart[:, 0], np.zeros(len(vertices)), np.zeros(len(vertices))], 1)
