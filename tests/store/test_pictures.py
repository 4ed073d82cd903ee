import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.image import write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.parsing import SCHEMA
from caricli.io.strict_json import write_json
from caricli.store.pictures import find_picture, load_eyes, load_marked_picture, load_mask, load_regions, pictures_in
from caricli.structures import Landmarks
from caricli.structures.parsing import Region

WIDTH, HEIGHT = 90, 70


@pytest.fixture
def points():
    return np.random.default_rng(0).uniform(10, 60, (68, 2))


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "drawings" / "marks.png"
    path.parent.mkdir()
    write_png(path, np.full((HEIGHT, WIDTH, 3), 90, np.uint8))
    return path


def test_one_picture_or_a_folder_of_them(photo, tmp_path):
    assert find_picture(photo, tmp_path / "marks.json", None) == photo
    assert find_picture(photo.parent, tmp_path / "marks.json", "marks") == photo
    assert find_picture(photo.parent, tmp_path / "marks" / "landmarks.json", "marks") == photo
    assert find_picture(None, tmp_path / "marks.json", "marks") is None
    with pytest.raises(InputError, match="expected a folder of pictures"):
        find_picture(photo, tmp_path / "marks.json", "marks")
    with pytest.raises(InputError, match=r"expected a picture named other with one of \.png"):
        find_picture(photo.parent, tmp_path / "other.json", "other")


def test_suffixes_may_be_in_capitals_and_the_first_kind_counts(photo, tmp_path):
    taken = photo.with_name("marks.JPG")
    photo.rename(taken)
    assert find_picture(photo.parent, tmp_path / "marks.json", "marks") == taken
    (photo.parent / "marks.Png").write_bytes(taken.read_bytes())
    assert find_picture(photo.parent, tmp_path / "marks.json", "marks").name == "marks.Png"


def test_hidden_files_are_no_pictures(photo):
    (photo.parent / "._marks.png").write_bytes(b"kept by macOS")
    assert pictures_in(photo.parent) == [photo]


def test_landmarks_learn_the_size_of_their_picture(points, photo, tmp_path):
    path = tmp_path / "marks.npy"
    np.save(path, points)
    marks, picture = load_marked_picture(path, photo)
    assert marks.image_size == (WIDTH, HEIGHT) and picture.shape == (HEIGHT, WIDTH, 3)
    alone, nothing = load_marked_picture(path)
    assert alone.image_size is None and nothing is None
    np.testing.assert_array_equal(alone.points, marks.points)


def test_landmarks_of_another_picture_are_refused_by_name(points, photo, tmp_path):
    path = tmp_path / "marks.json"
    write_landmarks(path, Landmarks(points, (WIDTH, HEIGHT + 1)))
    with pytest.raises(InputError, match=f"{path}: expected landmarks of the 90 x 70 picture .*, found 90 x 71"):
        load_marked_picture(path, photo)
    np.save(tmp_path / "far.npy", points + 1000)
    with pytest.raises(InputError, match="far.npy: expected the landmarks of a face in the 90 x 70 image"):
        load_marked_picture(tmp_path / "far.npy", photo)


def test_names_that_are_not_utf8_are_told_in_what_can_be_printed(points, photo, tmp_path):
    path = tmp_path / "b\udcff.json"
    write_landmarks(path, Landmarks(points, (WIDTH, HEIGHT + 1)))
    strange = photo.rename(photo.with_name("p\udcff.png"))
    with pytest.raises(InputError, match=r"b\\udcff.json: expected landmarks .* picture .*p\\udcff.png, found") as told:
        load_marked_picture(path, strange)
    assert str(told.value).isprintable()
    for image in (strange, photo.parent):
        with pytest.raises(InputError) as told:
            find_picture(image, path, path.stem)
        assert str(told.value).isprintable()


def test_pts_from_0_are_a_pixel_away(points, tmp_path):
    path = tmp_path / "marks.pts"
    write_landmarks(path, Landmarks(points))
    (first, _), (second, _) = (load_marked_picture(path, pts_origin=origin) for origin in (0, 1))
    np.testing.assert_allclose(first.points - second.points, 1)


def test_eyes_are_the_labels_of_a_parsed_picture(tmp_path):
    from PIL import Image

    labels = np.ones((HEIGHT, WIDTH), np.uint8)
    labels[20:30, 10:20], labels[20:30, 40:50] = 4, 5
    path = tmp_path / "labels.png"
    Image.fromarray(labels).save(path)
    np.testing.assert_array_equal(load_eyes(path, (WIDTH, HEIGHT)), labels > 1)
    np.testing.assert_array_equal(load_eyes(path, None), labels > 1)
    assert load_eyes(None, (WIDTH, HEIGHT)) is None
    with pytest.raises(InputError, match="labels.png: expected the picture's size, 90 x 71, found 90 x 70"):
        load_eyes(path, (WIDTH, HEIGHT + 1))
    Image.fromarray(np.minimum(labels, 1)).save(path)
    with pytest.raises(
        InputError, match="labels.png: expected pixels labelled eye_left or eye_right or eyes, found none"
    ):
        load_eyes(path, None)


