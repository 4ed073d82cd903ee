"""What commands share that move a face along semantic directions."""

from caricli.data.attributes import measure_attributes
from caricli.errors import InputError, shown
from caricli.geometry.flipped_triangles import flipped_triangles
from caricli.io.bundled import asset_path
from caricli.io.directions import read_directions


def directions_path(path, model):
    """The file of directions that was given, or the bundled one of the model's kind."""
    path = asset_path(f"directions-{model.kind}.npz") if path is None else path
    if not path.is_file() and path.parent == asset_path(""):
        raise InputError(f"there are no bundled directions for {model.kind} models; give --directions")
    return path


def load_directions(path, model):
    """The Directions of a file, refused when they are not of the model."""
    from caricli.commands.loading import model_name

    directions = read_directions(path)
    if directions.model_id != model.model_id:
        raise InputError(
            f"{shown(path)}: its directions are of {model_name(directions.model_id)}, not of "
            f"{model_name(model.model_id)}; make them with caricli train semantic and give --directions"
        )
    if directions.normals.shape[1] != len(model.prior.mean):
        found = directions.normals.shape[1]
        raise InputError(f"{shown(path)}: expected directions of {len(model.prior.mean)} numbers, found {found}")
    return directions


def face_figures(face, model):
    """What the JSON says of an EncodedFace: prior, flipped triangles and, where they can be measured, attributes."""
    template = model.template
    flipped = float(flipped_triangles(face.vertices, template.gradients).mean())
    figures = {"prior_rms": face.prior_rms, "flipped": flipped}
    if template.annotation.has_extra:
        figures["attributes"] = measure_attributes(face.vertices, template)
    return figures
