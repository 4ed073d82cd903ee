from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from caricli.errors import InputError
from caricli.methods.hair.bare_skin import bare_skin
from caricli.methods.hair.dress_hair import dress_hair, hair_picture
from caricli.methods.hair.mask_hair import HairMask
from caricli.methods.hair.parsed_hair import is_before_head, parsed_hair
from caricli.methods.texture.parsed_head import ParsedHead
from caricli.methods.texture.settings import PaintSettings
from caricli.render.visibility.rasterise import rasterise
from caricli.structures.parsing import Region
from tests.methods.hair.conftest import BROWN, CAMERA, SIDE, SKIN, WALL

SMALL = PaintSettings(size=128)


@pytest.fixture(scope="module")
def dressed(sitter):
    return dress_hair(sitter.face, sitter.head, sitter.image, SMALL)


def test_hair_has_the_colour_of_the_picture_on_all_sides(dressed, sitter):
    assert dressed.overlap > 0.88 and set(dressed.figures()) == {"doubt", "overlap"}
    picture = hair_picture(dressed, sitter.image, SMALL)
    assert picture.shape == (128, 128, 3)
    away = np.abs(picture.astype(int) - BROWN)
    assert away.mean() < 10 and np.quantile(away, 0.99) < 60
    assert (hair_picture(dressed, sitter.image, replace(SMALL, seed=1)) != picture).any()
    np.testing.assert_array_equal(hair_picture(dressed, sitter.image, SMALL), picture)


