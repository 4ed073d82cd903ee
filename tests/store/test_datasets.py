from caricli.store.datasets import dataset_files


def test_the_files_of_a_dataset_are_named(tmp_path):
    for name in ("dataset.json", "shard-0000.npz", "labels.npz", "notes.md"):
        (tmp_path / name).touch()
    names = [path.name for path in dataset_files(tmp_path)]
    assert sorted(names) == ["dataset.json", "labels.npz", "shard-0000.npz"]
