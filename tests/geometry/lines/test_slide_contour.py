import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from caricli.geometry.lines.slide_contour import slide_contour

FRONT = np.diag([1.0, -1.0, -1.0])
JAW = 17


def turned(yaw=0.0, pitch=0.0):
    """Camera rotation for a head that turns by degrees; positive yaw shows more of the subject's right side."""
    return FRONT @ Rotation.from_euler("xy", [pitch, yaw], degrees=True).as_matrix()


def slide(template, rotation, vertices=None):
    vertices = template.vertices if vertices is None else vertices
    landmarks, paths = template.annotation.landmarks[:JAW], template.annotation.jaw_paths
    return slide_contour(vertices, rotation, template.vertices, landmarks, paths)


def depth_inside(template, rotation, ids):
    """How far vertices lie inside the convex outline of the face's skin in the picture, metres."""
    skin = template.mask("face", "cheeks", "chin", "temples", "forehead") | template.mask("mouth", "nose")
    skin[np.concatenate(template.annotation.jaw_paths)] = True
    picture = template.vertices @ rotation[:2].T
    hull = ConvexHull(picture[skin])
    return -(picture[ids] @ hull.equations[:, :2].T + hull.equations[:, 2]).max(1)


def test_a_frontal_head_keeps_its_marks(head_template):
    landmarks = head_template.annotation.landmarks[:JAW]
    before = landmarks.copy()
    assert np.array_equal(slide(head_template, turned()), landmarks)
    assert np.array_equal(landmarks, before)


@pytest.mark.parametrize("yaw", [15.0, 25.0, -15.0, -25.0])
def test_the_far_side_of_a_turned_head_slides_to_the_outline(head_template, yaw):
    rotation = turned(yaw)
    landmarks = head_template.annotation.landmarks[:JAW]
    # The far side is the one whose jaw lies deeper in the picture.
    depth = head_template.vertices[landmarks] @ rotation[2]
    far, near = (range(0, 8), range(9, 17)) if depth[0] > depth[16] else (range(9, 17), range(0, 8))
    slid = slide(head_template, rotation)
    assert np.array_equal(slid[near], landmarks[near])
    fixed, moved = (depth_inside(head_template, rotation, ids[far]) for ids in (landmarks, slid))
    assert moved.mean() < 0.5 * fixed.mean()
    assert (moved < fixed + 1e-6).all()
    assert (slid[far] != landmarks[far]).sum() >= 4


def test_every_mark_stays_on_its_path_whatever_the_pose(head_template):
    paths = head_template.annotation.jaw_paths
    for k in range(10):
        slid = slide(head_template, FRONT @ Rotation.random(random_state=k).as_matrix())
        assert all(vertex in path for vertex, path in zip(slid, paths, strict=True))


def test_mirrored_turns_slide_mirrored(head_template):
    mirror = head_template.annotation.mirror
    one, other = slide(head_template, turned(20.0)), slide(head_template, turned(-20.0))
    left, right = head_template.vertices[one], head_template.vertices[mirror[other][::-1]]
    # Vertices next to each other on a path can reach as far to within the asymmetry of the mesh.
    assert np.abs(left - right).max() < 1e-3


def test_the_size_of_the_head_does_not_matter(head_template):
    rotation = turned(22.0, 8.0)
    found = slide(head_template, rotation, 3.0 * head_template.vertices + [0.2, 0.0, 1.0])
    assert (found != slide(head_template, rotation)).sum() <= 1


def test_the_chin_of_a_lifted_head_slides_backwards_only_for_a_clear_gain():
    """One path along a line from under the chin to its front, and a mark in the middle."""
    template = np.array([[0.0, 0.0, -0.1], [0.0, 0.0, 0.0], [0.0, 0.0, 0.1], [-1.0, 1.0, 0], [1.0, 1.0, 0]])
    paths = (np.array([0, 1, 2]), np.array([3]), np.array([4]))
    landmarks = np.array([1, 3, 4])

    def at(pitch):
        return slide_contour(template, turned(pitch=pitch), template, landmarks, paths)[0]

    # A positive pitch lowers the chin: the point in front goes down, outwards, and rounding alone is no gain.
    assert [at(0.0), at(0.5), at(1.0), at(4.0), at(25.0)] == [1, 1, 2, 2, 2]
    # A lifted head shows the point underneath: 0.019 of the height is too little of a gain, 0.021 is enough.
    assert [at(-0.5), at(-4.0), at(-11.0), at(-12.0), at(-25.0)] == [1, 1, 1, 0, 0]
