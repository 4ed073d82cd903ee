import shutil
from dataclasses import replace

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.data.regular_face import regular_faces
from caricli.data.texture_set import TextureWriter, read_texture_set
from caricli.data.unseen import people_entry
from caricli.errors import InputError
from caricli.methods.creases.build_textures import TextureSetSettings, build_textures
from caricli.structures.arkit import ARKIT_NAMES

OPTIONS = ("--count", 2, "--expressions", 3, "--size", 48, "--seed", 3)


@pytest.fixture(scope="module")
def folder(run, dataset, tmp_path_factory):
    out = tmp_path_factory.mktemp("textures") / "textures"
    result = run("dataset", "textures", dataset, out, *OPTIONS, "--workers", 2)
    assert result.exit_code == 0, result.output
    return out


def test_the_same_seed_gives_the_same_bytes_whatever_the_number_of_workers(run, dataset, folder, tmp_path):
    again = tmp_path / "again"
    assert run("dataset", "textures", dataset, again, *OPTIONS, "--workers", 1).exit_code == 0
    files = sorted(path.name for path in folder.iterdir())
    assert files == ["shard-0000.npz", "textures.json"]
    assert all((folder / file).read_bytes() == (again / file).read_bytes() for file in files)


def test_what_people_show(dataset, folder):
    people = read_dataset(dataset)
    textures = read_texture_set(folder)
    acted = list(textures.people())
    assert len(acted) == textures.count == 2
    assert people_entry(people).items() <= textures.manifest.items()
    assert {one.split for one in acted} == {"train", "test"}
    for one in acted:
        assert one.pictures.shape == (3, 48, 48, 3) and 0.1 < one.seen.mean() < 0.8
        assert one.weights.shape == (3, len(ARKIT_NAMES)) and not one.weights[0].any() and one.weights[1:].any(1).all()
        assert one.person in people.manifest["splits"][one.split] and 0 <= one.age <= 1
        np.testing.assert_array_equal(one.vertices[0], one.neutral)
        assert (np.abs(one.vertices[1:] - one.neutral).max((1, 2)) > 1e-3).all()
        # Of the same person in the same light, textures are alike where little moves.
        apart = np.abs(one.pictures.astype(int) - one.pictures[0]).max(-1)
        assert np.median(apart[one.seen & one.seen[0]]) < 12
        if one.level == 1:
            row = int(np.flatnonzero(people.identity == one.person)[0])
            regular = people.template.cavities.tuck(regular_faces(people, np.array([row]), 0)[0])
            np.testing.assert_allclose(one.neutral, regular, atol=1e-6)


def test_textures_are_shown(run, folder, tmp_path):
    result = run("dataset", "show", folder, "-o", tmp_path / "sheet.png", "--faces", 2)
    assert result.exit_code == 0 and "3 expressions of each" in result.output, result.output


def test_people_who_were_imported_are_refused(dataset, tmp_path):
    imported = replace(read_dataset(dataset), factors={})
    with pytest.raises(InputError, match="imported"):
        build_textures(TextureWriter(tmp_path), imported, TextureSetSettings(1))


def test_a_changed_file_is_refused(folder, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    with open(copy / "shard-0000.npz", "ab") as stream:
        stream.write(b"x")
    with pytest.raises(InputError, match="the file was changed"):
        read_texture_set(copy).shard(0)
