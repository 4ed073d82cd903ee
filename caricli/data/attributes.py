"""Semantic attributes of a face, measured on its landmarks."""

import numpy as np

# A mesh has an attribute when it is measured above this quantile of the training meshes.
QUANTILE = 0.75


def measure_attributes(vertices, template, gender=None, age=None, exaggerated=None):
    """Measure attributes under the names of WebCariA (Ji et al. 2020); larger means more of it.

    vertices: (V, 3) metres. template: Template with 81 landmarks. gender (1 is female), age: in [0, 1] and exaggerated:
    0 or 1, where known.
    Returns dict from names to numbers; lengths are divided by the size of the face.
    """
    note = template.annotation
    p = vertices[note.landmarks]
    ends = np.array([path[0] for path in note.jaw_paths])

    def gap(a, b):
        return float(np.linalg.norm(p[a] - p[b]))

    width, height = gap(2, 14), float(p[27, 1] - p[8, 1])
    size = np.sqrt(width * max(height, 1e-9))
    brow = p[17:27, 1].mean()
    nose = (gap(31, 35) * gap(27, 33) * max(p[30, 2] - p[[31, 35], 2].mean(), 1e-9)) ** (1 / 3) / size
    # How far the bridge stands before the line from root to tip, and how far the tip hangs.
    line = p[27] + (p[30] - p[27]) * ((p[28:30, 1] - p[27, 1]) / (p[30, 1] - p[27, 1]))[:, None]
    hook = ((p[28:30, 2] - line[:, 2]).mean() + 0.5 * (p[33, 1] - p[30, 1])) / size
    eye_width = (gap(36, 39) + gap(42, 45)) / 2
    eye_height = (gap(37, 41) + gap(38, 40) + gap(43, 47) + gap(44, 46)) / 4
    eye = np.sqrt(eye_width * eye_height) / size
    mouth, lips = gap(48, 54), (gap(51, 62) + gap(57, 66)) / 2
    # Lips that went through each other are less than closed.
    opening = float(p[62, 1] - p[66, 1])
    corners = (p[[48, 54], 1].mean() - p[[51, 57, 62, 66], 1].mean()) / mouth
    forehead = (p[69, 1] - brow) / size
    jaw, chin = gap(4, 12), gap(6, 10)
    arch = ((p[19, 1] + p[24, 1]) - p[[17, 21, 22, 26], 1].sum() / 2) / (gap(17, 21) + gap(22, 26))
    ears = (gap(71, 73) + gap(74, 76)) / 2 / size
    measures = {
        "BigNose": nose, "SmallNose": -nose, "WideNose": gap(31, 35) / size, "LongNose": gap(27, 33) / size,
        "HookNose": hook, "BigMouth": mouth / size, "SmallMouth": -mouth / size, "ThickLips": lips / size,
        "ThinLips": -lips / size, "MouthOpen": opening / size, "Smile": corners, "Frown": -corners,
        "BigEye": eye, "SmallEye": -eye, "NarrowEye": -eye_height / eye_width, "WideSetEyes": gap(39, 42) / size,
        "LargeForehead": forehead, "SmallForehead": -forehead, "SquareJaw": jaw / gap(2, 14) + 0.5 * chin / jaw,
        "PointedChin": -chin / jaw, "LongChin": float(p[57, 1] - p[8, 1]) / size,
        "HighCheekbones": gap(77, 78) / jaw + (p[77:79, 2].mean() - p[[4, 12], 2].mean()) / size,
        "RoundFace": width / height, "LongFace": -width / height,
        "DoubleChin": (p[8, 1] - vertices[ends[7:10], 1].mean()) / size,
        "ArchedEyebrows": arch, "RaisedEyebrows": (brow - p[36:48, 1].mean()) / size, "BigEar": ears,
        "ProtrudingEars": gap(72, 75) / gap(0, 16),
    }  # fmt: skip
    if gender is not None:
        measures["Women"] = gender
    if age is not None:
        measures |= {"Youth": -age, "Old": age}
    if exaggerated is not None:
        measures["Caricature"] = float(exaggerated)
    return {name: float(value) for name, value in measures.items()}


def binary_labels(measures, names, training):
    """Turn measures into labels by comparing them with the training meshes.

    measures: (N, A). names: A names. training: (N,) bool.
    Returns (labels (N, A) bool, thresholds (A,)).
    """
    thresholds = np.quantile(measures[training], QUANTILE, axis=0)
    for name in ("Women", "Caricature"):
        if name in names:
            thresholds[list(names).index(name)] = 0.5
    return measures > thresholds, thresholds
