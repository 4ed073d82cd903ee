"""The shape that a caricaturist would give the face of a portrait."""

from dataclasses import dataclass

import numpy as np

from caricli.errors import InputError
from caricli.geometry.deformation.laplacian_deformation import LaplacianDeformation
from caricli.methods.edit.caricaturize_face import caricaturize_face
from caricli.methods.edit.map_landmarks import map_landmarks
from caricli.methods.faces.encode_face import encode_face
from caricli.methods.reconstruct.landmark_fit import LandmarkFit
from caricli.models.landmark_map.model import LandmarkMap
from caricli.models.shape_model import ShapeModel
from caricli.structures import Directions
from caricli.structures.landmarks import COUNT
from caricli.template.template import Template

_WEIGHT = 1.0
"""Of a landmark against the shape of the surface, as in ``refine_face``."""


@dataclass(frozen=True, eq=False)
class ShapeTools:
    """What shapes are made with.

    model: ShapeModel that the portrait is fitted with. landmark_map: for the shape "map", or None. directions: of the
    model, for the shape "direction", or None.
    """

    model: ShapeModel
    landmark_map: LandmarkMap | None = None
    directions: Directions | None = None


def exaggerate_portrait(fit: LandmarkFit, tools: ShapeTools, shape: str, strength: float) -> np.ndarray:
    """Give the face of a portrait the shape of a caricature, in the place that it has.

    "map": its landmarks go where the landmark map sees those of the caricature that makes more of what is unusual
    about it (expressions paper, 3.2.1), and the surface goes along as one of least Laplacian change (portrait paper,
    equation 10); ``strength`` times as far. "direction" and "own": as ``caricaturize_face`` does.
    fit: LandmarkFit of the portrait. tools: ShapeTools. shape: of SHAPES but "none". strength: 0 changes nothing.
    Returns (V, 3) metres. Raises InputError, NumericsError.
    """
    if shape == "map":
        if tools.landmark_map is None:
            raise InputError("expected a landmark map for the shape 'map', found none")
        return _mapped(fit, tools.landmark_map, tools.model.template, strength)
    encoded = encode_face(fit.face, tools.model)
    return caricaturize_face(encoded, tools.model, strength, shape, tools.directions).vertices


def _mapped(fit: LandmarkFit, landmark_map: LandmarkMap, template: Template, strength: float) -> np.ndarray:
    """Vertices (V, 3) with the landmarks on the way to a caricature's, at the depth that they have."""
    face = fit.face
    ids, first = np.unique(fit.anchors[:COUNT], return_index=True)
    marks = face.require_landmarks()
    targets = map_landmarks(marks, landmark_map, "caricature", landmark_map.own_style(marks[:COUNT]))[first]
    places = face.require_camera().lift(targets, face.vertices[ids])
    moved = LaplacianDeformation(face.vertices, template.faces, ids, _WEIGHT).move(places)
    return face.vertices + strength * (moved - face.vertices)
