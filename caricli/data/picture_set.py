"""A folder of pictures with all that is known of them."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from caricli.data.dataset import SPLITS, read_manifest, read_named
from caricli.errors import InputError, naming
from caricli.io.image import read_image
from caricli.io.npz import take_array, write_npz
from caricli.io.outputs import write_bytes
from caricli.io.provenance import sha256_file, sha256_files
from caricli.io.strict_json import take, take_whole, write_json
from caricli.limits import MAX_VERTICES
from caricli.structures.checks import number_problem, refuse
from caricli.structures.parsing import Region

SCHEMA = "caricli.pictures/1"
MANIFEST = "pictures.json"
TRUTH = "truth.npz"
QUALITY = 92
"""Of the JPEG files."""

COLUMNS: dict[str, tuple[str, tuple[int | None, ...]]] = {
    "picture": ("iu", ()),
    "landmarks": ("f", (None, 2)),
    "visible": ("b", (None,)),
    "person": ("iu", ()),
    "expression": ("iu", ()),
    "level": ("iu", ()),
    "rotation": ("f", (3, 3)),
    "scale": ("f", ()),
    "translation": ("f", (2,)),
    "perspective": ("f", ()),
    "light": ("f", (9, 3)),
    "coefficients": ("f", (None,)),
}
"""Of the truth, a row for every face: kinds and shapes of the columns after the row."""


@dataclass(frozen=True, eq=False)
class PictureSet:
    """Pictures, what they show, and the faces in them.

    folder: where they are. manifest: JSON object. count: pictures. media: (count,) names, what each is made with.
    truth: columns by the names of COLUMNS, a row for every face, those of a picture together, its largest first:
    ``picture`` its number; ``landmarks`` (M, L, 2) pixels, x right, y down, (0, 0) the centre of the top left pixel;
    ``visible`` (M, L); ``person``, ``expression``, ``level`` of the dataset; ``rotation``, ``scale`` (pixels a metre),
    ``translation`` (pixels) and ``perspective`` of the camera; ``light`` (M, 9, 3) spherical harmonics in its axes;
    ``coefficients`` (M, C): identity, expression and albedo of the morphable model, nine of light, and pitch, yaw and
    roll in radians, place (pixels) and scale.
    """

    folder: Path
    manifest: dict[str, Any]
    count: int
    media: tuple[str, ...]
    truth: dict[str, np.ndarray]

    def picture(self, number: int) -> np.ndarray:
        """(H, W, 3) uint8. Raises InputError when the file is missing or damaged."""
        return read_image(self.folder / picture_name(number))

    def regions(self, number: int) -> np.ndarray:
        """(H, W) uint8 Region. Raises InputError when the file is missing or damaged."""
        labels = read_image(self.folder / labels_name(number))[..., 0]
        if labels.max(initial=0) > max(Region):
            raise InputError(f"{self.folder / labels_name(number)}: expected labels up to {max(Region)}, found others")
        return labels

    def faces(self, number: int) -> np.ndarray:
        """Rows of the truth that are faces of a picture."""
        # Of a column's own type, or each call would convert the column.
        column = self.truth["picture"]
        return np.arange(*np.searchsorted(column, np.array([number, number + 1], column.dtype)))

    @property
    def missing(self) -> int:
        """How many pictures are not there with their label maps."""
        return sum(not all(path.is_file() for path in _files(self.folder, k)) for k in range(self.count))

    @property
    def changed(self) -> bool:
        """Whether pictures or label maps, which are all there, are others than the manifest says, if it says it."""
        digest = self.manifest.get("sha256")
        return digest is not None and digest != _sha256(self.folder, self.count)

    def pictures_of(self, split: str) -> np.ndarray:
        """Numbers of the pictures that show nobody but people of a split of the dataset, or nobody."""
        people = self.manifest["splits"][split]
        others = self.truth["picture"][~np.isin(self.truth["person"], people)]
        empty = np.setdiff1d(np.arange(self.count), self.truth["picture"])
        # Pictures of nobody are shared out as the people are.
        shares = np.cumsum([0, *(len(self.manifest["splits"][name]) for name in SPLITS)])
        place = SPLITS.index(split)
        limits = (len(empty) * shares / max(shares[-1], 1)).round().astype(int)
        own = np.setdiff1d(np.unique(self.truth["picture"]), others)
        return np.union1d(own, empty[limits[place] : limits[place + 1]])


def picture_name(number: int) -> str:
    """The file of a picture in its folder."""
    return f"pictures/{number:06d}.jpg"


def labels_name(number: int) -> str:
    """The file of a label map in its folder."""
    return f"labels/{number:06d}.png"


def _files(folder: Path, number: int) -> tuple[Path, Path]:
    return folder / picture_name(number), folder / labels_name(number)


def _sha256(folder: Path, count: int) -> str:
    """Of all pictures with their label maps, in their order."""
    return sha256_files(path for number in range(count) for path in _files(folder, number))


class PictureWriter:
    """Writes pictures into an empty folder, the manifest last: without it the folder is none."""

    def __init__(self, folder: Path) -> None:
        """folder: Path."""
        self.folder = folder
        self.count = 0
        self.media: list[str] = []
        self.rows: list[Mapping[str, Any]] = []
        for name in ("pictures", "labels"):
            (folder / name).mkdir(parents=True)

    def add(self, image: bytes, labels: bytes, medium: str, faces: Sequence[Mapping[str, Any]]) -> None:
        """Write one picture. image: JPEG. labels: PNG. faces: COLUMNS but ``picture``."""
        write_bytes(self.folder / picture_name(self.count), image)
        write_bytes(self.folder / labels_name(self.count), labels)
        self.rows += [{**face, "picture": self.count} for face in faces]
        self.media.append(medium)
        self.count += 1

    def finish(self, manifest: Mapping[str, Any]) -> None:
        """Write truth and manifest. manifest: its entries beside those that every folder of pictures has."""
        arrays = {}
        for name, (kind, shape) in COLUMNS.items():
            kinds = {"f": np.float32, "iu": np.int32, "b": bool}
            values = np.array([row[name] for row in self.rows], kinds[kind])
            arrays[name] = values if self.rows else values.reshape(0, *(length or 0 for length in shape))
        write_npz(self.folder / TRUTH, arrays)
        value = {
            "schema": SCHEMA,
            "count": self.count,
            **manifest,
            "regions": [region.name.lower() for region in Region],
            "truth": {"file": TRUTH, "sha256": sha256_file(self.folder / TRUTH)},
            "sha256": _sha256(self.folder, self.count),
            "media": self.media,
        }
        write_json(self.folder / MANIFEST, value)


def encode_picture(image: np.ndarray) -> bytes:
    """A picture (H, W, 3) uint8 as JPEG."""
    return _encoded(image, "JPEG", quality=QUALITY)


def encode_labels(region: np.ndarray) -> bytes:
    """A label map (H, W) uint8 as PNG."""
    return _encoded(region, "PNG")


def _encoded(array: np.ndarray, kind: str, **settings: int) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(array)).save(stream, kind, **settings)
    return stream.getvalue()


def read_picture_set(folder: Path) -> PictureSet:
    """Read a folder of pictures; the pictures themselves are read when they are asked for.

    Raises InputError when a part is missing, damaged or does not fit the others.
    """
    folder = Path(folder)
    manifest = read_manifest(folder, MANIFEST, SCHEMA, "a folder of pictures")
    with naming(folder / MANIFEST):
        count = take_whole(manifest, "count", 1, MAX_VERTICES)
        media = tuple(map(str, take(manifest, "media", list)))
        entry = take(manifest, "truth", dict)
        if len(media) != count:
            raise InputError(f"media: expected one for each of {count} pictures, found {len(media)}")
    arrays = read_named(folder, entry, MANIFEST)
    with naming(folder / entry["file"]):
        return PictureSet(folder, manifest, count, media, _checked_truth(arrays, count))


def _checked_truth(arrays: Mapping[str, np.ndarray], count: int) -> dict[str, np.ndarray]:
    rows = len(take_array(arrays, "picture", "iu", (None,)))
    truth = {name: take_array(arrays, name, kind, (rows, *shape)) for name, (kind, shape) in COLUMNS.items()}
    for name, column in truth.items():
        if column.dtype.kind == "f":
            refuse(number_problem(name, column))
    if truth["visible"].shape[1] != truth["landmarks"].shape[1]:
        raise InputError("visible: expected a value for every landmark, found others")
    numbers = truth["picture"]
    if rows and (numbers.min() < 0 or numbers.max() >= count or (np.diff(numbers.astype(np.int64)) < 0).any()):
        raise InputError(f"picture: expected ascending numbers below {count}, found others")
    return truth
