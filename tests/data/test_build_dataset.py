import hashlib
import multiprocessing
import time
from dataclasses import asdict
from itertools import product

import numpy as np
import pytest

from caricli.data import build_dataset as building
from caricli.data import write_dataset as writing
from caricli.data.build_dataset import build_dataset
from caricli.data.build_settings import KINDS, OWN_KINDS, BuildSettings, OwnSettings
from caricli.data.dataset import read_dataset
from caricli.data.regular_face import regular_faces
from caricli.errors import InputError, OutputError
from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.io.outputs import staged_folder
from caricli.io.strict_json import read_json


def hashes(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def wait_for_workers(seconds=20):
    """The worker processes that are still there after a while."""
    end = time.monotonic() + seconds
    while multiprocessing.active_children() and time.monotonic() < end:
        time.sleep(0.05)
    return multiprocessing.active_children()


def test_same_bytes_again_and_with_another_number_of_workers(built, random_settings, tmp_path):
    folder, summary, calls = built
    assert calls == [(done, 12) for done in range(1, 13)]
    assert build_dataset(tmp_path, random_settings, workers=1) == summary
    assert hashes(tmp_path) == hashes(folder)
    assert set(hashes(folder)) == {"dataset.json", "labels.npz", "shard-0000.npz", "template.npz"}


def test_draws_hold_what_their_columns_say(built, head, random_settings):
    data = read_dataset(built[0])
    assert data.vertices.shape == (12, 4200, 3) and data.vertices.dtype == np.float32
    assert data.manifest["settings"] == asdict(random_settings)
    assert set(data.identity.tolist()) <= set(range(5)) and set(data.expression.tolist()) <= set(range(25))
    kind, parts, hand = (data.factors[name] for name in ("kind", "parts", "hand"))
    np.testing.assert_array_equal(kind & 1 > 0, data.level > 1)
    np.testing.assert_array_equal(kind & 2 > 0, parts.any(1))
    np.testing.assert_array_equal(kind & 2 > 0, hand.any((1, 2)))
    assert len(set(kind.tolist())) > 1
    assert data.factors["changes"].shape == (12, len(head.change_names))
    people = {i: data.factors["changes"][data.identity == i] for i in set(data.identity.tolist())}
    assert all((rows == rows[0]).all() for rows in people.values())
    assert len({rows[0].tobytes() for rows in people.values()}) == len(people)
    np.testing.assert_array_equal(data.labels[:, data.attributes.index("Caricature")], kind > 0)
    assert data.manifest["kinds"] == list(KINDS)


def test_few_triangles_are_flipped_and_the_manifest_says_how_many(built):
    folder, summary, _ = built
    data = read_dataset(folder)
    share = flipped_triangles(data.vertices.astype(float), data.template.gradients).mean()
    assert share < 1e-3
    # Rounding to float32 may turn a sliver.
    assert abs(summary["flipped"] - share) < 1e-4
    assert data.manifest["flipped"] == summary["flipped"]


def test_heads_stay_in_their_place_and_size(built):
    data = read_dataset(built[0])
    face = data.template.region("face")
    centre, size = data.vertices[:, face].mean(1), data.vertices[:, face].std((1, 2))
    assert np.linalg.norm(centre - data.template.vertices[face].mean(0), axis=1).max() < 0.15 * data.template.height
    assert (np.abs(np.log(size / data.template.vertices[face].std((0, 1)))) < 0.25).all()


def test_own_features_are_exaggerated_the_same_by_any_number_of_workers(own_built, tmp_path):
    folder, summary = own_built
    data = read_dataset(folder)
    settings = data.manifest["settings"]
    settings["strength"] = tuple(settings["strength"])
    assert settings == asdict(OwnSettings(count=10, identities=4, regular=0.3, parts=0.55))
    assert data.manifest["kinds"] == list(OWN_KINDS)
    kind = data.factors["kind"]
    assert set(kind.tolist()) == {OWN_KINDS.index(k) for k in ("regular", "own features", "own features and parts")}
    np.testing.assert_array_equal(data.regular, kind == 0)
    np.testing.assert_array_equal(kind & 2 > 0, data.factors["parts"].any(1))
    np.testing.assert_array_equal(kind & 2 > 0, data.factors["hand"].any((1, 2)))
    assert (data.level == 1).all()
    face = data.template.region("face")
    moved = np.linalg.norm(data.vertices - regular_faces(data, np.arange(10)), axis=-1)[:, face].mean(1)
    assert moved[kind == 0].max() < 1e-5 < 0.003 < moved[kind > 0].min()
    assert summary["flipped"] == data.manifest["flipped"] < 1e-3
    assert build_dataset(tmp_path, OwnSettings(count=10, identities=4, regular=0.3, parts=0.55), 2) == summary
    assert hashes(tmp_path) == hashes(folder)


def test_the_same_people_whatever_is_exaggerated(own_built, built):
    data = [read_dataset(folder) for folder in (own_built[0], built[0])]
    people = [dict(zip(each.identity.tolist(), each.factors["changes"], strict=True)) for each in data]
    shared = people[0].keys() & people[1].keys()
    assert shared
    for number in shared:
        np.testing.assert_array_equal(people[0][number], people[1][number])


def test_own_features_with_one_level_are_regular_faces(tmp_path):
    build_dataset(tmp_path, OwnSettings(count=3, identities=2, expressions=3, levels=1), 1)
    assert not read_dataset(tmp_path).factors["kind"].any()


@pytest.mark.parametrize("wrong", [{"count": None}, {"regular": -0.1}, {"regular": 1.1}, {"parts": float("nan")}])
def test_own_settings_refuse_what_cannot_be_built(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        OwnSettings(**{"count": 5} | wrong)


def test_the_grid_has_every_combination_once(grid):
    folder, summary = grid
    data = read_dataset(folder)
    rows = list(zip(data.identity.tolist(), data.expression.tolist(), data.level.tolist(), strict=True))
    assert sorted(rows) == list(product(range(2), range(3), range(1, 5)))
    assert summary["meshes"] == data.manifest["count"] == 24
    np.testing.assert_array_equal(data.factors["kind"] > 0, data.level > 1)
    assert not data.factors["parts"].any() and not data.factors["hand"].any()
    assert data.manifest["expressions"] == ["neutral", "smile", "laugh"]
    assert data.manifest["exponents"] == [0.0, 0.1, 0.2, 0.3]


def test_levels_of_the_grid_go_further_and_further_from_the_face(grid):
    data = read_dataset(grid[0])
    for identity, expression in product(range(2), range(3)):
        rows = np.flatnonzero((data.identity == identity) & (data.expression == expression))
        rows = rows[np.argsort(data.level[rows])]
        moved = np.linalg.norm(data.vertices[rows] - data.vertices[rows[0]], axis=-1).mean(1)
        assert moved[0] == 0 and (np.diff(moved) > 1e-4).all()


def test_the_first_level_of_a_neutral_face_is_the_aligned_person(grid, head):
    data = read_dataset(grid[0])
    face = data.template.region("face")
    row = np.flatnonzero((data.identity == 1) & (data.expression == 0) & (data.level == 1))[0]
    factors = data.factors
    changes = dict(zip(head.change_names, factors["changes"][row].astype(float), strict=True))
    neutral = head.evaluate(factors["gender"][row], factors["age"][row], factors["weight"][row], changes)
    from caricli.geometry.alignment.similarity import similarity

    scale, rotation, translation = similarity(neutral[face], data.template.vertices[face])
    aligned = scale * neutral @ rotation.T + translation
    np.testing.assert_allclose(data.vertices[row][face], aligned[face], atol=1e-5)


def test_random_draws_of_one_level_are_regular_faces(tmp_path):
    build_dataset(tmp_path, BuildSettings(count=4, identities=2, expressions=3, levels=1), 1)
    data = read_dataset(tmp_path)
    assert not data.factors["kind"].any() and (data.level == 1).all() and not data.factors["parts"].any()
    again = regular_faces(data, np.arange(4))
    face = data.template.region("face")
    np.testing.assert_allclose(data.vertices[:, face], again[:, face], atol=1e-5)


def test_the_manifest_is_written_last_and_its_hashes_are_right(grid, monkeypatch, tmp_path, barrel):
    folder, _ = grid
    manifest, found = read_json(folder / "dataset.json"), hashes(folder)
    entries = [*manifest["shards"], manifest["template"], manifest["labels"]]
    assert {entry["file"]: entry["sha256"] for entry in entries} == {
        name: value for name, value in found.items() if name != "dataset.json"
    }
    written = []
    for name in ("write_npz", "write_json"):
        original = getattr(writing, name)
        monkeypatch.setattr(
            writing, name, lambda path, value, real=original: (written.append(path.name), real(path, value))
        )
    column = np.zeros(2, dtype=np.int32)
    shard = {"vertices": np.zeros((2, 62, 3)), "identity": column, "expression": column, "level": column}
    writer = writing.DatasetWriter(tmp_path, barrel.template)
    writer.add_shard(shard)
    writer.add_shard(shard)
    writer.finish({}, {"labels": column})
    assert written == ["template.npz", "shard-0000.npz", "shard-0001.npz", "labels.npz", "dataset.json"]


def test_an_interrupted_build_leaves_nothing(tmp_path):
    seen = []

    def interrupt(done, total):
        seen.extend(path.name for path in tmp_path.iterdir())
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), staged_folder(tmp_path / "new" / "out") as folder:
        build_dataset(folder, BuildSettings(identities=1, expressions=2, levels=1), 2, interrupt)
    assert seen == ["new"]
    assert list(tmp_path.iterdir()) == []
    assert wait_for_workers() == []


def test_a_full_disk_ends_the_build_and_its_workers(tmp_path, monkeypatch):
    monkeypatch.setattr(building, "SHARD_SIZE", 2)
    real = writing.write_npz

    def full(path, arrays):
        if path.name == "shard-0001.npz":
            raise OSError(28, "No space left on device", str(path))
        real(path, arrays)

    monkeypatch.setattr(writing, "write_npz", full)
    with pytest.raises(OutputError, match="No space left"), staged_folder(tmp_path / "out") as folder:
        build_dataset(folder, BuildSettings(identities=1, expressions=25, levels=1), 1)
    assert list(tmp_path.iterdir()) == []
    assert wait_for_workers() == []


@pytest.mark.parametrize(
    "sizes", [{"identities": 0}, {"expressions": 26}, {"levels": 0}, {"levels": 5}, {"count": 0}, {"count": -3}]
)
def test_settings_refuse_what_cannot_be_built(sizes):
    with pytest.raises(InputError, match=next(iter(sizes))):
        BuildSettings(**sizes)


def test_settings_take_their_limits():
    settings = BuildSettings(count=1, identities=1, expressions=25, levels=4)
    assert asdict(settings) == {"count": 1, "identities": 1, "expressions": 25, "levels": 4, "seed": 0}
    assert BuildSettings().count is None
