from dataclasses import replace

import cv2
import numpy as np
import pytest

from caricli.errors import InputError
from caricli.methods.hair.dress_hair import dress_hair
from caricli.methods.texture.lips_behind_nose import lips_behind_nose
from caricli.methods.texture.mask_head import mesh_pixels
from caricli.methods.texture.mouth_wall import wall_pixels
from caricli.methods.texture.paint_head import paint_head
from caricli.methods.texture.picture_view import Sight
from caricli.methods.texture.settings import PaintSettings, TextureSettings
from caricli.methods.texture.shown_teeth import shown_teeth
from caricli.methods.texture.texture_face import texture_face
from caricli.render.sky import mesh_sky
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Face, Material
from caricli.structures.landmarks import LIPS_INSIDE
from caricli.structures.parsing import Region

SMALL = PaintSettings(size=96, hair="none")


@pytest.fixture(scope="module", autouse=True)
def small_eyes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("caricli.methods.texture.eye_picture.TEXTURE", 64)
        yield


@pytest.fixture(scope="module")
def painted(pictured):
    return paint_head(pictured.face, pictured.head, pictured.image, pictured.mask, SMALL)


def test_what_it_sees_of_the_sky_is_that_of_its_mesh(pictured):
    settings = replace(SMALL, sky=True)
    painted = paint_head(pictured.face, pictured.head, pictured.image, pictured.mask, settings)
    mesh = painted.rig.face.mesh
    np.testing.assert_array_equal(painted.sky, mesh_sky(mesh.vertices, mesh.faces))


def test_a_head_with_skin_and_eyes(painted, pictured):
    rig = painted.rig
    assert rig.names == () and rig.pictures.skin.shape == (96, 96, 3) and rig.pictures.eyes.shape == (64, 64, 3)
    assert set(rig.materials) == {*Material} - {Material.HAIR, Material.CLOTH}
    assert rig.pictures.bust is not None
    np.testing.assert_array_equal(rig.neutral[:4200], pictured.head.vertices.astype(np.float32))
    np.testing.assert_array_equal(painted.head.vertices, pictured.head.vertices)
    np.testing.assert_array_equal(painted.head.uvs, pictured.head.uvs)


def test_the_figures_are_what_they_say(painted):
    assert 0 < painted.error < 0.05 and 0.1 < painted.seen < 0.7
    assert 0.05 < painted.filled < 1
    assert painted.figures() == {"size": 96, "photometric_error": painted.error, "seen": painted.seen, "hair": None}
    assert painted.describe().startswith(f"{100 * painted.seen:.0f} % of the surface seen")


def test_the_picture_itself_as_published(pictured):
    flat = paint_head(pictured.face, pictured.head, pictured.image, pictured.mask, PaintSettings(project_uv=True))
    assert flat.seen == 1 and flat.rig.pictures.skin.shape == pictured.image.shape and flat.error < 0.03
    np.testing.assert_array_equal(flat.head.uv_polygons, flat.head.polygons)
    np.testing.assert_array_equal(flat.rig.pictures.skin[pictured.mask], pictured.image[pictured.mask])


def test_the_seed_paints_the_iris_and_the_grain_of_what_is_not_seen(painted, pictured):
    other = paint_head(pictured.face, pictured.head, pictured.image, pictured.mask, replace(SMALL, seed=1)).rig
    sight = Sight(pictured.face.camera, pictured.image, pictured.mask)
    seen = texture_face(pictured.head, sight, SMALL.size).seen == 1
    np.testing.assert_array_equal(other.pictures.skin[seen], painted.rig.pictures.skin[seen])
    assert (other.pictures.skin != painted.rig.pictures.skin).any()
    assert (other.pictures.eyes != painted.rig.pictures.eyes).any()


def test_a_mesh_without_uvs_takes_the_picture_itself_only(pictured):
    bare = replace(pictured.head, uvs=None, uv_polygons=None)
    with pytest.raises(InputError, match="expected a model whose mesh has UVs, found none; --project-uv needs none"):
        paint_head(pictured.face, bare, pictured.image, pictured.mask, SMALL)
    flat = paint_head(pictured.face, bare, pictured.image, pictured.mask, PaintSettings(project_uv=True))
    assert flat.head.uvs.shape == (4200, 2)


def test_a_face_of_no_picture_is_refused(pictured):
    with pytest.raises(InputError, match="expected a face with the camera of its picture"):
        paint_head(replace(pictured.face, camera=None), pictured.head, pictured.image, pictured.mask, SMALL)


def test_a_mask_that_shows_no_head_is_refused(pictured):
    with pytest.raises(InputError, match="expected a mask that is white where the head is, found none there"):
        paint_head(pictured.face, pictured.head, pictured.image, np.zeros_like(pictured.mask), SMALL)


