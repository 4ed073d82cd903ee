"""Views of heads as sessions write them."""


def view_parameters(camera):
    """The JSON value of a Camera, as ``view_of`` takes it."""
    return {"scale": camera.scale, "rotation": camera.rotation.tolist(), "translation": camera.translation.tolist()}
