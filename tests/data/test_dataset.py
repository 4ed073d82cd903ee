from dataclasses import replace

import numpy as np
import pytest

from caricli.data import dataset, picture_set, sketch_set, texture_set
from caricli.data.dataset import SPLITS, read_dataset, split_identities, split_names
from caricli.errors import CaricliError, InputError
from caricli.io.npz import read_npz, write_npz
from caricli.io.provenance import sha256_file
from caricli.io.strict_json import read_json, write_json


def rewrite_shard(folder, change):
    """Change a shard and make its hash right again."""
    shard = read_npz(folder / "shard-0000.npz")
    change(shard)
    write_npz(folder / "shard-0000.npz", shard)
    manifest = read_json(folder / "dataset.json")
    manifest["shards"][0]["sha256"] = sha256_file(folder / "shard-0000.npz")
    write_json(folder / "dataset.json", manifest)


def rewrite_manifest(folder, change):
    manifest = read_json(folder / "dataset.json")
    change(manifest)
    write_json(folder / "dataset.json", manifest)


def test_reads_what_was_written(grid, copy_of_grid):
    data, copy = read_dataset(grid[0]), read_dataset(copy_of_grid)
    np.testing.assert_array_equal(data.vertices, copy.vertices)
    assert data.vertices.shape == (24, 4200, 3) and np.isfinite(data.vertices).all()
    assert len(data.attributes) == data.labels.shape[1] == data.measures.shape[1]
    assert data.labels.dtype == bool
    assert data.template.uvs is not None and data.template.annotation.has_extra
    assert sum(data.rows(split).sum() for split in SPLITS) == 24


def test_what_is_exaggerated_by_parts_alone_is_not_regular(grid):
    data = replace(read_dataset(grid[0]), level=np.array([1, 1, 3, 3]), factors={"kind": np.array([0, 2, 1, 3])})
    assert data.regular.tolist() == [True, False, False, False]
    assert replace(data, factors={}).regular.tolist() == [True, True, False, False]


def test_rewriting_without_a_change_is_still_a_dataset(copy_of_grid):
    rewrite_shard(copy_of_grid, lambda shard: None)
    rewrite_manifest(copy_of_grid, lambda manifest: None)
    assert len(read_dataset(copy_of_grid).vertices) == 24


def test_refuses_a_missing_manifest(copy_of_grid, tmp_path):
    (copy_of_grid / "dataset.json").unlink()
    with pytest.raises(InputError, match="no dataset.json"):
        read_dataset(copy_of_grid)
    with pytest.raises(InputError, match="none"):
        read_dataset(tmp_path / "none")


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (picture_set, "a folder of `caricli dataset pictures`"),
        (sketch_set, "a folder of `caricli dataset sketches`"),
        (texture_set, "a folder of `caricli dataset textures`"),
    ],
)
def test_other_folders_are_told(tmp_path, other, said):
    write_json(tmp_path / other.MANIFEST, {"schema": other.SCHEMA})
    with pytest.raises(InputError, match=f"{tmp_path.name}: expected a dataset, found {said}$"):
        read_dataset(tmp_path)
    (tmp_path / other.MANIFEST).rename(tmp_path / dataset.MANIFEST)
    with pytest.raises(InputError, match="expected a folder of pictures, found a dataset$"):
        picture_set.read_picture_set(tmp_path)


