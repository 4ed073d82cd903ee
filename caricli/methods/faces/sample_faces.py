"""Random faces of a shape model."""

from dataclasses import dataclass

from caricli.errors import NumericsError
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.geometry.untangle import untangle
from caricli.methods.faces.encode_face import EncodedFace, encode_face

MAX_FLIPPED = 0.002
TRIES = 50


@dataclass(frozen=True, eq=False)
class SampledFace:
    """A random face; shares of flipped triangles as drawn and as it is; draws that were rejected before it."""

    face: EncodedFace
    flipped_drawn: float
    flipped: float
    rejected: int


def sample_faces(model, generator, spread=1.0, max_flipped=MAX_FLIPPED):
    """Draw faces from a model's prior for as long as they are asked for.

    Flipped triangles are turned back and cavities tucked behind the skin; a face that keeps too many flipped ones is
    rejected for another draw.

    model: ShapeModel. generator: numpy Generator. spread: factor of the prior's standard deviation; smaller is nearer
    to the mean face. max_flipped: share of flipped triangles up to which a face is taken.
    Yields SampledFace. Raises NumericsError after ``TRIES`` rejections in a row.
    """
    template, rejected = model.template, 0
    while rejected < TRIES:
        latent = model.prior.colour(spread * generator.normal(size=len(model.prior.mean)))
        drawn = model.decode(latent)
        vertices = template.cavities.tuck(untangle(drawn, template.gradients))
        before, after = (float(flipped_triangles(v, template.gradients).mean()) for v in (drawn, vertices))
        if after > max_flipped:
            rejected += 1
            continue
        yield SampledFace(encode_face(vertices, model, latent), before, after, rejected)
        rejected = 0
    raise NumericsError(
        f"{TRIES} random faces in a row had more than {100 * max_flipped:g} % flipped triangles: a smaller spread "
        f"than {spread:g} may help"
    )
