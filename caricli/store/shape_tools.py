"""What shapes of stylised portraits are made with, by path or the bundled ones."""

from pathlib import Path

from caricli.methods.stylise.exaggerate_portrait import ShapeTools
from caricli.methods.stylise.settings import StyliseSettings
from caricli.store.directions import load_directions
from caricli.store.landmark_maps import load_landmark_map
from caricli.store.models import load_model


def load_shape_tools(settings: StyliseSettings, model: Path | None = None) -> ShapeTools | None:
    """Load what the shape of StyliseSettings takes, prepared; None where the picture keeps its shape.

    model: path of the model that portraits are fitted with, or None for the bundled one that follows landmarks best.
    Raises InputError.
    """
    if settings.shape == "none" or settings.strength == 0:
        return None
    shape_model = load_model(model)
    shape_model.prepare()
    landmark_map = load_landmark_map() if settings.shape == "map" else None
    directions = load_directions(shape_model) if settings.shape == "direction" else None
    return ShapeTools(shape_model, landmark_map, directions)
