from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.pictures.compose import Easel
from caricli.methods.pictures.draw_sitter import draw_sitter, random_strands
from caricli.methods.pictures.hair import HATS, random_hat
from caricli.methods.pictures.light import Sky
from caricli.methods.pictures.mime import random_mime
from caricli.methods.pictures.pose import Pose, random_pose
from caricli.methods.pictures.settings import PoseSettings, SceneSettings, SitterSettings
from caricli.methods.pictures.sitter import Wardrobe
from caricli.structures.parsing import Region
from caricli.template.head import load_head

PLAIN = SitterSettings(
    bald=1, shaved=0, hat=0, glasses=0, beard=0, wrinkled=0, twisted=0, grinning=0, laughing=0, wide=0
)
STILL = PoseSettings(yaw=0, pitch=0, roll=0, turned=0, rolled=0, perspective=0, aside=0)
EVEN = Sky(np.array([[0.0, 0.0, -1.0]]), np.zeros((1, 3)), np.ones(1), np.ones(3), np.ones(3))


@pytest.fixture(scope="module")
def wardrobe():
    return Wardrobe(load_head().template(), PLAIN)


@pytest.fixture(autouse=True)
def plain(wardrobe):
    wardrobe.settings = PLAIN


def _drawn(wardrobe, seed=0, size=160, pose=STILL):
    generator = np.random.default_rng(seed)
    sitter = wardrobe.seat(wardrobe.template.vertices, generator)
    stand = random_pose(sitter.skin, size, 0.6, generator, pose)
    return sitter, draw_sitter(sitter, stand, size, EVEN, random_strands(generator), generator)


def test_a_surface_under_an_even_sky_gets_no_more_light_than_there_is(wardrobe):
    sitter, _ = _drawn(wardrobe)
    received = sitter.transfer.sum(1)
    assert received.max() < 1.05
    nose = wardrobe.template.annotation.landmarks[30]
    assert received[nose] > 0.9
    # The wall of the mouth sees next to nothing of it.
    assert received[wardrobe.template.annotation.regions["inner_mouth"]].mean() < 0.4


def test_all_of_a_bare_face_is_seen_from_the_front(wardrobe):
    _, drawing = _drawn(wardrobe)
    assert drawing.visible[17:68].all()
    there = set(np.unique(drawing.region).tolist())
    assert {Region.SKIN, Region.EYES, Region.NOSE, Region.LIPS, Region.EARS, Region.NECK} <= there
    assert not there & {Region.HAIR, Region.BEARD, Region.GLASSES, Region.HAT, Region.OTHER}


@pytest.mark.parametrize(
    ("worn", "region", "hidden"),
    [
        ({"hat": 1}, Region.HAT, ()),
        ({"glasses": 1, "dark": 1}, Region.GLASSES, range(36, 48)),
        ({"beard": 1}, Region.BEARD, ()),
        ({"bald": 0, "shaved": 0}, Region.HAIR, ()),
    ],
)
def test_what_is_worn_is_seen_and_hides_what_is_behind(wardrobe, worn, region, hidden):
    wardrobe.settings = replace(PLAIN, **worn)
    _, drawing = _drawn(wardrobe)
    assert (drawing.region == region).sum() > 40
    assert not drawing.visible[list(hidden)].any()


def test_who_has_no_landmarks_at_the_ears_wears_no_glasses(wardrobe):
    head = wardrobe.template
    other = copy(wardrobe)
    other.template = replace(head, annotation=replace(head.annotation, landmarks=head.annotation.landmarks[:68]))
    other.settings = replace(PLAIN, glasses=1)
    sitter, drawing = _drawn(other)
    assert len(drawing.points) == 68 and not (sitter.pieces.region == Region.GLASSES).any()


def test_who_grins_bares_teeth(wardrobe):
    wardrobe.settings = replace(PLAIN, grinning=1)
    shown = [(_drawn(wardrobe, seed)[1].region == Region.TEETH).sum() for seed in range(3)]
    assert min(shown) > 20
    wardrobe.settings = PLAIN
    assert (_drawn(wardrobe)[1].region == Region.TEETH).sum() < min(shown)


