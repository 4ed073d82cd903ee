import numpy as np

from caricli.methods.sketch.vary_sketch import HandSettings, hand_camera, vary_sketch
from caricli.structures import Sketch, Stroke, StrokeKind
from tests.named_lines import points_by_curve

ANGLES = np.linspace(0, 2 * np.pi, 60)
RING = np.column_stack([128 + 90 * np.cos(ANGLES), 128 + 90 * np.sin(ANGLES)])
RING[-1] = RING[0]
LINES = [np.array([[60.0 + 10 * k, 90], [60 + 10 * k, 110 + 5 * k]]) for k in range(10)]
SKETCH = Sketch(
    (
        Stroke(RING, StrokeKind.SILHOUETTE, "silhouette"),
        *(Stroke(line, StrokeKind.FEATURE, f"line_{k}") for k, line in enumerate(LINES)),
        *(Stroke(line + [0, 60], StrokeKind.WRINKLE) for line in LINES[:4]),
    )
)


def varied(seed, **changes):
    return vary_sketch(SKETCH, np.random.default_rng(seed), HandSettings(**changes))


STILL = {"removed": (0.0,), "bare": 0.0, "bend": 0.0, "strays": 0.0, "turn": 0.0, "grow": 0.0, "wobble": 0.0,
         "tremor": 0.0, "overshot": 0.0, "gap": 0.0, "doubled": 0.0, "pressed": 0.0}  # fmt: skip


def distance(points, line):
    """Of points to a polyline, by its points every tenth of a pixel."""
    dense = np.concatenate([np.linspace(a, b, 200) for a, b in zip(line[:-1], line[1:], strict=True)])
    return np.linalg.norm(points[:, None] - dense, axis=2).min(1)


def test_a_still_hand_draws_the_lines():
    still = varied(0, **STILL)
    assert [(s.kind, s.curve) for s in still.strokes] == [(s.kind, s.curve) for s in SKETCH.strokes]
    for stroke, exact in zip(still.strokes, SKETCH.strokes, strict=True):
        assert distance(stroke.points, exact.points).max() < 0.2
        assert np.allclose(stroke.points[[0, -1]], exact.points[[0, -1]])


def test_the_same_numbers_draw_the_same_sketch():
    first, second, third = (vary_sketch(SKETCH, np.random.default_rng(seed)) for seed in (4, 4, 5))
    assert all(np.array_equal(a.points, b.points) for a, b in zip(first.strokes, second.strokes, strict=True))
    assert len(first.strokes) != len(third.strokes) or not np.array_equal(
        first.strokes[0].points, third.strokes[0].points
    )


def test_as_many_strokes_are_left_out_as_said_and_short_late_ones_first():
    removing = STILL | {"removed": (0.5,)}
    left = np.zeros(len(SKETCH.strokes))
    for seed in range(200):
        names = [stroke.curve for stroke in varied(seed, **removing).strokes]
        assert len(names) == len(SKETCH.strokes) - round(0.5 * len(SKETCH.strokes))
        left[:11] += [stroke.curve in names for stroke in SKETCH.strokes[:11]]
    # The ring is long and first; of the lines, the last features are longer, so only the ring is told apart.
    assert left[0] == left.max() > 1.3 * left[1:11].mean()
    assert len(varied(0, **STILL | {"removed": (1.0,)}).strokes) == 1


def test_bending_bends_all_lines_together():
    bent = varied(1, **STILL | {"bend": 0.03})
    shifts = [
        (stroke.points[[0, -1]] - exact.points[[0, -1]]).mean(0)
        for stroke, exact in zip(bent.strokes, SKETCH.strokes, strict=True)
    ]
    neighbours = np.linalg.norm(np.diff(shifts[1:11], axis=0), axis=1)
    assert np.abs(shifts).max() > 1 and neighbours.max() < 4


def test_gaps_doubles_and_overshoots():
    broken = varied(2, **STILL | {"gap": 1.0})
    ring = [stroke for stroke in broken.strokes if stroke.kind is StrokeKind.SILHOUETTE]
    assert len(ring) == 2 and all(part.curve is None for part in ring)
    assert sum(part.length for part in ring) < SKETCH.strokes[0].length - 1
    doubled = varied(2, **STILL | {"doubled": 1.0, "strays": 0.004})
    assert len(doubled.strokes) == 2 * len(SKETCH.strokes)
    assert points_by_curve(doubled).keys() == points_by_curve(SKETCH).keys()
    over = varied(2, **STILL | {"overshot": 1.0})
    longer = [a.length - b.length for a, b in zip(over.strokes[1:], SKETCH.strokes[1:], strict=True)]
    assert min(longer) > 1 and max(longer) < 2 * 0.03 * 256 + 1


def test_pressure_and_width():
    pressed = varied(3, **STILL | {"pressed": 1.0, "width": (2.0, 2.0)})
    for stroke in pressed.strokes:
        assert stroke.width == 2 and (stroke.pressure > 0).all() and (stroke.pressure <= 1).all()
        assert stroke.pressure[0] < stroke.pressure.max()


def test_closed_lines_stay_closed():
    strayed = varied(4, **STILL | {"wobble": 0.01, "tremor": 0.002, "turn": 5.0})
    assert strayed.strokes[0].closed


def test_no_strength_is_the_exact_front():
    none = HandSettings().scaled(0)
    points = np.random.default_rng(0).normal(size=(50, 3))
    camera = hand_camera(points, 100, np.random.default_rng(1), none)
    assert np.allclose(camera.rotation, np.diag([1.0, -1, -1])) and none.width == (1, 1)
    placed = camera.project(points)
    assert np.allclose((placed.min(0) + placed.max(0)) / 2, 49.5)
    exact = vary_sketch(SKETCH, np.random.default_rng(1), none)
    assert len(exact.strokes) == len(SKETCH.strokes)


def test_views_are_yaw_pitch_and_roll_in_this_order():
    points = np.random.default_rng(0).normal(size=(9, 3))
    for k, kept in enumerate((1, 0, 2)):
        view = tuple(20.0 * (np.arange(3) == k))
        camera = hand_camera(points, 256, np.random.default_rng(1), HandSettings(view=view))
        # A turn leaves its own axis where it is: yaw that which goes up, pitch that to the side, roll that in depth.
        axis = np.eye(3)[kept]
        assert abs(camera.rotation[kept] @ axis) > 1 - 1e-12
        assert np.abs(camera.rotation - np.diag([1, -1, -1])).max() > 0.01
