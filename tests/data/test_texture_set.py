import numpy as np

from caricli.data.dataset import SPLITS
from caricli.data.texture_set import ActedTextures, TextureWriter, read_texture_set
from caricli.io import npz
from caricli.structures.arkit import ARKIT_NAMES

SIDE, SHOWN, POINTS = 8, 2, 10


def acted(number):
    """A person of one grey."""
    return ActedTextures(
        pictures=np.full((SHOWN, SIDE, SIDE, 3), number, np.uint8),
        seen=np.ones((SHOWN, SIDE, SIDE), bool),
        weights=np.zeros((SHOWN, len(ARKIT_NAMES)), np.float32),
        vertices=np.zeros((SHOWN, POINTS, 3), np.float32),
        neutral=np.zeros((POINTS, 3), np.float32),
        person=number,
        level=1,
        split="train",
        age=0.5,
    )


def test_people_too_large_for_one_file_are_written_into_several(tmp_path, monkeypatch):
    """Of a file a tenth is left free: 1,300 bytes a person are three times in 4,500."""
    monkeypatch.setattr(npz, "MAX_NPZ_BYTES", 4500)
    writer = TextureWriter(tmp_path)
    for number in range(8):
        writer.add(acted(number))
    writer.finish({"size": SIDE, "expressions": SHOWN, "splits": dict.fromkeys(SPLITS, []) | {"train": [*range(8)]}})
    monkeypatch.undo()
    textures = read_texture_set(tmp_path)
    assert [entry["count"] for entry in textures.manifest["shards"]] == [3, 3, 2]
    assert [one.pictures[0, 0, 0, 0] for one in textures.people("train")] == [*range(8)]
