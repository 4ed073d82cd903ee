"""What caricaturists do to a face, as moves of its 81 landmarks."""

import numpy as np

JAW, BROWS, NOSE, BRIDGE, BASE = (
    np.arange(17),
    np.arange(17, 27),
    np.arange(27, 36),
    np.arange(27, 31),
    np.arange(31, 36),
)
EYES, MOUTH, FOREHEAD = (np.arange(36, 42), np.arange(42, 48)), np.arange(48, 68), np.arange(68, 71)
EARS, CHEEKBONES, TEMPLES = (np.arange(71, 74), np.arange(74, 77)), np.arange(77, 79), np.arange(79, 81)
SIDES = ((EYES[0], np.arange(17, 22), EARS[0], -1), (EYES[1], np.arange(22, 27), EARS[1], 1))

# Standard deviations of the random changes: logarithms of factors, or shares of the face's height where a length.
SPREAD = {
    "chin_height": 0.22, "mouth_height": 0.20, "lip_gap": 0.22, "nose_height": 0.16, "eye_height": 0.16,
    "forehead_height": 0.15, "chin_width": 0.20, "jaw_width": 0.17, "cheek_width": 0.12, "temple_width": 0.10,
    "crown_width": 0.06, "inner_width": 0.05, "chin_forward": 0.035, "nose_size": 0.24, "nose_width": 0.13,
    "nose_length": 0.12, "nose_depth": 0.12, "nose_droop": 0.035, "nose_hump": 0.012, "mouth_width": 0.22,
    "mouth_open": 0.15, "mouth_smile": 0.022, "mouth_forward": 0.015, "eye_size": 0.22, "eye_open": 0.14,
    "eye_apart": 0.018, "eye_slant": 0.12, "eye_asymmetry": 0.05, "brow_lift": 0.022, "brow_slant": 0.16,
    "brow_length": 0.10, "brow_asymmetry": 0.010, "ear_size": 0.14, "ear_out": 0.014, "ear_lift": 0.012,
    "cheek_out": 0.020, "lean": 0.012,
}  # fmt: skip
NAMES = tuple(SPREAD)
# Curvature exaggeration only ever enlarges noses and ears; the parts lean the other way, so that the mean is a face.
LEANING = {"nose_depth": -0.3, "nose_width": -0.06, "nose_droop": -0.008, "ear_size": -0.12, "ear_out": -0.006}
# The unsteady hand: a smooth random field over the face; standard deviation and correlation length in face heights.
HAND, HAND_LENGTH, HAND_ASYMMETRY = 0.022, 0.075, 0.4
LIMIT = 2.2
MIN_LIP_GAP, MIN_CHIN = 0.6, 0.5
CHIN_SHARE = np.array([0.15, 0.4, 0.7, 0.95, 1.0, 0.95, 0.7, 0.4, 0.15])
BOLD, BOLD_SHARE, TIMID = 1.45, 0.35, 0.55


def random_part_changes(generator, strength=1.0):
    """Draw how a caricaturist would change a face: a few parts boldly, the others a little.

    generator: numpy Generator. strength: multiplies all changes.
    Returns (len(NAMES),) changes in the units of ``SPREAD``.
    """
    bold = np.where(generator.random(len(NAMES)) < BOLD_SHARE, BOLD, TIMID)
    draw = np.clip(bold * generator.normal(size=len(NAMES)), -LIMIT, LIMIT)
    return strength * draw * np.array(list(SPREAD.values())) + [LEANING.get(name, 0.0) for name in NAMES]


def random_hand(landmarks, generator, strength=1.0):
    """Draw small coherent moves of all landmarks, mostly symmetric: what no named part explains.

    landmarks: (81, 3) of the face, metres. generator: numpy Generator. strength: multiplies the moves.
    Returns (81, 3) metres.
    """
    height = landmarks[69, 1] - landmarks[8, 1]
    mirrored = np.concatenate([landmarks, landmarks * [-1, 1, 1]])
    distance = np.linalg.norm(mirrored[:, None] - mirrored[None], axis=-1) / (HAND_LENGTH * height)
    correlation = np.exp(-0.5 * distance**2) + 1e-6 * np.eye(162)
    field = np.linalg.cholesky(correlation) @ generator.normal(size=(162, 3))
    own, other = field[:81], field[81:] * [-1, 1, 1]
    mixed = (own + other) / np.sqrt(2) * (1 - HAND_ASYMMETRY) + own * HAND_ASYMMETRY
    return strength * HAND * height * mixed


