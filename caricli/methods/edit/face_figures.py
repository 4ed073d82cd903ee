"""What reports say of an edited face."""

from caricli.data.attributes import measure_attributes
from caricli.geometry.flipped_triangles import flipped_triangles


def face_figures(face, model):
    """What the JSON says of an EncodedFace: prior, flipped triangles and, where they can be measured, attributes."""
    template = model.template
    flipped = float(flipped_triangles(face.vertices, template.gradients).mean())
    figures = {"prior_rms": face.prior_rms, "flipped": flipped}
    if template.annotation.has_extra:
        figures["attributes"] = measure_attributes(face.vertices, template)
    return figures
