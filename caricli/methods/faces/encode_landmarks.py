"""A face of a shape model from landmarks: reconstructed first, by the best model of its mesh."""

from dataclasses import dataclass, replace

import numpy as np

from caricli.methods.faces.encode_face import EncodedFace, encode_face
from caricli.methods.reconstruct.fit_landmarks import fit_landmarks
from caricli.models.shape_model import ShapeModel


@dataclass(frozen=True, eq=False)
class LandmarkEncoder:
    """Landmarks to faces of a model.

    model: ShapeModel that the latents are of.
    fitter: ShapeModel that follows the landmarks; see ``landmark_encoder``.
    """

    model: ShapeModel
    fitter: ShapeModel

    def encode(self, points: np.ndarray, spreads: np.ndarray | None = None) -> tuple[EncodedFace, float]:
        """Reconstruct a face and find its latent.

        points: (L, 2) pixels, y down, NaN where unknown. spreads: (L, 2, 2) covariances of their errors, square pixels,
        or None where nothing is known of them.
        Returns the EncodedFace, with camera and fitted landmarks, and the NME of the reconstruction in percent.
        Raises InputError, NumericsError.
        """
        fit = fit_landmarks(points, self.fitter, spreads=spreads)
        face = replace(fit.face, mesh=self.model.template.with_vertices(fit.face.vertices))
        if self.fitter is not self.model:
            face = face.without_latent()
        return encode_face(face, self.model), fit.nme


def landmark_encoder(model: ShapeModel, elastic: ShapeModel) -> LandmarkEncoder:
    """Encode landmarks by an elastic fit, which is the better one, or within the model where its mesh is another.

    model: ShapeModel of the latents. elastic: IntrinsicModel; what it needs for fits is prepared.
    """
    same = elastic.template.topology_id == model.template.topology_id
    fitter = elastic if same else model
    fitter.prepare()
    return LandmarkEncoder(model, fitter)
