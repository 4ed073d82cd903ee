import hashlib
import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from caricli.data.build_dataset import build_dataset
from caricli.data.build_settings import BuildSettings
from caricli.data.dataset import SPLITS, read_dataset
from caricli.data.import_dataset import import_dataset
from caricli.data.unseen import (
    all_tested,
    different_people,
    fingerprints,
    people_entry,
    seen_people,
    told_people,
    training_tested,
    unseen_data,
)
from caricli.data.unseen import everybody as seen_together
from caricli.errors import InputError
from caricli.io.bundled import config_path
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.store.directions import load_directions
from caricli.store.landmark_maps import load_landmark_map
from caricli.store.models import load_model
from caricli.structures import SeenPeople

LATENT = ("kernel", "intrinsic", "pca", "deformable")


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """The dataset of a grid of neutral people."""

    def built(people, seed, expressions=1):
        folder = tmp_path_factory.mktemp("people")
        build_dataset(folder, BuildSettings(None, people, expressions, 1, seed), 1)
        return read_dataset(folder)

    return built


@pytest.fixture(scope="module")
def eight(build):
    return build(8, 3)


def with_splits(data, **splits):
    return replace(data, manifest=data.manifest | {"splits": dict.fromkeys(SPLITS, []) | splits})


def everybody(data):
    return fingerprints(with_splits(data, test=sorted(set(data.identity.tolist()))), "test")


def test_the_same_seed_draws_the_same_people_whatever_else_differs(build, eight):
    few = everybody(build(2, 3, expressions=2))
    many = everybody(eight)
    assert len(set.union(*map(set, many.values()))) == 8
    assert all(many[person] == marks and len(marks) == 1 for person, marks in few.items())
    others = everybody(build(2, 4))
    assert not set.union(*map(set, others.values())) & set.union(*map(set, many.values()))


def test_datasets_that_train_and_try_the_same_people_are_not_trained_on_together(build, eight):
    others = build(2, 4)
    apart = with_splits(eight, train=[0, 1, 2], validation=[3], test=[4])
    assert seen_together([apart, apart]) == seen_people(apart)
    both = seen_together([apart, with_splits(others, train=[0], validation=[1])])
    assert len(both.train) == 4 and len(both.validation) == 2
    fewer = build(5, 3)
    for split in ("validation", "test"):
        with pytest.raises(InputError, match="different people, found 1 whom one trains with and another validates"):
            seen_together([apart, with_splits(fewer, **{split: [2, 3]})])


def test_people_of_an_imported_folder_are_told_by_any_of_their_meshes(barrels, tmp_path):
    folder, _, annotation = barrels
    names = sorted(path.name for path in folder.iterdir())
    table = tmp_path / "people.csv"
    table.write_text("file,identity\n" + "".join(f"{name},{k // 2}\n" for k, name in enumerate(names)))
    (tmp_path / "out").mkdir()
    import_dataset(folder, tmp_path / "out", annotation, table)
    pairs = everybody(read_dataset(tmp_path / "out"))
    assert len(pairs) == 6 and all(len(marks) == 2 for marks in pairs.values())
    # Another folder, where one of them comes alone, under another number and name.
    (tmp_path / "again").mkdir()
    for name, new in ((names[3], "b.obj"), (names[8], "a.obj")):
        write_obj(tmp_path / "again" / new, read_obj(folder / name))
    (tmp_path / "second").mkdir()
    import_dataset(tmp_path / "again", tmp_path / "second", annotation)
    alone = everybody(read_dataset(tmp_path / "second"))
    assert alone[0] < pairs[4] and alone[1] < pairs[1]


def test_what_a_folder_says_of_its_people_is_read_again(eight):
    entry = people_entry(eight)
    assert seen_together([eight]) == different_people([told_people(json.loads(json.dumps(entry)))])
    assert told_people({"splits": {}}) == {}  # of an older folder
    other = {"people": {"train": entry["people"]["test"]}}
    with pytest.raises(InputError, match="expected datasets of different people, found"):
        different_people([told_people(each) for each in (entry, other)])
    for broken in ([], {"train": ["a"]}):
        with pytest.raises(InputError, match="people: expected fingerprints by split"):
            told_people({"people": broken})