def test_who_laughs_opens_a_mouth_that_may_be_wider_than_people_have():
    head = load_head().template()
    lips = head.annotation.landmarks[48:68]
    widths: list[float] = []
    gaps: list[float] = []
    for seed in range(12):
        moved = random_mime(head.vertices, head, replace(PLAIN, laughing=1), np.random.default_rng(seed))
        mouth = head.vertices[lips] + moved[lips]
        widths.append(np.ptp(mouth[:, 0]) / np.ptp(head.vertices[lips, 0]))
        gaps.append(_parted(mouth))
        # The skull stays where it is.
        assert np.abs(moved[head.annotation.regions["ear_left"]]).max() < 0.05 * np.ptp(head.vertices[:, 1])
    assert max(widths) > 1.5 and min(widths) > 0.9
    assert max(gaps) > 8 * _parted(head.vertices[lips]) and min(gaps) > _parted(head.vertices[lips])
    assert not random_mime(head.vertices, head, PLAIN, np.random.default_rng(0)).any()


def test_a_closed_mouth_may_be_wide():
    head = load_head().template()
    lips = head.annotation.landmarks[48:68]
    settings = replace(PLAIN, wide=1, widest=1.2)
    moved = [random_mime(head.vertices, head, settings, np.random.default_rng(seed)) for seed in range(12)]
    widths = [np.ptp((head.vertices + own)[lips, 0]) / np.ptp(head.vertices[lips, 0]) for own in moved]
    assert max(widths) > 1.8 and min(widths) > 1
    assert all(_parted((head.vertices + own)[lips]) < 1.05 * _parted(head.vertices[lips]) for own in moved)


def _parted(mouth):
    """Distance of the lips, metres."""
    return np.linalg.norm(mouth[14] - mouth[18])


def test_teeth_grow_from_their_jaws(wardrobe):
    heights = {}
    for factor in (1.0, 1.5):
        wardrobe.settings = replace(PLAIN, cartoon=0, long_teeth=float(factor > 1), longest=factor, lashes=0)
        generator = np.random.default_rng(3)
        pieces = wardrobe.seat(wardrobe.template.vertices, generator).pieces
        heights[factor] = pieces.vertices[pieces.region == Region.TEETH, 1]
    usual, grown = heights[1.0], heights[1.5]
    # One row is above the other: its upper end stays, as the lower one's lower end does.
    assert np.ptp(grown) == pytest.approx(np.ptp(usual), rel=0.25)
    assert np.median(np.abs(grown - usual)) > 1e-4


@pytest.mark.parametrize("kind", HATS)
def test_a_hat_leaves_the_face_free_and_covers_the_crown(kind, monkeypatch):
    head = load_head().template()
    sphere = HeadSphere(head, ShellSettings(coarse=(40, 48)))
    monkeypatch.setattr("caricli.methods.pictures.hair.HATS", {kind: HATS[kind]})
    for seed in range(4):
        pieces = random_hat(sphere, 0.0, np.random.default_rng(seed))
        shell = pieces[0]
        assert np.isfinite(shell.vertices).all() and (shell.region == Region.HAT).all()
        assert shell.vertices[:, 1].max() > head.vertices[:, 1].max()
        eyes = head.vertices[head.annotation.landmarks[36:48]]
        front = shell.vertices[shell.vertices[:, 2] > eyes[:, 2].mean()]
        assert not len(front) or front[:, 1].min() > eyes[:, 1].max()


def test_a_face_that_is_turned_hides_its_far_side(wardrobe):
    turned = replace(STILL, turned=1, farthest=60)
    for seed in range(30):
        _, drawing = _drawn(wardrobe, seed, pose=turned)
        yaw = np.degrees(np.arcsin(drawing.pose.rotation[0, 2]))
        if abs(yaw) > 45:
            return _far_ear_is_hidden(drawing, yaw)
    pytest.fail("none of the seeds turns it far")