def test_a_small_head_of_a_large_picture_is_painted_as_by_itself(painted, pictured):
    rows, columns = pictured.mask.shape
    image = np.repeat(pictured.image[:1, :1], 3 * rows, 0).repeat(3 * columns, 1)
    mask = np.zeros(image.shape[:2], bool)
    middle = np.s_[rows : 2 * rows, columns : 2 * columns]
    image[middle] = pictured.image
    mask[middle] = pictured.mask
    corner = np.array([columns, rows])
    camera = pictured.face.camera.zoomed(1.0, -corner)
    face = replace(pictured.face, camera=camera, landmarks=pictured.face.landmarks + corner)
    settings = replace(SMALL, texture=TextureSettings(buffer=max(rows, columns), smallest=max(rows, columns)))
    again = paint_head(face, pictured.head, image, mask, settings)
    assert np.abs(again.rig.pictures.skin.astype(int) - painted.rig.pictures.skin).mean() < 0.5
    assert abs(again.error - painted.error) < 1e-3 and abs(9 * again.filled - painted.filled) < 1e-6
    assert again.face.camera is camera and again.face.landmarks is face.landmarks


def test_a_face_that_is_labelled_hair_all_over_is_painted_by_its_colours(pictured):
    regions = np.where(pictured.mask, Region.HAIR, Region.BACKGROUND).astype(np.uint8)
    regions[_between_eyes(pictured) > 0] = Region.EYES
    settings = replace(SMALL, hair="auto")
    by_colours = paint_head(pictured.face, pictured.head, pictured.image, None, settings)
    labelled = paint_head(pictured.face, pictured.head, pictured.image, None, settings, regions)
    assert labelled.seen > 0.1
    np.testing.assert_array_equal(labelled.pictures.skin, by_colours.pictures.skin)


def test_so_is_one_that_hair_covers_all_over_and_hair_by_colours_is_painted_nevertheless(pictured, monkeypatch):
    """Labels of hair on a face that leave nothing bare; then colours that leave nothing bare, either."""
    worn = []

    def dress(face, template, image, settings, regions=None, pixels=None):
        pixels = mesh_pixels(face, image)
        dressed = dress_hair(face, template, image, replace(settings, hair="shell"))
        worn.append(regions is not None)
        return replace(dressed, mask=replace(dressed.mask, pixels=pixels | dressed.mask.pixels))

    image = pictured.image.copy()
    rows = np.arange(len(image))[:, None]
    image[(rows < pictured.face.landmarks[17:27, 1].min() - 25) & pictured.mask] = (80, 50, 30)
    regions = np.where(pictured.mask, Region.HAIR, Region.BACKGROUND).astype(np.uint8)
    monkeypatch.setattr("caricli.methods.texture.paint_head.dress_hair", dress)
    settings = replace(SMALL, hair="auto")
    covered = paint_head(pictured.face, pictured.head, image, None, settings, regions)
    assert worn == [True, False] and covered.seen > 0.1
    by_colours = paint_head(pictured.face, pictured.head, image, None, settings)
    np.testing.assert_array_equal(covered.pictures.skin, by_colours.pictures.skin)


def test_a_mask_of_one_pixel_paints_nothing_and_breaks_nothing(pictured, painted):
    mask = np.zeros_like(pictured.mask)
    row, column = np.argwhere(pictured.mask).mean(0).astype(int)
    mask[row, column] = True
    hardly = paint_head(pictured.face, pictured.head, pictured.image, mask, SMALL)
    assert hardly.seen < 0.01 and hardly.rig.pictures.skin.shape == painted.rig.pictures.skin.shape


def test_uvs_beyond_the_texture_are_refused(pictured):
    tile = replace(pictured.head, uvs=pictured.head.uvs + [1, 0])
    with pytest.raises(InputError, match="expected a mesh whose UVs are from 0 to 1, found them from 0.* to 2"):
        paint_head(pictured.face, tile, pictured.image, pictured.mask, SMALL)


def test_dark_glasses_are_no_eyes(pictured):
    lenses = cv2.dilate(_between_eyes(pictured), np.ones((9, 9), np.uint8)) > 0
    image = pictured.image.copy()
    image[lenses] = (20, 20, 25)
    regions = np.where(pictured.mask, Region.SKIN, Region.BACKGROUND).astype(np.uint8)
    regions[lenses] = Region.GLASSES
    eyes = paint_head(pictured.face, pictured.head, image, None, SMALL, regions).rig.pictures.eyes
    assert eyes[32, 2].mean() > 120


def test_a_nose_before_the_lip_is_no_paint_of_it(pictured):
    camera = pictured.face.require_camera()
    regions = np.where(pictured.mask, Region.SKIN, Region.BACKGROUND).astype(np.uint8)
    above = regions[: round(pictured.face.landmarks[51, 1]) + 3]
    above[above == Region.SKIN] = Region.NOSE
    before = lips_behind_nose(pictured.head, camera, regions)
    assert before.sum() > 10
    image = np.where(before[..., None], (0, 255, 0), pictured.image).astype(np.uint8)
    red, green, _ = np.moveaxis(
        paint_head(pictured.face, pictured.head, image, None, SMALL, regions).pictures.skin.astype(int), 2, 0
    )
    assert (green - red).max() < 40