def test_a_coordinate_of_minus_nothing_is_nothing():
    """As other programs write it of the same mesh."""

    def marks(nothing):
        vertices = np.array([[[1.0, nothing, 2.0], [2.0, 0, 0]]])
        manifest = {"splits": {"test": [4]}}
        own = {"rows": lambda split: np.array([True]), "identity": np.array([4]), "factors": {}, "manifest": manifest}
        data: Any = SimpleNamespace(vertices=vertices, **own)
        return fingerprints(data, "test", older=True)

    assert marks(0.0) == marks(-0.0) != marks(1.0) and len(marks(0.0)[4]) == 2


def test_people_of_imported_files_are_the_same_in_every_unit_and_place(barrel, barrels, tmp_path):
    folder, shapes, annotation = barrels
    (tmp_path / "cm").mkdir()
    for number, shape in enumerate(shapes):
        write_obj(tmp_path / "cm" / f"{number:02d}.obj", barrel.mesh.with_vertices(100 * shape + [0, 150.3, -2]))
    seen = []
    for meshes in (folder, tmp_path / "cm"):
        out = tmp_path / f"{meshes.name}-data"
        out.mkdir()
        import_dataset(meshes, out, annotation)
        seen.append(everybody(read_dataset(out)))
    assert seen[0] == seen[1] and len(frozenset().union(*seen[0].values())) == 12


def test_imported_people_of_older_recipes_are_seen(barrels, tmp_path):
    (tmp_path / "out").mkdir()
    import_dataset(barrels[0], tmp_path / "out", barrels[2])
    data = read_dataset(tmp_path / "out")
    old = {hashlib.sha256(shape.tobytes()).hexdigest()[:12] for shape in data.vertices[:3]}
    tested = with_splits(data, test=list(range(12)))
    unseen = unseen_data(tested, {"old": SeenPeople(frozenset(old))})
    assert unseen.note == "test split: 9 of 12 people, without those whom old saw"
    assert unseen.data.manifest["splits"]["test"] == list(range(3, 12))


def test_generated_and_imported_people_who_meet_are_told(barrels, eight, tmp_path):
    (tmp_path / "out").mkdir()
    import_dataset(barrels[0], tmp_path / "out", barrels[2])
    imported = with_splits(read_dataset(tmp_path / "out"), train=[0, 1, 2], test=[3, 4])
    generated = with_splits(eight, train=[0, 1, 2], test=[3, 4])
    by_making, by_meshes = seen_people(generated), seen_people(imported)
    seen = {"made": by_making, "scans": by_meshes}
    assert unseen_data(imported, seen).note == (
        "made: trained with generated people, who cannot be told among imported ones and may be among the test people"
    )
    note = unseen_data(generated, seen).note
    assert note is not None and note.startswith("scans: trained with imported people")
    both = seen_together([generated, imported])
    for data in (generated, imported):
        assert "both: trained with" in str(unseen_data(data, {"both": both}).note)
    # A recipe of before does not say what its fingerprints are of.
    older = SeenPeople(by_meshes.train)
    assert unseen_data(imported, {"older": older}).note is None


def test_who_was_trained_with_leaves_the_tests_and_who_remains_is_counted(eight):
    trained = seen_people(with_splits(eight, train=[0, 1, 2], validation=[3]))
    asked = with_splits(eight, train=[6], validation=[1, 3, 7], test=[2, 3, 4, 5])
    unseen = unseen_data(asked, {"mine": trained})
    assert unseen.data.manifest["splits"] == {"train": [6], "validation": [3, 7], "test": [4, 5]}
    assert unseen.figures == {"test_people": {"unseen": 2, "of": 4}}
    assert "2 of 4 people" in unseen.note and "mine" in unseen.note
    assert set(unseen.data.identity[unseen.data.rows("test")]) == {4, 5}
    # Models side by side are tested with the same people: whom none has seen.
    other = seen_people(with_splits(eight, train=[4]))
    assert unseen_data(asked, {"mine": trained, "other": other}).data.manifest["splits"]["test"] == [5]
    assert unseen_data(asked, {"mine": trained}, everyone=True).test == 4


