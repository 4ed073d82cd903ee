import numpy as np
from skimage.data import astronaut

from caricli.methods.detect.detect_faces import detect_faces
from caricli.methods.detect.parse_face import GivenFace, parse_face
from caricli.methods.detect.see_face import see_face
from caricli.methods.detect.settings import DetectSettings
from caricli.store.detector import load_detector
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
    np.testing.assert_array_equal(GivenFace(pixels, points, detector).regions, detection.regions)
    # Landmarks elsewhere are of no face that is found.
    beside = points + 3 * max(pixels.shape)
    alone = parse_face(pixels, beside, detector).regions
    np.testing.assert_array_equal(GivenFace(pixels, beside, detector).regions, alone)


def test_a_picture_of_another_face_is_told_where_a_face_is_sure():
    detector = load_detector()
    pixels = astronaut()[:280, 90:370].copy()
    points = see_face(pixels, detector).landmarks.points
    points[3] = np.nan
    diagonal = np.linalg.norm(np.nanmax(points, axis=0) - np.nanmin(points, axis=0))

    def elsewhere(pixels, points, **settings):
        return GivenFace(pixels, points, detector, DetectSettings(**settings)).elsewhere

    assert not elsewhere(pixels, points)
    assert not elsewhere(pixels, points + 0.02 * diagonal)
    assert not elsewhere(np.repeat(255 - pixels[..., 1:2] // 2, 3, axis=2), points)
    assert elsewhere(pixels, points + 0.3 * diagonal)
    assert not elsewhere(pixels, points + 0.3 * diagonal, doubtful=1.0)
    assert not elsewhere(np.full_like(pixels, 128), points)
