import numpy as np

from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.detect.parse_face import parse_around, parse_face
from caricli.structures.parsing import Region
from tests.drawn_pictures import mean_shape


def test_what_is_around_a_face_moves_with_it(trained):
    detector, pictures = trained
    picture = pictures.marked(12)
    points = np.array(picture.landmarks[0])
    points[[3, 40, 50]] = np.nan
    # Windows that end within a picture are made smaller from another first pixel.
    wide = np.pad(picture.pixels, [(256, 256), (256, 256), (0, 0)], "edge")
    parsed = parse_face(wide, points + 256, detector)
    assert parsed.regions.shape == wide.shape[:2] and len(np.unique(parsed.regions)) > 1
    wider = np.pad(wide, [(16, 16), (16, 16), (0, 0)], "edge")
    moved = parse_face(wider, points + 272, detector)
    same = moved.regions[16:-16, 16:-16] == parsed.regions
    assert same[256:-256, 256:-256].mean() > 0.999
    np.testing.assert_allclose(moved.read.points, parsed.read.points + 16, atol=1e-3)


def test_landmarks_may_be_anywhere(trained, head_template):
    points = 50 * mean_shape(head_template) + [500, -300]
    regions = parse_face(np.full((40, 60, 3), 128, np.uint8), points, trained[0]).regions
    assert regions.shape == (40, 60) and set(np.unique(regions)) <= {0, *map(int, Region)}


def test_a_face_that_is_found_is_what_its_detection_says(trained):
    detector, pictures = trained
    detections = ((pictures.marked(k).pixels, detect_faces(pictures.marked(k).pixels, detector)) for k in range(20))
    pixels, detection = next(pair for pair in detections if pair[1].faces)
    points = detection.faces[0].landmarks.points
    np.testing.assert_array_equal(parse_around(pixels, points, detector), detection.regions)
    # Landmarks elsewhere are of no face that is found.
    beside = points + 3 * max(pixels.shape)
    np.testing.assert_array_equal(parse_around(pixels, beside, detector), parse_face(pixels, beside, detector).regions)