@pytest.mark.parametrize("name", ["shard-0000.npz", "labels.npz", "template.npz"])
def test_refuses_a_changed_or_missing_file(copy_of_grid, name):
    path = copy_of_grid / name
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"{name}.*SHA-256"):
        read_dataset(copy_of_grid)
    path.unlink()
    with pytest.raises(InputError, match=name):
        read_dataset(copy_of_grid)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda s: s.update(vertices=s["vertices"][:, :-1]),
            r"vertices: expected .* \(24,4200,3\), found float32 \(24, 4199",
        ),
        (lambda s: s.update(vertices=s["vertices"][..., :2]), "vertices: expected"),
        (lambda s: s.update(vertices=s["vertices"][:-1]), "vertices: expected"),
        (lambda s: s.update(vertices=s["vertices"].reshape(24, -1)), "vertices: expected"),
        (lambda s: s.update(vertices=s["vertices"].astype("<U4")), "vertices: expected"),
        (lambda s: s["vertices"].__setitem__((3, 7, 1), np.nan), "finite"),
        (lambda s: s["vertices"].__setitem__((3, 7, 1), np.inf), "finite"),
        (lambda s: s.update(gender=s["gender"][:-1]), "gender: expected 24 rows"),
        (lambda s: s.update(gender=np.float32(0.5)), "gender: expected 24 rows"),
        (lambda s: s.update(gender=np.full(24, 1e30)), "gender: expected finite numbers"),
        (lambda s: s.pop("identity"), "expected identity, found none"),
        (lambda s: s.pop("expression"), "expected expression, found none"),
        (lambda s: s["identity"].__setitem__(0, 77), "splits: expected everybody of the meshes in one"),
    ],
)
def test_refuses_shards_that_do_not_fit(copy_of_grid, change, said):
    rewrite_shard(copy_of_grid, change)
    with pytest.raises(InputError, match=said):
        read_dataset(copy_of_grid)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda m: m.update(schema="caricli.dataset/2"), "caricli.dataset/1.*found 'caricli.dataset/2'"),
        (lambda m: m.pop("schema"), "schema"),
        (lambda m: m["shards"][0].update(file="../shard-0000.npz"), "own folder"),
        (lambda m: m["shards"][0].update(file="/etc/hostname"), "own folder"),
        (lambda m: m["labels"].update(file="sub/labels.npz"), "own folder"),
        (lambda m: m["template"].update(file=".."), "found a folder"),
        (lambda m: m["template"].update(file=7), "own folder"),
        (
            lambda m: m["splits"].update(test=[0, 1], train=[0]),
            "splits: expected everybody in one of train, validation, test",
        ),
        (
            lambda m: m["splits"].update(train=[0, 1], test=[1]),
            "splits: expected everybody in one of train, validation, test",
        ),
        (lambda m: m["splits"].update(train=[0], test=[]), "splits: expected everybody of the meshes in one"),
        (lambda m: m["splits"].pop("validation"), "splits: expected lists of people for train"),
        (lambda m: m.update(splits=None), "splits: expected dict"),
        (lambda m: m.update(shards=[]), "shards: expected at least one"),
        (lambda m: m["shards"].extend(m["shards"]), "shards: expected at least one, each once"),
        (lambda m: m.update(shards=[1]), "shards: expected objects"),
        (lambda m: m.update(topology_id="0" * 64), "expected the faces that dataset.json tells"),
        (lambda m: m["annotation"].pop("ibug68"), "ibug68"),
        (lambda m: m["annotation"]["ibug68"].__setitem__(0, 4200), "ibug68"),
    ],
)
def test_refuses_manifests_that_do_not_fit(copy_of_grid, change, said):
    rewrite_manifest(copy_of_grid, change)
    with pytest.raises(InputError, match=said):
        read_dataset(copy_of_grid)


@pytest.mark.parametrize("content", [b"", b"[]", b"<html></html>", b'{"schema": NaN}', b"\x80\x04abc"])
def test_refuses_rubbish_as_manifest(copy_of_grid, content):
    (copy_of_grid / "dataset.json").write_bytes(content)
    with pytest.raises(CaricliError, match="dataset.json"):
        read_dataset(copy_of_grid)


@pytest.mark.parametrize("count", [3, 4, 12, 150, 1000])
def test_splits_are_disjoint_complete_and_of_the_right_size(count):
    people = np.arange(7, 7 + count)
    splits = split_identities(people, np.random.default_rng(count))
    assert sorted(i for part in splits.values() for i in part) == people.tolist()
    assert all(splits.values())
    for split, share in zip(SPLITS, (0.9, 0.01, 0.09), strict=True):
        assert abs(len(splits[split]) - share * count) <= 2
        assert splits[split] == sorted(splits[split])


def test_splits_of_one_and_two_people_always_train():
    assert split_identities([4], np.random.default_rng(0)) == {"train": [4], "validation": [], "test": []}
    splits = split_identities([4, 5], np.random.default_rng(0))
    assert len(splits["train"]) == len(splits["test"]) == 1


def test_no_person_is_in_two_splits_of_a_built_dataset(built):
    data = read_dataset(built[0])
    people = [set(data.identity[data.rows(split)].tolist()) for split in SPLITS]
    assert people[0].isdisjoint(people[1] | people[2]) and people[1].isdisjoint(people[2])
    assert all(data.manifest["splits"].values())


@pytest.mark.parametrize("count", [4, 20, 33, 100])
def test_somebody_more_leaves_the_others_in_their_splits(count):
    names = [f"p{k}" for k in range(count)]
    of = [{names[k]: split for split, own in split_names(names, 0).items() for k in own}]
    for new in ("adam", "zoe", "p1000", "mia", "uma"):
        more = sorted([*names, new])
        of.append({more[k]: split for split, own in split_names(more, 0).items() for k in own})
        moved = {(of[0][name], of[-1][name]) for name in names if of[0][name] != of[-1][name]}
        assert sum(of[0][name] != of[-1][name] for name in names) <= 2
        assert not moved & {("test", "train"), ("train", "test")}
    counts = [len(split_names(names, seed)["test"]) for seed in range(3)]
    assert set(counts) == {len(split_identities(range(count), np.random.default_rng(0))["test"])}
    assert split_names(names, 0) == split_names(names, 0) != split_names(names, 1)