def test_people_of_the_training_split_can_be_tested_with_and_those_of_the_validation_split(eight):
    data = with_splits(eight, train=[6, 0], validation=[1], test=[2])
    assert training_tested(data).manifest["splits"] == {"train": [], "validation": [1], "test": [0, 2, 6]}
    assert all_tested(data).manifest["splits"] == {"train": [], "validation": [], "test": list(range(8))}
    assert data.manifest["splits"]["train"] == [6, 0]


def test_nobody_left_is_refused_and_everybody_left_needs_no_word(eight):
    data = with_splits(eight, train=[0, 1], test=[2, 3])
    trained = seen_people(with_splits(eight, train=[2, 3]))
    with pytest.raises(InputError, match="people unseen in the training of mine, found none among 2; .*--seed"):
        unseen_data(data, {"mine": trained})
    with pytest.raises(InputError, match="expected test people unseen in the training of mine and yours, found none"):
        unseen_data(data, {"mine": trained, "yours": trained})
    own = unseen_data(data, {"mine": seen_people(data)})
    assert own.note is None and own.test == own.of == 2 and own.data.manifest["splits"] == data.manifest["splits"]
    assert unseen_data(with_splits(eight, train=[0]), {"mine": trained}).note is None


def test_a_model_that_names_nobody_is_named(eight):
    data = with_splits(eight, train=[0], test=[1])
    unseen = unseen_data(data, {"old": None, "new": seen_people(data)})
    assert unseen.note.startswith("old: ") and "new" not in unseen.note and unseen.test == 1


def test_the_bundled_models_name_the_people_of_their_recipe(build):
    """Seed 0 is everybody's default, and theirs."""
    defaults = everybody(build(6, 0))
    seen = [load_model(kind=kind).seen for kind in ("morphable", *LATENT)]
    seen += [load_directions(load_model(kind=kind)).seen for kind in LATENT]
    landmarks = load_landmark_map().seen
    counts = [(720, 8)] * len(seen) + [(646, 79)]
    for people, count in zip([*seen, landmarks], counts, strict=True):
        assert isinstance(people, SeenPeople) and (len(people.train), len(people.validation)) == count
        share = np.mean([bool(marks & people.train) for marks in defaults.values()])
        assert share > 0.5
        assert not people.train & people.validation
    assert len({people.train for people in seen}) == 1
    # Every tenth of the 717 who are in a mesh is held out of the map's training.
    everyone = seen[0].train | seen[0].validation
    assert landmarks.train < seen[0].train and seen[0].validation < landmarks.validation < everyone


def test_a_trained_person_planted_in_the_published_test_set_is_left_out(build):
    seed = yaml.safe_load(config_path("testset.yaml").read_text("utf-8"))["seed"]
    tested = build(4, seed)
    seen = {kind: load_model(kind=kind).seen for kind in ("morphable", *LATENT)}
    assert unseen_data(tested, seen, everyone=True).test == 4
    trained = build(6, 0)
    who = next(person for person, marks in everybody(trained).items() if marks & seen["kernel"].train)
    # Person 2 is made of what that one is made of.
    factors = {name: values.copy() for name, values in tested.factors.items()}
    for name in ("changes", "gender", "age", "weight"):
        factors[name][tested.identity == 2] = trained.factors[name][trained.identity == who][0]
    planted = unseen_data(replace(tested, factors=factors), seen, everyone=True)
    assert planted.data.manifest["splits"]["test"] == [0, 1, 3]
    assert planted.figures == {"test_people": {"unseen": 3, "of": 4}} and "kernel" in planted.note


def test_people_without_a_mesh_are_nobody(eight):
    data = with_splits(eight, train=[0, 1], test=[2, 3, 8, 9])
    assert unseen_data(data, {}).figures == {"test_people": {"unseen": 2, "of": 2}}
    with pytest.raises(InputError, match="found none among 2"):
        unseen_data(data, {"mine": seen_people(with_splits(eight, train=[2, 3]))})