def _far_ear_is_hidden(drawing, yaw):
    right = drawing.visible[71:74].mean()
    left = drawing.visible[74:77].mean()
    assert (left > right) == (
        drawing.points[75, 0] - drawing.points[30, 0] > drawing.points[30, 0] - drawing.points[72, 0]
    )


def test_pictures_with_several_people_tell_who_hides_whom(wardrobe):
    generator = np.random.default_rng(4)
    sitters = [wardrobe.seat(wardrobe.template.vertices, generator) for _ in range(3)]
    easel = Easel(128, SceneSettings(none=0, several=1, held=0))
    counts = []
    for _ in range(6):
        picture = easel.compose(sitters, 0, generator)
        counts.append(len(picture.faces))
        scales = [face.scale for face in picture.faces]
        assert scales == sorted(scales, reverse=True)
        # Whoever is in front is not hidden by the others.
        assert picture.faces[0].visible.mean() >= min(face.visible.mean() for face in picture.faces)
    assert min(counts) >= 2


def _at(drawing):
    """Regions of the pixels that landmarks are in, and whether they are in the picture."""
    size = len(drawing.region)
    at = np.round(drawing.points).astype(int)
    column, row = np.clip(at, 0, size - 1).T
    return drawing.region[row, column], ((at >= 0) & (at < size)).all(1)


def test_landmarks_beyond_the_picture_are_not_seen(wardrobe):
    generator = np.random.default_rng(0)
    sitter = wardrobe.seat(wardrobe.template.vertices, generator)
    stand = random_pose(sitter.skin, 160, 0.6, generator, STILL)
    aside = replace(stand, translation=stand.translation + [80, 0])
    drawing = draw_sitter(sitter, aside, 160, EVEN, random_strands(generator), generator)
    _, inside = _at(drawing)
    assert 20 < inside[17:68].sum() < 45
    np.testing.assert_array_equal(drawing.visible[17:68], inside[17:68])


@pytest.mark.parametrize("worn", [{"beard": 1}, {"bald": 0, "shaved": 0, "fringe": (90, 100)}])
def test_what_lies_close_to_the_skin_hides_it_too(wardrobe, worn):
    wardrobe.settings = replace(PLAIN, **worn)
    covered = 0
    for seed in range(5):
        _, drawing = _drawn(wardrobe, seed)
        regions, _ = _at(drawing)
        over = np.isin(regions, [Region.HAIR, Region.BEARD])
        covered += over.sum()
        assert not drawing.visible[over].any()
    assert covered > 10


@pytest.mark.parametrize(
    ("yaw", "near", "far"), [(80, slice(42, 48), slice(36, 42)), (-80, slice(36, 42), slice(42, 48))]
)
def test_from_the_side_the_far_eye_is_not_seen(wardrobe, yaw, near, far):
    _, drawing = _drawn(wardrobe, pose=replace(STILL, around=yaw))
    assert drawing.visible[near].all() and not drawing.visible[far].any()


@pytest.mark.parametrize("roll", [0.0, np.pi])
def test_the_light_stays_where_it_is_when_a_head_is_upside_down(wardrobe, roll):
    generator = np.random.default_rng(0)
    sitter = wardrobe.seat(wardrobe.template.vertices, generator)
    stand = replace(
        random_pose(sitter.skin, 160, 0.6, generator, STILL), rotation=head_rotation(np.array([0, 0, roll]))
    )
    left = Sky(np.array([[-1.0, 0, 0]]), np.ones((1, 3)), np.full(1, 4.0), np.full(3, 0.01), np.full(3, 0.01))
    drawing = draw_sitter(sitter, stand, 160, left, random_strands(generator), generator)
    columns = np.nonzero(drawing.region == Region.SKIN)[1]
    light = drawing.colours[drawing.region == Region.SKIN].mean(1)
    middle = np.median(columns)
    assert light[columns < middle].mean() > 3 * light[columns > middle].mean()


