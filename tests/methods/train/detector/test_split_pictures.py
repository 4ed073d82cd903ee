import numpy as np

from caricli.data.picture_set import read_picture_set
from caricli.geometry.lines.mark_lines import mark_lines
from caricli.geometry.lines.space_jaw import carry_jaw
from caricli.methods.train.detector.split_pictures import JoinedPictures, SplitPictures, evenly_jawed, marked_by_people
from tests.drawn_pictures import mean_shape, write_drawn_set


def test_joined_pictures_are_those_of_each_and_of_one_split_alone(head_template, tmp_path):
    shape = mean_shape(head_template)
    sets = [read_picture_set(write_drawn_set(tmp_path / str(k), shape, 8 + 4 * k, k)) for k in range(2)]
    parts = [SplitPictures(pictures, "train") for pictures in sets]
    joined = JoinedPictures(parts)
    assert len(joined.numbers) == sum(len(part.numbers) for part in parts)
    assert len(joined.faces) == sum(len(part.faces) for part in parts)
    assert set(joined.numbers) >= {number for number, _ in joined.faces}
    for part, start in zip(parts, (0, 8), strict=True):
        for number in part.numbers:
            own = part.marked(number)
            same = joined.marked(start + number)
            np.testing.assert_array_equal(same.pixels, own.pixels)
            np.testing.assert_array_equal(same.landmarks, own.landmarks)
    landmarks = [joined.marked(number).landmarks[place] for number, place in joined.faces]
    np.testing.assert_array_equal(joined.landmarks(), landmarks)


def test_only_the_inner_points_of_jaws_are_moved_to_equal_distances(head_template, tmp_path):
    pictures = read_picture_set(write_drawn_set(tmp_path / "set", mean_shape(head_template), 8, 0))
    marked = [SplitPictures(pictures, split).marked(number) for split in ("train",) for number in (0, 3)]
    for picture in marked:
        evenly = evenly_jawed(picture)
        assert evenly.landmarks.shape == picture.landmarks.shape
        np.testing.assert_array_equal(evenly.landmarks[:, 17:], picture.landmarks[:, 17:])
        ends = evenly.landmarks[:, [0, 8, 16]] - picture.landmarks[:, [0, 8, 16]]
        np.testing.assert_allclose(ends, 0, atol=1e-9)
        steps = np.linalg.norm(np.diff(evenly.landmarks[:, :9], axis=1), axis=2)
        assert np.ptp(steps, axis=1).max(initial=0) < 0.1 * steps.max(initial=1)


def test_what_is_found_is_compared_with_faces_as_people_mark_them(head_template, tmp_path):
    pictures = read_picture_set(write_drawn_set(tmp_path / "set", mean_shape(head_template), 4, 0))
    for number in (0, 3):
        picture = SplitPictures(pictures, "train").marked(number)
        by_people = marked_by_people(picture)
        assert by_people.landmarks.shape == picture.landmarks.shape
        for face, marked in zip(picture.landmarks, by_people.landmarks, strict=True):
            np.testing.assert_array_equal(marked, mark_lines(carry_jaw(face)))
