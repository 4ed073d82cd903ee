"""Faces of the open head before exaggeration, each where the face of a template is."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from caricli.data.dataset import Dataset
from caricli.data.expressions import named_expressions
from caricli.data.identities import Identity
from caricli.geometry.alignment.similarity import similarity
from caricli.template.head import Head, load_head
from caricli.template.template import Template


@dataclass(frozen=True, eq=False)
class Person:
    """A person, and the similarity that aligns the neutral face to the template's.

    scale, rotation (3, 3), translation (3,) metres: of every expression of the person.
    """

    identity: Identity
    scale: float
    rotation: np.ndarray
    translation: np.ndarray

    def place(self, vertices: np.ndarray) -> np.ndarray:
        """Vertices (..., 3) of the person's head to where the template's are."""
        return self.scale * vertices @ self.rotation.T + self.translation


def align_person(identity: Identity, neutral: np.ndarray, template: Template) -> Person:
    """The Person of an identity. neutral: (V, 3) metres, the head without expression."""
    face = template.region("face")
    return Person(identity, *similarity(neutral[face], template.vertices[face]))


def regular_face(person: Person, actions: Mapping[str, float], head: Head) -> np.ndarray:
    """Aligned vertices (V, 3) of a person with an expression. actions: weights by full names."""
    return person.place(head.evaluate(**vars(person.identity), actions=actions))


def regular_faces(data: Dataset, rows: np.ndarray, expression: int | None = None) -> np.ndarray:
    """The faces that the meshes of a generated Dataset were exaggerated from, made again.

    rows: (n,) numbers of the meshes. expression: the number of one that all show, or None for their own.
    Returns (n, V, 3) metres.
    """
    head = load_head()
    actions = list(named_expressions(head.action_names).values())
    shapes = []
    for row in rows:
        person = person_of(data, row, head)
        number = data.expression[row] if expression is None else expression
        shapes.append(regular_face(person, actions[number], head))
    return np.array(shapes)


def person_of(data: Dataset, row: int, head: Head) -> Person:
    """The Person whose face a mesh of a generated Dataset is. row: number of the mesh."""
    identity = _identity(data, row)
    return align_person(identity, head.evaluate(**vars(identity)), data.template)


def has_partners(data: Dataset) -> bool:
    """Whether ``regular_faces`` can be made for a Dataset."""
    return {"gender", "age", "weight", "changes"} <= set(data.factors) and "changes" in data.manifest


def _identity(data: Dataset, row: int) -> Identity:
    gender, age, weight = (float(data.factors[name][row]) for name in ("gender", "age", "weight"))
    changes = data.factors["changes"][row].astype(float).tolist()
    return Identity(gender, age, weight, dict(zip(data.manifest["changes"], changes, strict=True)))