def move_parts(landmarks, changes):
    """Apply part changes to landmarks.

    The face is first divided by height (chin, mouth, lip gap, nose, eyes, forehead), each division stretched, so that
    parts make room for each other; then the outline gets a width profile; then nose, mouth, eyes, brows and ears are
    scaled and moved about their own centres.

    landmarks: (81, 3) metres, face frame. changes: (len(NAMES),).
    Returns (81, 3). Raises ValueError for another number of landmarks.
    """
    if landmarks.shape != (81, 3):
        raise ValueError(f"expected 81 landmarks, found {landmarks.shape}")
    c = dict(zip(NAMES, changes, strict=True))
    p = landmarks
    height, middle = p[69, 1] - p[8, 1], p[27, 0]
    q = p.copy()
    q[:, 1] = _stretch_heights(p, c)
    _widen_outline(q, p, c, height, middle)
    q[:, 0] += c["lean"] * height * np.clip((p[33, 1] - p[:, 1]) / (p[33, 1] - p[8, 1]), -1, 1)

    front = np.array([0.0, 0.0, height])
    down = np.array([0.0, -height, 0.0])
    size = c["nose_size"]
    _scale(q, NOSE, q[27], (size + c["nose_width"], 0.7 * size + c["nose_length"], 1.1 * size + c["nose_depth"]))
    q[[29, 30]] += c["nose_droop"] * (down - 0.4 * front)
    q[[28, 29]] += c["nose_hump"] * front
    # A nose that grew pushes the mouth ahead of it, and a little forwards.
    push = q[33] - p[33] - [0.0, _stretch_heights(p, c)[33] - p[33, 1], 0.0]
    _scale(q, MOUTH, q[MOUTH].mean(0), (c["mouth_width"], c["mouth_open"], 0.1 * c["mouth_width"]))
    q[MOUTH] += [0.0, 0.6, 0.25] * push + c["mouth_forward"] * front
    side = np.abs(q[MOUTH, 0] - q[MOUTH, 0].mean()) / max(np.ptp(q[MOUTH, 0]) / 2, 1e-9)
    q[MOUTH, 1] += c["mouth_smile"] * height * side**2
    # The upper lip stays below the nose, whatever the two have grown to.
    gap = q[33, 1] - q[51, 1]
    q[MOUTH, 1] -= max(MIN_LIP_GAP * (p[33, 1] - p[51, 1]) - gap, 0.0)
    # A wide mouth bends back around the teeth.
    q[MOUTH, 2] -= 0.5 * max(np.expm1(c["mouth_width"]), 0) * np.ptp(p[MOUTH, 2]) * side**2
    q[5:12] += c["chin_forward"] * front * np.array([0.3, 0.6, 0.9, 1.0, 0.9, 0.6, 0.3])[:, None]

    # The chin makes room for a mouth that went down.
    room = q[57, 1] - q[8, 1]
    q[4:13, 1] -= max(MIN_CHIN * (p[57, 1] - p[8, 1]) - room, 0.0) * CHIN_SHARE

    for eye, brow, ear, sign in SIDES:
        size = c["eye_size"] + sign * c["eye_asymmetry"]
        before = np.ptp(q[eye, 1])
        _scale(q, eye, q[eye].mean(0), (size, size + c["eye_open"], 0.3 * size))
        q[eye, 1] += sign * c["eye_slant"] * (q[eye, 0] - q[eye, 0].mean())
        grown = (np.ptp(q[eye, 1]) - before) / 2
        q[np.r_[eye, brow], 0] += sign * c["eye_apart"] * height
        _scale(q, brow, q[brow].mean(0), (c["brow_length"], 0.0, 0.0))
        q[brow, 1] += (c["brow_lift"] + sign * c["brow_asymmetry"]) * height + max(grown, 0.5 * grown)
        q[brow, 1] += sign * c["brow_slant"] * (q[brow, 0] - q[brow, 0].mean())
        _scale(q, ear, q[ear].mean(0), (0.5 * c["ear_size"], c["ear_size"], c["ear_size"]))
        q[ear] += [sign * c["ear_out"] * height, c["ear_lift"] * height, 0.0]
        q[ear[1], 0] += sign * max(c["ear_out"], 0.0) * height
    q[CHEEKBONES, 2] += c["cheek_out"] * height
    return q


def _stretch_heights(p, c):
    """New heights of all points: the divisions of the face between seven levels, each stretched by its own factor."""
    levels = p[[8, 57, 51, 33, 27], 1]
    brow, forehead = p[BROWS, 1].mean(), p[69, 1]
    levels = np.maximum.accumulate(np.r_[levels, brow, forehead] + 1e-6 * np.arange(7))
    names = ("chin_height", "mouth_height", "lip_gap", "nose_height", "eye_height", "forehead_height")
    stretch = np.array([c[n] for n in names])
    # Half of a common stretch is dropped: a longer face is one caricature of many.
    gaps = np.diff(levels) * np.exp(stretch - 0.5 * stretch.mean())
    moved = np.r_[0.0, np.cumsum(gaps)]
    # Heights stay relative to the root of the nose; beyond the ends points keep their distance to the last level.
    moved += levels[4] - moved[4]
    inside = np.interp(p[:, 1], levels, moved)
    return inside + np.minimum(p[:, 1] - levels[0], 0) + np.maximum(p[:, 1] - levels[-1], 0)


def _widen_outline(q, p, c, height, middle):
    """Scale the outline by a smooth profile over the height; ears and inner parts follow it."""
    level = (p[:, 1] - p[8, 1]) / height
    bumps = (("chin_width", 0.0, 0.12), ("jaw_width", 0.22, 0.16), ("cheek_width", 0.48, 0.2),
             ("temple_width", 0.72, 0.2), ("crown_width", 1.0, 0.22))  # fmt: skip
    profile = np.exp(sum(c[name] * np.exp(-(((level - centre) / width) ** 2)) for name, centre, width in bumps))
    outline = np.r_[JAW, FOREHEAD, CHEEKBONES, TEMPLES]
    q[outline, 0] = middle + (p[outline, 0] - middle) * profile[outline]
    for ear in EARS:
        q[ear, 0] += np.mean((p[ear, 0] - middle) * (profile[ear] - 1))
    inner = np.r_[BROWS, NOSE, EYES[0], EYES[1], MOUTH]
    q[inner, 0] = middle + (p[inner, 0] - middle) * np.exp(c["inner_width"]) * (0.6 + 0.4 * profile[inner])


def _scale(q, ids, pivot, logarithms):
    pivot = pivot.copy()
    q[ids] = pivot + (q[ids] - pivot) * np.exp(logarithms)
