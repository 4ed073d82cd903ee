"""Random faces of a shape model."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from caricli.errors import NumericsError
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.faces.encode_face import EncodedFace, encode_face
from caricli.methods.morphable.wear_colours import wear_colours
from caricli.models.morphable.model import MorphableModel
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face

MAX_FLIPPED = 0.002
"""Share of flipped triangles up to which a face is taken: a handful of slivers, which no picture shows."""

TRIES = 50
"""Draws in a row that may be rejected before the model or the spread is to blame."""


@dataclass(frozen=True, eq=False)
class SampledFace:
    """A random face.

    face: EncodedFace.
    flipped_drawn, flipped: shares of flipped triangles as drawn and as it is.
    rejected: draws before it that were not taken.
    """

    face: EncodedFace
    flipped_drawn: float
    flipped: float
    rejected: int

    def figures(self) -> dict[str, float]:
        """What reports say of it."""
        return {
            "prior_rms": self.face.prior_rms,
            "flipped": self.flipped,
            "flipped_drawn": self.flipped_drawn,
            "rejected": self.rejected,
        }


def sample_faces(model: ShapeModel, generator: np.random.Generator, spread: float = 1.0) -> Iterator[SampledFace]:
    """Draw faces from a model's prior for as long as they are asked for.

    Flipped triangles are turned back and cavities tucked behind the skin; a face that keeps too many flipped ones is
    rejected for another draw. Faces of a morphable model wear colours of it.

    model: ShapeModel. generator: of the draws. spread: factor of the prior's standard deviation; smaller is nearer to
    the mean face.
    Yields SampledFace. Raises NumericsError after ``TRIES`` rejections in a row.
    """
    template = model.template
    rejected = 0
    while rejected < TRIES:
        latent = model.prior.colour(spread * generator.normal(size=len(model.prior.mean)))
        drawn = model.decode(latent)
        vertices = template.mended(drawn)
        before, after = (float(flipped_triangles(v, template.gradients).mean()) for v in (drawn, vertices))
        if after > MAX_FLIPPED:
            rejected += 1
            continue
        face = Face(template.with_vertices(vertices), latent=latent, model_id=model.model_id)
        if isinstance(model, MorphableModel):
            colours = model.colours(spread * generator.normal(size=len(model.albedo.basis)))
            face = wear_colours(face, template, colours)
        yield SampledFace(encode_face(face, model), before, after, rejected)
        rejected = 0
    raise NumericsError(
        f"{TRIES} random faces in a row had more than {100 * MAX_FLIPPED:g} % flipped triangles: a smaller spread "
        f"than {spread:g} may help"
    )
