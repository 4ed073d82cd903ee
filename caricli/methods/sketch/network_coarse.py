"""The face of a network, to follow lines from."""

from collections.abc import Callable
from dataclasses import replace

from caricli.methods.faces.encode_landmarks import LandmarkEncoder
from caricli.methods.sketch.fit_lines import Lines, line_camera
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.model_coarse import CoarseFace, elastic_face, misfit
from caricli.methods.sketch.settings import COARSE, ELASTIC, UNUSUAL
from caricli.structures import Face
from caricli.structures.sketch import Sketch


def network_coarse(
    sketch: Sketch, lines: Lines, handles: LineHandles, see: Callable[[Sketch], Face], encoder: LandmarkEncoder
) -> CoarseFace:
    """What a network sees, seen by the camera that the lines tell; or an elastic face where it sees no face like that.

    Networks know faces as they are generated. Where what one sees leaves the lines by more than it leaves those that
    unsteady hands draw of such faces, ``UNUSUAL``, the elastic fit takes the landmarks on the lines, as in
    ``model_coarse``.

    sketch: Sketch. lines: of it, by curves. handles: LineHandles of the model's template. see: gives a network's face
    of the same topology with its camera, as ``see_sketch`` does. encoder: LandmarkEncoder of the model.
    Returns CoarseFace with a latent of the model. Raises InputError where the lines are not enough to tell a face: a
    network sees one in anything.
    """
    model = encoder.model
    seen = see(sketch)
    points = seen.vertices[handles.vertices]
    face = replace(seen, camera=line_camera(lines, handles, points, start=seen.require_camera()))
    if misfit(face, lines, handles) > UNUSUAL and (elastic := elastic_face(lines, handles, encoder)):
        return CoarseFace(elastic, ELASTIC)
    if face.model_id == model.model_id:
        return CoarseFace(face, COARSE[0])
    return CoarseFace(replace(face, latent=model.encode(face.vertices), model_id=model.model_id), COARSE[0])
