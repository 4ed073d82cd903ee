"""The likeliest face of a model for lines."""

from collections.abc import Mapping, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from caricli.errors import InputError
from caricli.geometry.alignment.rotation_vectors import rotation_vectors
from caricli.methods.reconstruct.camera_rows import CAMERA, camera_rows, moved_camera
from caricli.methods.sketch.line_handles import LineHandles
from caricli.methods.sketch.settings import CORNERED, LineFitSettings
from caricli.models.shape_model import ShapeModel
from caricli.structures import Camera, Face

FEWEST = 8
"""Vertices on lines that tell a camera, at least."""

_ENOUGH = 3
"""Curves between corners that tell where a face is."""

_LARGEST = 3.0
"""Radians, and logarithms of the scale: a step as large as this leads nowhere."""

_DOT = 1e-6
"""Pixels: lines that are all in one place."""

TURN = slice(0, 3)
FRONT = np.diag([1.0, -1.0, -1.0])

Lines = Mapping[str, Sequence[np.ndarray]]
"""Lines (N, 2), pixels, by the names of the curves that they draw."""


class TooFewLines(InputError):
    """Lines that are not enough to tell a face."""


@threadpool_limits.wrap(limits=1)
def fit_lines(
    lines: Lines,
    handles: LineHandles,
    model: ShapeModel,
    settings: LineFitSettings = LineFitSettings(),  # noqa: B008 (frozen)
) -> Face:
    """Fit a face that stays inside a shape model to lines.

    Minimises ``sum_h |s R[:2] v_h(z) + t - q_h|^2 / noise^2 + |turn|^2 / view^2 + |whitened z|^2`` over camera and
    latent by Gauss-Newton steps, the places q_h found again along the lines before each (``LineHandles.places``); the
    turn is that of R from the front.

    lines: by the names of curves. handles: LineHandles of the model's template. model: any ShapeModel.
    settings: LineFitSettings.
    Returns the Face with latent and camera. Raises TooFewLines, InputError where they lead nowhere, NumericsError.
    """
    whitened = np.zeros(len(model.prior.mean))
    camera = line_camera(lines, handles, model.decode_points(model.prior.mean, handles.vertices), settings)
    for _ in range(settings.rounds):
        points, jacobian = model.points_jacobian(model.prior.colour(whitened), handles.vertices)
        places = _places(lines, handles, camera, points)
        system, right = _normal_equations(camera, points, places, jacobian @ model.prior.factor, settings)
        system[CAMERA:, CAMERA:] += np.eye(len(whitened))
        right[CAMERA:] -= whitened
        step = np.linalg.solve(system, right)
        camera = _stepped(camera, step[:CAMERA])
        whitened = whitened + step[CAMERA:]
    latent = model.prior.colour(whitened)
    mesh = model.template.with_vertices(model.decode(latent))
    camera = line_camera(lines, handles, mesh.vertices[handles.vertices], settings, camera)
    return Face(mesh, camera, latent=latent, model_id=model.model_id)


def line_camera(
    lines: Lines,
    handles: LineHandles,
    points: np.ndarray,
    settings: LineFitSettings = LineFitSettings(),  # noqa: B008 (frozen)
    start: Camera | None = None,
) -> Camera:
    """The camera that sees handles on their lines, as nearly from the front as these allow; see ``fit_lines``.

    points: (H, 3) metres, of the handles. start: Camera to begin with, or None for one from the front, so large that
    the boxes of lines and curves agree. Raises TooFewLines, and InputError where they lead nowhere.
    """
    camera = _front(lines, handles, points) if start is None else start
    none = np.zeros((len(points), 3, 0))
    for _ in range(settings.first):
        places = _places(lines, handles, camera, points)
        for _ in range(2):
            step = np.linalg.solve(*_normal_equations(camera, points, places, none, settings))
            camera = _stepped(camera, step)
    return camera


def _places(lines: Lines, handles: LineHandles, camera: Camera, points: np.ndarray) -> np.ndarray:
    """(H, 2) pixels on lines of handles (H, 3), NaN where nothing was drawn. Raises TooFewLines where too few are."""
    places = handles.places(lines, camera.project(points))
    if np.isfinite(places).all(axis=1).sum() < FEWEST:
        raise TooFewLines(f"expected lines of the curves of a face, found {_told(lines)}")
    return places


def _normal_equations(
    camera: Camera, points: np.ndarray, places: np.ndarray, jacobian: np.ndarray, settings: LineFitSettings
) -> tuple[np.ndarray, np.ndarray]:
    """System (6 + D, 6 + D) and right side for the camera and what moves the handles, without the prior of the latter.

    points: (H, 3). places: (H, 2), NaN where nothing was drawn. jacobian: (H, 3, D).
    """
    met = np.isfinite(places).all(axis=1)
    noise = settings.noise * np.linalg.norm(np.ptp(places[met], axis=0))
    rows = camera_rows(points[met], jacobian[met], camera).reshape(2 * met.sum(), -1) / noise
    gaps = (places[met] - camera.project(points[met])).ravel() / noise
    system = rows.T @ rows
    right = rows.T @ gaps
    view = np.radians(settings.view)
    system[TURN, TURN] += np.eye(3) / view**2
    right[TURN] -= rotation_vectors((camera.rotation @ FRONT.T)[None])[0] / view**2
    return system, right


def _stepped(camera: Camera, step: np.ndarray) -> Camera:
    """``moved_camera``. Raises InputError for a step that leads nowhere."""
    if np.abs(step[: CAMERA - 2]).max() > _LARGEST:
        raise InputError("expected lines that a face could show, found none that have lines like these")
    return moved_camera(camera, step)


def _front(lines: Lines, handles: LineHandles, points: np.ndarray) -> Camera:
    """The camera from the front that gives the curves of all lines the box of these.

    Curves between corners are drawn whole; of a silhouette perhaps the jaw alone, so that it counts where it has to.
    """
    whole = [name for name in lines if name in handles.rows and name.startswith(CORNERED)]
    names = whole if len(whole) >= _ENOUGH else [name for name in lines if name in handles.rows]
    if not names:
        raise TooFewLines(f"expected lines of the curves of a face, found {_told(lines)}")
    flat = points[np.concatenate([handles.rows[name] for name in names])] @ FRONT[:2].T
    drawn = np.concatenate([line for name in names for line in lines[name]])
    extent = np.linalg.norm(np.ptp(drawn, axis=0))
    if extent < _DOT:
        raise TooFewLines("expected lines of the curves of a face, found a dot")
    scale = extent / np.linalg.norm(np.ptp(flat, axis=0))
    middles = [(values.min(0) + values.max(0)) / 2 for values in (drawn, flat)]
    return Camera(float(scale), FRONT, middles[0] - scale * middles[1])


def _told(lines: Lines) -> str:
    return ", ".join(sorted(lines)) if lines else "none"