def test_what_is_beside_hair_does_not_colour_its_edge(dressed, sitter):
    """A light rim along the border of the mask."""
    inner = cv2.erode(dressed.mask.pixels.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    image = np.where(inner[..., None], sitter.image, (250, 220, 60)).astype(np.uint8)
    picture = hair_picture(dressed, image, replace(SMALL, size=384))
    assert (picture[..., 0] > 150).mean() < 1e-3


def test_small_parts_of_hair_that_are_seen_by_themselves_do_not_count(dressed, sitter):
    """The end of it on one side, behind a gap and a little bluer; and what is between gap and face."""
    _, columns = np.nonzero(dressed.mask.pixels)
    end = columns.max() - 12
    place = np.indices(dressed.mask.pixels.shape)[1]
    pixels = dressed.mask.pixels & ((place < end - 14) | (place >= end))
    apart = replace(dressed, mask=replace(dressed.mask, pixels=pixels))

    def painted(bluer):
        image = np.where((pixels & bluer)[..., None], sitter.image + np.array([0, 0, 12]), sitter.image)
        return hair_picture(apart, image.astype(np.uint8), replace(SMALL, size=384))

    plain = painted(place < 0)
    np.testing.assert_array_equal(painted(place >= end), plain)
    assert (painted((place > columns.mean()) & (place < end)) != plain).mean() > 0.05


def test_shade_on_hair_is_taken_out_of_its_picture_unless_light_is_kept(dressed, sitter):
    """From side to side the picture becomes a quarter as bright."""
    columns = np.nonzero(dressed.mask.pixels)[1]
    fall = np.interp(np.arange(dressed.mask.pixels.shape[1]), [columns.min(), columns.max()], [1, 0.25])
    shaded = (sitter.image * fall[:, None]).astype(np.uint8)
    sides = {}
    for kept in (True, False):
        settings = replace(SMALL, size=384, texture=replace(SMALL.texture, keep_light=kept))
        picture = hair_picture(dressed, shaded, settings)[192:].astype(float)
        sides[kept] = picture[:, :192].mean() - picture[:, 192:].mean()
    assert sides[True] > 10 and abs(sides[False]) < 0.6 * sides[True]


@pytest.mark.parametrize("turn", [(0, 0, 60), (0, 30, 60), (30, 0, 60), (0, 0, 80)])
def test_what_is_taken_for_hair_on_the_neck_alone_is_no_hair(sitter, turn):
    """A neck seen from the side, turned by degrees about z, x and y, lies in a shadow that has the colour of hair."""
    turned = CAMERA.rotation @ Rotation.from_euler("zxy", turn, degrees=True).as_matrix()
    camera = replace(CAMERA, rotation=turned)
    camera = replace(camera, translation=SIDE / 2 - camera.project(sitter.head.vertices).mean(0) + camera.translation)
    shown = rasterise(camera.place(sitter.head.vertices), sitter.head.faces, SIDE, SIDE).face
    heights = sitter.head.vertices[sitter.head.faces].mean(1)[:, 1]
    neck = (shown >= 0) & (heights[shown] < sitter.head.vertices[sitter.head.annotation.landmarks[8], 1])
    regions = np.select([neck, shown >= 0], [Region.HAIR, Region.SKIN], Region.BACKGROUND)
    image = np.select([neck[..., None], (shown >= 0)[..., None]], [BROWN, SKIN], WALL).astype(np.uint8)
    marks = camera.project(sitter.head.vertices[sitter.head.annotation.landmarks[:68]])
    face = replace(sitter.face, camera=camera, landmarks=marks)
    assert dress_hair(face, sitter.head, image, SMALL, regions) is None
    with pytest.raises(InputError, match="expected hair on the scalp, found none there"):
        dress_hair(face, sitter.head, image, replace(SMALL, hair="shell"), regions)


def test_what_no_shell_looks_like_is_no_hair_where_colours_alone_tell_it(sitter, monkeypatch):
    """A wall beside a bald head."""
    wall = np.zeros_like(sitter.hair.pixels)
    wall[20:160, 20:130] = True
    mask = HairMask(wall & sitter.hair.behind, sitter.hair.behind & ~wall, 0.0, True)
    monkeypatch.setattr("caricli.methods.hair.dress_hair.mask_hair", lambda *_: mask)
    assert dress_hair(sitter.face, sitter.head, sitter.image, SMALL) is None
    asked = dress_hair(sitter.face, sitter.head, sitter.image, replace(SMALL, hair="shell"))
    assert 0 < asked.overlap < 0.6


@pytest.mark.parametrize("shown_as", ["wig", "wall", "wall like a wig"])
def test_hair_that_is_mostly_beside_the_head_is_hair_where_a_shell_is_like_it(sitter, monkeypatch, shown_as):
    """A large wig, a wall above a bald head, or a part of a wall in the shape of the wig; colours tell nothing."""
    nowhere = np.zeros((SIDE, SIDE), bool)
    monkeypatch.setattr(
        "caricli.methods.hair.dress_hair.mask_hair", lambda *_: HairMask(nowhere, nowhere, 1.0, trusted=False)
    )
    shown = rasterise(CAMERA.place(sitter.head.vertices), sitter.head.faces, SIDE, SIDE).face >= 0
    rows, columns = np.indices((SIDE, SIDE))
    x, y = sitter.face.landmarks[27]
    away = np.hypot(columns - x, rows - y)
    face = np.hypot(1.4 * (columns - x), rows - y - 25) < 80
    hair = (away < 125) & ~face & (rows < y + 70) if "wig" in shown_as else (rows < y - 60) & ~face
    regions = np.select([hair, shown], [Region.HAIR, Region.SKIN], Region.BACKGROUND)
    brown = ~(shown & ~hair) if shown_as == "wall like a wig" else hair
    image = np.where(brown[..., None], BROWN, sitter.bald).astype(np.uint8)
    assert not is_before_head(parsed_hair(sitter.face, regions, shown, image), shown)
    dressed = dress_hair(sitter.face, sitter.head, image, SMALL, regions)
    assert (dressed is not None) == (shown_as == "wig")
    if dressed is not None:
        assert dressed.overlap > 0.8 and (dressed.mask.pixels != hair).mean() < 0.01


def test_a_hood_that_goes_over_into_a_collar_and_shoulders_ends_with_them(sitter, monkeypatch):
    """Colours take all of it for hair; labels tell what is cloth. What they take for skin above stays hair."""
    rows, columns = np.indices((SIDE, SIDE))
    x, y = sitter.face.landmarks[8]
    shoulders = (rows > y) & (np.abs(columns - x) < 0.5 * SIDE) & ~sitter.hair.pixels
    hood = HairMask(sitter.hair.pixels | shoulders, sitter.hair.behind & ~shoulders, 0.1, True)
    monkeypatch.setattr("caricli.methods.hair.dress_hair.mask_hair", lambda *_: hood)
    bare = ~sitter.hair.behind
    hat = sitter.hair.pixels & (columns < x)
    regions = np.select([shoulders, hat, bare], [Region.CLOTH, Region.HAT, Region.SKIN], Region.BACKGROUND)
    image = np.where(hood.pixels[..., None], BROWN, sitter.image).astype(np.uint8)
    dressed = dress_hair(sitter.face, sitter.head, image, SMALL, regions)
    assert not (dressed.mask.pixels & shoulders).any() and dressed.overlap > 0.88
    assert (dressed.mask.pixels == sitter.hair.pixels)[rows < y].mean() > 0.99


def test_skin_that_colours_take_for_a_hood_is_none(sitter, monkeypatch):
    """A cheek beside it, in its shadow."""
    _, columns = np.indices((SIDE, SIDE))
    hood = sitter.hair.pixels
    cheek = ~sitter.hair.behind & ~hood & (columns > sitter.face.landmarks[45, 0])
    mask = HairMask(hood | cheek, sitter.hair.behind, 0.1, True)
    monkeypatch.setattr("caricli.methods.hair.dress_hair.mask_hair", lambda *_: mask)
    regions = np.select([hood, ~sitter.hair.behind], [Region.HAT, Region.SKIN], Region.BACKGROUND)
    dressed = dress_hair(sitter.face, sitter.head, sitter.image, SMALL, regions)
    np.testing.assert_array_equal(dressed.mask.pixels, hood)


@pytest.mark.parametrize("shown", ["a hat", "shreds of a hat", "hair that ends in a hat"])
def test_shreds_of_a_hat_are_no_hair(sitter, monkeypatch, shown):
    """Colours take all of it, or what is on one side; of what is labelled skin they know more."""
    rows, columns = np.indices((SIDE, SIDE))
    hair = sitter.hair.pixels
    part = hair & (columns > sitter.face.landmarks[24, 0]) if shown == "shreds of a hat" else hair
    mask = HairMask(part, sitter.hair.behind, 0.1, True)
    monkeypatch.setattr("caricli.methods.hair.dress_hair.mask_hair", lambda *_: mask)
    hat = hair
    if shown == "hair that ends in a hat":
        top = np.flatnonzero(hair.any(1))[0]
        hat = (rows < top + 8) | ((rows < top + 40) & (np.abs(columns - sitter.face.landmarks[27, 0]) < 6))
        assert (hat & hair).sum() < 0.2 * min(hat.sum(), hair.sum())
    regions = np.select([hat, ~sitter.hair.behind], [Region.HAT, Region.SKIN], Region.BACKGROUND)
    dressed = dress_hair(sitter.face, sitter.head, sitter.image, SMALL, regions)
    assert (dressed is None) == (shown == "shreds of a hat")


def test_the_skin_under_it_is_left_to_be_filled(dressed, sitter):
    shown = ~sitter.hair.behind
    bare = bare_skin(ParsedHead(shown, shown), dressed, sitter.image)
    assert not (bare & dressed.mask.pixels).any() and 0.2 < bare.sum() / shown.sum() < 0.9


def test_what_is_bare_does_not_hang_on_the_layout_of_the_landmarks(dressed, sitter):
    """With those of forehead and ears, the same face is higher."""
    shown = ~sitter.hair.behind
    points = CAMERA.project(sitter.head.vertices[sitter.head.annotation.landmarks])
    assert len(points) == 81
    more = replace(dressed, face=replace(dressed.face, landmarks=points))
    one, other = (bare_skin(ParsedHead(shown, shown), each, sitter.image) for each in (dressed, more))
    np.testing.assert_array_equal(one, other)


def test_where_hair_covers_all_nothing_is_bare(dressed, sitter):
    hair = dressed.mask.pixels
    assert not bare_skin(ParsedHead(hair, hair), dressed, sitter.image).any()


def test_a_line_in_the_colour_of_the_hair_along_the_border_of_the_face_is_left_to_be_filled(dressed, sitter):
    """A line beside an ear, which is at the border of the head; another one, in the middle of the cheek, stays."""
    skin = ~sitter.hair.behind & ~sitter.hair.pixels
    rows = round(sitter.face.landmarks[30, 1]) + np.arange(16)
    ear, border, cheek = (np.zeros_like(skin) for _ in range(3))
    for row in rows:
        first = np.flatnonzero(skin[row])[0]
        ear[row, first : first + 8] = True
        border[row, first + 9 : first + 11] = True
        cheek[row, first + 40 : first + 42] = True
    drawn = np.where((border | cheek)[..., None], BROWN, sitter.image).astype(np.uint8)
    plain, lined = (bare_skin(ParsedHead(skin, skin, ear), dressed, image) for image in (sitter.image, drawn))
    assert plain[border].all() and not lined[border].any() and lined[cheek].all()


def test_such_a_line_may_be_on_the_pixels_of_an_ear(dressed, sitter):
    """Where this begins; a hollow of the ear stays."""
    skin = ~sitter.hair.behind & ~sitter.hair.pixels
    ear, line, hollow = (np.zeros_like(skin) for _ in range(3))
    for row in round(sitter.face.landmarks[30, 1]) + np.arange(24):
        first = np.flatnonzero(skin[row])[0]
        ear[row, first : first + 30] = True
        line[row, first + 28 : first + 30] = True
        hollow[row, first + 12 : first + 14] = True
    drawn = np.where((line | hollow)[..., None], BROWN, sitter.image).astype(np.uint8)
    plain, lined = (bare_skin(ParsedHead(skin, skin, ear), dressed, image) for image in (sitter.image, drawn))
    assert plain[line].all() and not lined[line].any() and lined[hollow].mean() > 0.4


def test_a_fold_that_goes_on_inwards_from_a_line_at_the_border_is_left_to_be_filled(dressed, sitter):
    """As far in, a spot that does not hang together with the line stays."""
    skin = ~sitter.hair.behind & ~sitter.hair.pixels
    middle = round(sitter.face.landmarks[30, 1])
    line, fold, spot = (np.zeros_like(skin) for _ in range(3))
    for row in range(middle - 8, middle + 8):
        first = np.flatnonzero(skin[row])[0]
        line[row, first + 1 : first + 3] = True
    first = np.flatnonzero(skin[middle])[0]
    fold[middle : middle + 2, first + 3 : first + 18] = True
    below = np.flatnonzero(skin[middle + 12])[0]
    spot[middle + 12 : middle + 14, below + 9 : below + 14] = True
    drawn = np.where((line | fold | spot)[..., None], BROWN, sitter.image).astype(np.uint8)
    plain, lined = (bare_skin(ParsedHead(skin, skin), dressed, image) for image in (sitter.image, drawn))
    assert plain[fold].all() and not lined[fold].any() and lined[spot].all()


def test_no_tongue_of_skin_is_left_between_two_such_lines(dressed, sitter):
    """A fold beside a line at the border, joined with it below; skin beyond the fold stays."""
    skin = ~sitter.hair.behind & ~sitter.hair.pixels
    middle = round(sitter.face.landmarks[30, 1])
    lines, tongue, beyond = (np.zeros_like(skin) for _ in range(3))
    for row in range(middle - 16, middle + 4):
        first = np.flatnonzero(skin[row])[0]
        lines[row, first + 1 : first + 3] = True
        lines[row, first + 10 : first + 12] = True
        tongue[row, first + 6 : first + 8] = middle - 7 < row < middle
        beyond[row, first + 30 : first + 40] = True
        lines[row, first + 1 : first + 12] |= row >= middle + 2
    drawn = np.where(lines[..., None], BROWN, sitter.image).astype(np.uint8)
    plain, lined = (bare_skin(ParsedHead(skin, skin), dressed, image) for image in (sitter.image, drawn))
    assert plain[tongue].all() and not lined[tongue].any() and lined[beyond].all()


def test_a_strand_that_hangs_from_the_hair_is_left_to_be_filled(dressed, sitter):
    """One in the middle of the forehead; another that begins below the hair stays, and so does a brow beside it."""
    skin = ~sitter.hair.behind & ~sitter.hair.pixels
    marks = sitter.face.landmarks
    middle = round(marks[27, 0])
    end = np.flatnonzero(dressed.mask.pixels[:, middle])[-1]
    strand, mark, brow = (np.zeros_like(skin) for _ in range(3))
    strand[end + 1 : end + 9, middle - 1 : middle + 1] = True
    mark[end + 10 : end + 16, middle + 14 : middle + 16] = True
    x, y = np.rint(marks[19]).astype(int)
    brow[y - 1 : y + 1, x - 4 : x + 4] = True
    assert skin[strand].all() and skin[mark].all() and skin[brow].all()
    drawn = np.where((strand | mark | brow)[..., None], BROWN, sitter.image).astype(np.uint8)
    plain, lined = (bare_skin(ParsedHead(skin, skin), dressed, image) for image in (sitter.image, drawn))
    below = strand & plain
    assert below.any() and not lined[below].any()
    assert lined[mark].all() and lined[brow & plain].all()


def test_what_is_mixed_of_skin_and_hair_beside_it_is_left_to_be_filled(dressed, sitter):
    """Fine strands, or a shadow, under the hair; a like one in the middle of the forehead stays."""
    skin = ~sitter.hair.behind & ~sitter.hair.pixels
    middle = round(sitter.face.landmarks[27, 0])
    end = np.flatnonzero(dressed.mask.pixels[:, middle])[-1]
    shade, mark = (np.zeros_like(skin) for _ in range(2))
    shade[end + 1 : end + 4, middle - 6 : middle + 6] = True
    mark[end + 12 : end + 14, middle - 6 : middle + 6] = True
    mixed = (0.6 * sitter.image + 0.4 * np.array(BROWN)).astype(np.uint8)
    drawn = np.where((shade | mark)[..., None], mixed, sitter.image)
    plain, shaded = (bare_skin(ParsedHead(skin, skin), dressed, image) for image in (sitter.image, drawn))
    below = shade & plain
    assert below.any() and not shaded[below].any() and shaded[mark].all()


def test_none_auto_and_shell(sitter):
    assert dress_hair(sitter.face, sitter.head, sitter.image, replace(SMALL, hair="none")) is None
    assert dress_hair(sitter.face, sitter.head, sitter.bald, SMALL) is None
    with pytest.raises(InputError, match="expected hair around the face, found none; --hair none goes without"):
        dress_hair(sitter.face, sitter.head, sitter.bald, replace(SMALL, hair="shell"))


def test_a_head_whose_scalp_has_no_name(sitter):
    regions = {name: ids for name, ids in sitter.head.annotation.regions.items() if name != "scalp"}
    head = replace(sitter.head, annotation=replace(sitter.head.annotation, regions=regions))
    assert dress_hair(sitter.face, head, sitter.image, SMALL) is None
    with pytest.raises(InputError, match="expected an annotation with the region 'scalp'"):
        dress_hair(sitter.face, head, sitter.image, replace(SMALL, hair="shell"))


def test_a_highlight_is_no_speck_all_over_the_head(dressed, sitter):
    """A bright spot in the middle of dark hair that is lighter and darker."""
    hair = dressed.mask.pixels
    lighter = np.random.default_rng(0).uniform(10, 50, [-(-side // 8) for side in hair.shape])
    lighter = np.kron(lighter, np.ones((8, 8)))[: hair.shape[0], : hair.shape[1]]
    dark = np.where(hair[..., None], lighter[..., None] * [1.1, 1, 0.9], sitter.image).astype(np.uint8)
    rows, columns = np.nonzero(cv2.erode(hair.astype(np.uint8), np.ones((15, 15), np.uint8)))
    k = len(rows) // 5
    cv2.circle(dark, (int(columns[k]), int(rows[k])), 6, (77, 70, 63), -1)
    specks = {}
    for kept in (True, False):
        settings = replace(SMALL, size=384, texture=replace(SMALL.texture, keep_light=kept))
        specks[kept] = (hair_picture(dressed, dark, settings).mean(-1) > 55).sum()
    assert 0 < specks[False] < 0.3 * specks[True]