def test_truth_of_a_picture_is_in_its_own_pixels(wardrobe):
    """Heads are drawn larger: what is stored is the camera of the picture, and labels lie where landmarks are."""
    generator = np.random.default_rng(7)
    sitters = [wardrobe.seat(wardrobe.template.vertices, generator)]
    easel = Easel(160, SceneSettings(none=0, several=0, held=0), replace(STILL, yaw=15, perspective=0.3))
    for _ in range(3):
        picture = easel.compose(sitters, 0, generator)
        (face,) = picture.faces
        skin = sitters[0].skin
        height = float(np.ptp(skin.vertices[:, 1]))
        stand = Pose(face.rotation, face.scale, face.translation, face.perspective, skin.vertices.mean(0), height)
        marks = skin.annotation.landmarks[17:68]
        np.testing.assert_allclose(face.points[17:68], stand.place(skin.vertices[marks])[:, :2], atol=1e-9)
        for region, numbers in ((Region.NOSE, (28, 29, 30)), (Region.EYES, range(36, 48)), (Region.LIPS, (51, 57))):
            rows, columns = np.nonzero(picture.region == region)
            if len(rows):
                box = face.points[list(numbers)]
                assert np.abs(np.array([columns.mean(), rows.mean()]) - box.mean(0)).max() < 0.06 * height * face.scale
        assert not set(np.unique(picture.region).tolist()) - set(map(int, Region))


def test_what_is_held_hides_landmarks_and_one_of_several_is_not_drawn_twice(wardrobe):
    generator = np.random.default_rng(8)
    sitters = [wardrobe.seat(wardrobe.template.vertices, generator) for _ in range(2)]
    easel = Easel(128, SceneSettings(none=0, several=0, held=1), STILL)
    seen = []
    for _ in range(6):
        picture = easel.compose(sitters, 1, generator)
        (face,) = picture.faces
        at = np.clip(np.round(face.points).astype(int), 0, 127)
        held = picture.region[at[:, 1], at[:, 0]] == Region.OTHER
        assert face.sitter == 1 and (picture.region == Region.OTHER).any()
        seen.extend([face.visible[held].mean()] if held.sum() > 4 else [])
    assert len(seen) > 1 and max(seen) < 0.2
    crowd = Easel(96, SceneSettings(none=0, several=1, held=0, most=4), STILL)
    for _ in range(6):
        assert sorted(face.sitter for face in crowd.compose(sitters, 0, generator).faces) == [0, 1]


def test_mimes_are_as_large_as_the_face(wardrobe):
    head = wardrobe.template
    settings = replace(PLAIN, twisted=1, laughing=1, wide=1)
    moved, twice = (random_mime(size * head.vertices, head, settings, np.random.default_rng(2)) for size in (1.0, 2.0))
    np.testing.assert_allclose(twice, 2 * moved, atol=1e-9)
    assert np.abs(moved).max() > 1e-3


def test_skin_that_is_behind_skin_is_not_visible(wardrobe):
    """All look out of the same place: whoever is largest hides the others, lips behind lips among them."""
    generator = np.random.default_rng(6)
    sitters = [wardrobe.seat(wardrobe.template.vertices, generator) for _ in range(2)]
    easel = Easel(128, SceneSettings(none=0, several=1, held=0), replace(STILL, apart=0, filled=(0.2, 1.4)))
    for _ in range(3):
        front, behind = easel.compose(sitters, 0, generator).faces
        assert front.visible.mean() > 0.8 and behind.visible.mean() < 0.1


def test_no_one_is_where_there_is_to_be_no_face(wardrobe):
    generator = np.random.default_rng(5)
    sitters = [wardrobe.seat(wardrobe.template.vertices, generator)]
    easel = Easel(96, SceneSettings(none=1, away=0.5))
    pictures = [easel.compose(sitters, 0, generator) for _ in range(16)]
    assert all(not picture.faces for picture in pictures)
    behind = [picture for picture in pictures if (picture.region > 0).any()]
    assert 0 < len(behind) < 16
    assert all((picture.region != Region.EYES).all() for picture in behind)