def test_what_is_seen_in_an_open_mouth_is_no_error(pictured, head):
    """Teeth would hide the wall behind them."""
    shape = pictured.head.with_vertices(head.evaluate(gender=0.3, age=0.6, actions={"jawOpen": 1.0}))
    camera = pictured.face.require_camera()
    face = Face(shape, camera, camera.project(shape.vertices[shape.annotation.landmarks[:68]]))
    mask = mesh_pixels(face, pictured.image)
    wall = wall_pixels(shape, camera, pictured.image.shape[:2])
    assert wall.sum() > 100
    skin = np.where(mask[..., None], (205, 150, 120), (255, 0, 255))
    images = (np.where(wall[..., None], colour, skin).astype(np.uint8) for colour in ((70, 20, 20), (255, 255, 255)))
    dark, white = (paint_head(face, pictured.head, image, mask, SMALL).error for image in images)
    assert abs(white - dark) < 0.003


def test_teeth_are_as_long_as_the_label_map_shows_them(pictured, head):
    shape = pictured.head.with_vertices(head.evaluate(gender=0.3, age=0.6, actions={"jawOpen": 1.0}))
    camera = pictured.face.require_camera()
    face = Face(shape, camera, camera.project(shape.vertices[shape.annotation.landmarks[:68]]))
    regions = np.where(mesh_pixels(face, pictured.image), Region.SKIN, Region.BACKGROUND).astype(np.uint8)
    mouth = np.round(face.landmarks[list(LIPS_INSIDE)]).astype(np.int32)
    cv2.fillPoly(regions, [mouth], int(Region.MOUTH))
    upper = regions[: round(mouth[:, 1].mean())]
    upper[upper == Region.MOUTH] = Region.TEETH
    teeth = paint_head(face, pictured.head, pictured.image, None, SMALL, regions).face.teeth
    np.testing.assert_array_equal(teeth, shown_teeth(face, shape, regions))
    assert teeth[0] > 0.005


def _between_eyes(pictured):
    """(H, W) uint8, 1 at the eyes and between them."""
    outline = cv2.convexHull(pictured.face.landmarks[36:48].astype(np.float32))
    return cv2.fillPoly(np.zeros(pictured.mask.shape, np.uint8), [np.round(outline).astype(np.int32)], 1)


def test_light_is_taken_out_and_the_error_measured_in_it(pictured):
    """A lamp from the side: without it both halves of the face have their colours again."""
    camera = pictured.face.require_camera()
    head = pictured.head
    raster = rasterise(camera.place(head.vertices), head.faces, *pictured.image.shape[1::-1])
    shown = raster.face >= 0
    normals = smooth_normals(head.vertices, head.faces)
    sideways = np.einsum("nk,nk->n", raster.barycentric[shown], normals[head.faces[raster.face[shown]]][..., 0])
    image = pictured.image.copy()
    image[shown] = np.clip(image[shown] * (0.8 + 0.35 * sideways[:, None]), 0, 255).astype(np.uint8)

    out, kept = (
        paint_head(
            pictured.face, head, image, pictured.mask, PaintSettings(96, texture=TextureSettings(keep_light=keep))
        )
        for keep in (False, True)
    )
    assert out.light is not None and kept.light is None
    assert out.figures()["light"] == out.light.figures() and "light" not in kept.figures()
    assert out.error < kept.error + 0.01

    def halves(texture):
        """Brightness of the left half of the cheeks over that of the right."""
        rows = texture[45:65].mean((0, 2))
        return rows[60:75].mean() / rows[21:36].mean()

    assert abs(halves(out.pictures.skin) - 1) < 0.4 * abs(halves(kept.pictures.skin) - 1)


def test_eyes_have_the_colour_of_their_picture_also_on_white_paper_and_none_in_a_grey_one(pictured):
    paper = np.where(pictured.mask[..., None], pictured.image, np.uint8(255))
    grey = paper.mean(2, keepdims=True).astype(np.uint8).repeat(3, 2)
    chroma = []
    for image in (paper, grey):
        # Most of the picture is paper.
        wide = np.pad(image, ((0, 0), (0, 600), (0, 0)), constant_values=255)
        mask = np.pad(pictured.mask, ((0, 0), (0, 600)))
        eyes = paint_head(pictured.face, pictured.head, wide, mask, SMALL).rig.pictures.eyes.astype(int)
        chroma.append(np.ptp(eyes, axis=2).mean())
    assert chroma[0] > 10 and chroma[1] == 0, chroma
