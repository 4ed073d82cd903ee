import json

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.data.picture_set import read_picture_set
from caricli.data.unseen import people_entry
from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.detect.detect_faces import detect_faces
from caricli.store.detector import load_detector
from caricli.structures.landmarks import EYE_LEFT, EYE_RIGHT, LIPS
from caricli.structures.parsing import Region

COUNT = 30


@pytest.fixture(scope="module")
def folder(run, dataset, tmp_path_factory):
    out = tmp_path_factory.mktemp("pictures") / "pictures"
    result = run("dataset", "pictures", dataset, out, "--count", COUNT, "--size", 128, "--seed", 3, "--workers", 2)
    assert result.exit_code == 0, result.output
    return out


@pytest.fixture(scope="module")
def pictures(folder):
    return read_picture_set(folder)


def test_the_same_seed_gives_the_same_bytes_whatever_the_number_of_workers(run, dataset, folder, tmp_path):
    again = tmp_path / "again"
    options = ("--count", COUNT, "--size", 128, "--seed", 3, "--workers", 1)
    assert run("dataset", "pictures", dataset, again, *options).exit_code == 0
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert len(files) == 2 * COUNT + 2
    assert all((folder / file).read_bytes() == (again / file).read_bytes() for file in files)


def test_it_says_of_whom_they_are(dataset, pictures):
    assert people_entry(read_dataset(dataset)).items() <= pictures.manifest.items()


def test_landmarks_are_where_the_label_map_shows_what_they_mark(pictures):
    """Of eyes and lips that are seen, the middle is of the eye and the outline is of the lips, or next to it."""
    hits = []
    for number in range(pictures.count):
        regions = pictures.regions(number)
        for face in pictures.faces(number):
            points = pictures.truth["landmarks"][face]
            visible = pictures.truth["visible"][face]
            for marks, region in ((EYE_RIGHT, Region.EYES), (EYE_LEFT, Region.EYES), (LIPS, Region.LIPS)):
                # Of tiny faces an eye is smaller than a pixel.
                if visible[list(marks)].all() and np.ptp(points, axis=0).max() > 50:
                    x, y = np.round(points[list(marks)]).astype(int).T
                    hits.append((regions[y.min() : y.max() + 1, x.min() : x.max() + 1] == region).any())
    assert len(hits) > 8
    assert np.mean(hits) > 0.9


def test_the_camera_is_told_by_the_coefficients(pictures):
    for face in range(len(pictures.truth["picture"])):
        angles = pictures.truth["coefficients"][face, -6:-3]
        np.testing.assert_allclose(head_rotation(angles), pictures.truth["rotation"][face], atol=1e-5)
    assert pictures.truth["coefficients"].shape[1] == 80 + 64 + 80 + 9 + 6


def test_people_of_the_dataset_s_splits_never_meet(pictures):
    splits = [set(pictures.pictures_of(split).tolist()) for split in ("train", "validation", "test")]
    assert set.union(*splits) == set(range(COUNT))
    assert sum(map(len, splits)) == COUNT


def test_the_bundled_detector_finds_their_faces(pictures):
    detector = load_detector()
    errors = []
    missed = 0
    for number in range(COUNT):
        faces = detect_faces(pictures.picture(number), detector).faces
        for row in pictures.faces(number):
            truth = pictures.truth["landmarks"][row][:68]
            if np.ptp(truth, axis=0).max() < 24 or pictures.truth["visible"][row].mean() < 0.6:
                continue
            apart = [np.linalg.norm(face.landmarks.points[:68] - truth, axis=1) for face in faces]
            nearest = min((100 * np.nanmean(each) for each in apart), default=np.inf)
            error = nearest / np.linalg.norm(np.ptp(truth, axis=0))
            missed += error > 10
            errors.append(error)
    assert len(errors) > COUNT / 2
    assert missed < 0.2 * len(errors)
    # The mean shape in the true frame is 8 % off.
    assert np.median(errors) < 5


def test_a_sheet_shows_them(run, folder, tmp_path):
    result = run("dataset", "show", folder, "-o", tmp_path / "sheet.png", "--faces", 4)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "sheet.png").exists()
    assert f"pictures: {COUNT}" in result.stdout and "made as" in result.stdout


def test_what_is_no_dataset_or_of_another_mesh_is_refused(refused, folder, tmp_path):
    assert "dataset" in refused("dataset", "pictures", tmp_path / "none", tmp_path / "out")
    assert "expected a dataset, found a folder of `caricli dataset pictures`" in refused(
        "dataset", "pictures", folder, tmp_path / "out"
    )
    assert not (tmp_path / "out").exists()


def test_splits_of_anything_but_people_are_refused(refused, folder, tmp_path):
    copy = tmp_path / "copy"
    copy.mkdir()
    manifest = json.loads((folder / "pictures.json").read_text())
    manifest["splits"]["train"] = [[1, 2], 3]
    (copy / "pictures.json").write_text(json.dumps(manifest))
    (copy / "truth.npz").write_bytes((folder / "truth.npz").read_bytes())
    assert "splits: expected lists of people for train, validation, test" in refused("dataset", "show", copy)


def test_damaged_truth_is_refused(refused, folder, tmp_path):
    copy = tmp_path / "copy"
    copy.mkdir()
    (copy / "pictures.json").write_bytes((folder / "pictures.json").read_bytes())
    (copy / "truth.npz").write_bytes((folder / "truth.npz").read_bytes() + b"x")
    assert "was changed" in refused("dataset", "show", copy)