def test_a_mask_is_where_it_is_white(tmp_path):
    white = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    white[10:60, 20:70] = 255
    white[61:65, 20:70] = 120
    path = tmp_path / "mask.png"
    write_png(path, white)
    np.testing.assert_array_equal(load_mask(path, (WIDTH, HEIGHT)), white[..., 0] > 127)
    with pytest.raises(InputError, match="mask.png: expected the picture's size, 90 x 71, found 90 x 70"):
        load_mask(path, (WIDTH, HEIGHT + 1))


@pytest.mark.parametrize("around", [0, 255])
def test_a_mask_with_transparency_is_where_it_is_opaque(tmp_path, around):
    from PIL import Image

    head = np.zeros((HEIGHT, WIDTH), bool)
    head[10:60, 20:70] = True
    colours = np.full((HEIGHT, WIDTH, 4), around, np.uint8)
    colours[head] = [90, 60, 40, 255]
    colours[~head, 3] = 0
    path = tmp_path / "mask.png"
    for kind in ("RGBA", "LA"):
        Image.fromarray(colours).convert(kind).save(path)
        np.testing.assert_array_equal(load_mask(path, (WIDTH, HEIGHT)), head)
    opaque = np.dstack([np.where(head[..., None], 255, 0).repeat(3, 2), np.full(head.shape, 255)])
    Image.fromarray(opaque.astype(np.uint8)).save(path)
    np.testing.assert_array_equal(load_mask(path, (WIDTH, HEIGHT)), head)


@pytest.mark.parametrize(("level", "where"), [(0, "none there"), (255, "all of it white")])
def test_a_mask_of_one_colour_is_refused(tmp_path, level, where):
    path = tmp_path / "mask.png"
    write_png(path, np.full((HEIGHT, WIDTH, 3), level, np.uint8))
    said = f"mask.png: expected a mask that is white where the head is, found {where}"
    with pytest.raises(InputError, match=said):
        load_mask(path, (WIDTH, HEIGHT))


def test_regions_are_labels_by_the_names_of_either_kind(tmp_path):
    from PIL import Image

    names = {"background": 0, "skin": 3, "ear_left": 5, "upper_lip": 6, "eye_right": 7, "brow_left": 8, "earring": 9}
    kinds = (0, Region.SKIN, Region.EARS, Region.LIPS, Region.EYES, Region.BROWS, Region.OTHER)
    labels = np.array([list(names.values())], np.uint8)
    path = tmp_path / "labels.png"
    Image.fromarray(labels).save(path)
    write_json(path.with_suffix(".json"), {"schema": SCHEMA, "labels": names})
    np.testing.assert_array_equal(load_regions(path, (7, 1)), [kinds])
    write_json(path.with_suffix(".json"), {"schema": SCHEMA, "labels": {"skin": 3, "ear_left": 5}})
    with pytest.raises(InputError, match="labels.png: expected numbers that the legend names, found 0"):
        load_regions(path, (7, 1))


@pytest.mark.parametrize(
    ("mouth", "told", "is_refused"), [(5, False, True), (12, False, False), (5, True, False), (3, False, True)]
)
def test_numbers_that_put_eyes_on_the_mouth_are_refused_where_nothing_names_them(mouth, told, is_refused, tmp_path):
    """As those of `caricli detect` do, whose names a painting program lost."""
    from PIL import Image

    points = np.full((68, 2), 30.0)
    points[48:56] = [30, 50]
    points[60] = [3000, -9]
    points[61] = np.nan
    labels = np.ones((HEIGHT, WIDTH), np.uint8)
    labels[40:, :] = mouth
    labels[:9, :9] = 4
    path = tmp_path / "labels.png"
    Image.fromarray(labels).save(path)
    if told:
        write_json(path.with_suffix(".json"), {"schema": SCHEMA, "labels": {"skin": 1, "eye_left": 4, "lower_lip": 5}})
    for load in (load_regions, load_eyes):
        load(path, (WIDTH, HEIGHT))
        if is_refused:
            with pytest.raises(InputError, match=r"labels.png: expected labels numbered as in .* beside it, labels.js"):
                load(path, (WIDTH, HEIGHT), points)
        else:
            load(path, (WIDTH, HEIGHT), points)
