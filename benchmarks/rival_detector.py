"""MediaPipe's landmarks on pictures whose landmarks are known, by the measures of `caricli evaluate detector`.

Usage: RIVALS/bin/python benchmarks/rival_detector.py FOLDER [--count N] [--drawn lines|pencil]. FOLDER is of `caricli
dataset pictures`, of which pictures of test people with one face count, or holds pictures and landmarks (68 lines of x
and y) of the same names. MediaPipe with weights wants another NumPy than caricli, so it has an environment of its own:

    python -m venv RIVALS && RIVALS/bin/pip install mediapipe==0.10.14 'numpy<2'

Its mesh has no landmarks of iBUG; the vertices that are commonly taken for them are. It looks at every picture as it is
and enlarged twofold, for up to four faces, of which the nearest to the truth counts.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

# fmt: off
VERTICES = (
    162, 234, 93, 58, 172, 136, 149, 148, 152, 377, 378, 365, 397, 288, 323, 454, 389,
    71, 63, 105, 66, 107, 336, 296, 334, 293, 301, 168, 197, 5, 4, 75, 97, 2, 326, 305,
    33, 160, 158, 133, 153, 144, 362, 385, 387, 263, 373, 380,
    61, 39, 37, 0, 267, 269, 291, 405, 314, 17, 84, 181, 78, 82, 13, 312, 308, 317, 14, 87,
)
# fmt: on
"""Of MediaPipe's mesh, for the 68 landmarks of iBUG."""

PARTS = {"jaw": (0, 17), "brows": (17, 27), "nose": (27, 36), "eyes": (36, 48), "mouth": (48, 68), "all": (0, 68)}
FAILED = 8.0
"""Percent of the diagonal from which on a face counts as failed."""


def generated(folder: Path, count: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pictures of one test person each, with 68 landmarks."""
    test = json.loads((folder / "pictures.json").read_text())["splits"]["test"]
    truth = np.load(folder / "truth.npz")
    numbers = truth["picture"]
    alone = np.bincount(numbers)[numbers] == 1
    chosen = np.flatnonzero(alone & np.isin(truth["person"], test) & (truth["visible"].mean(1) >= 0.25))
    for row in chosen[:count]:
        yield cv2.imread(str(folder / "pictures" / f"{numbers[row]:06d}.jpg")), truth["landmarks"][row, :68]


def marked(folder: Path, count: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pictures with landmark files of the same names."""
    for file in sorted(folder.glob("*.txt"))[:count]:
        picture = next((path for path in sorted(folder.glob(f"{file.stem}.*")) if path.suffix != ".txt"), None)
        if picture is not None:
            yield cv2.imread(str(picture)), np.loadtxt(file)


def drawn(image: np.ndarray, means: str | None) -> np.ndarray:
    """A picture as lines (difference of Gaussians) or in pencil (divided by its blur), or as it is."""
    if means is None:
        return image
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32) / 255
    size = max(image.shape) / 256
    if means == "lines":
        change = cv2.GaussianBlur(grey, (0, 0), 0.8 * size) - 0.98 * cv2.GaussianBlur(grey, (0, 0), 1.3 * size)
        lines = np.where(change > 0, 1.0, 1 + np.tanh(60 * change))
    else:
        lines = np.clip(grey / np.maximum(cv2.GaussianBlur(grey, (0, 0), 4 * size), 0.05), 0, 1) ** 2
    return cv2.cvtColor(np.rint(255 * lines).astype(np.uint8), cv2.COLOR_GRAY2BGR)


def measure(pairs: Iterator[tuple[np.ndarray, np.ndarray]], means: str | None) -> dict:
    """Errors by part in percent of the diagonal, of the faces that were found, and the share that failed."""
    import mediapipe

    mesh = mediapipe.solutions.face_mesh.FaceMesh(
        static_image_mode=True, max_num_faces=4, refine_landmarks=True, min_detection_confidence=0.3
    )
    rows = []
    total = 0
    for image, truth in pairs:
        total += 1
        image = drawn(image, means)
        faces = []
        for scale in (1, 2):
            larger = cv2.resize(image, None, fx=scale, fy=scale)
            seen = mesh.process(cv2.cvtColor(larger, cv2.COLOR_BGR2RGB)).multi_face_landmarks or []
            faces += [np.array([(one.landmark[k].x, one.landmark[k].y) for k in VERTICES]) for one in seen]
        size = np.array([image.shape[1], image.shape[0]])
        errors = [np.linalg.norm(face * size - 0.5 - truth, axis=1) for face in faces]
        if errors:
            nearest = min(errors, key=np.mean)
            rows.append(100 * nearest / np.linalg.norm(np.ptp(truth, axis=0)))
    figures = {part: float(np.mean([row[a:b].mean() for row in rows])) for part, (a, b) in PARTS.items()}
    failed = total - sum(bool(row.mean() <= FAILED) for row in rows)
    return {"faces": total, "found": len(rows), "failed": failed, "nme": figures}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--drawn", choices=("lines", "pencil"))
    options = parser.parse_args()
    source = generated if (options.folder / "pictures.json").is_file() else marked
    print(json.dumps(measure(source(options.folder, options.count), options.drawn)))
