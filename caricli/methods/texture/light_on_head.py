"""The light in which a picture shows a head."""

from caricli.methods.texture.estimate_light import Light, estimate_light
from caricli.methods.texture.fill_unseen import skin_weights
from caricli.methods.texture.picture_view import SeenColours
from caricli.render.smooth_normals import even_normals
from caricli.structures import Camera
from caricli.template.template import Template


def light_on_head(head: Template, seen: SeenColours, camera: Camera) -> Light | None:
    """The light in which the vertices of a head are seen so by a camera, or None where its skin tells none."""
    weights = skin_weights(head, seen.seen)
    normals = even_normals(head.vertices, head.faces)
    return estimate_light(seen.colours, normals, head.vertices, weights, -camera.rotation[2])
