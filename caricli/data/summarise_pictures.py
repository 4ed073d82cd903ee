"""What a folder of pictures holds, in a few lines."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from caricli.data.dataset import SPLITS
from caricli.data.picture_set import PictureSet


def summarise_pictures(pictures: PictureSet) -> list[str]:
    """Lines about pictures, faces, media and splits."""
    truth = pictures.truth
    faces = np.bincount(truth["picture"], minlength=pictures.count)
    media = Counter(pictures.media).most_common()
    if len(truth["picture"]):
        low, high = np.percentile(np.ptp(truth["landmarks"], axis=1).max(1), (5, 95))
        seen = 100 * truth["visible"].mean()
        shown = [f"landmarks: boxes of {low:.0f} to {high:.0f} pixels (5 to 95 %), {seen:.1f} % visible"]
    else:
        shown = []
    counts = (f"{len(pictures.pictures_of(split))} {split}" for split in SPLITS)
    return [
        f"pictures: {pictures.count}, of {len(np.unique(truth['person']))} people",
        f"faces: {faces.sum()}; none in {(faces == 0).sum()} pictures, several in {(faces > 1).sum()}",
        *shown,
        f"splits: {', '.join(counts)}",
        f"made as: {', '.join(f'{count} {medium}' for medium, count in media)}",
    ]


def chosen_pictures(
    pictures: PictureSet, count: int, generator: np.random.Generator
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Some pictures at random: the picture, its Regions, landmarks (N, 2) of all its faces, and which are visible."""
    for number in np.sort(generator.choice(pictures.count, min(count, pictures.count), replace=False)):
        faces = pictures.faces(number)
        points = pictures.truth["landmarks"][faces].reshape(-1, 2)
        visible = pictures.truth["visible"][faces].ravel()
        yield pictures.picture(number), pictures.regions(number), points, visible
