from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, distance_transform_edt

from caricli.geometry.alignment.rotation_vectors import rotation_matrices
from caricli.methods.texture.estimate_light import Light
from caricli.methods.texture.mouth_wall import MOUTH, mouth_wall
from caricli.methods.texture.picture_view import PictureView, Sight
from caricli.methods.texture.settings import TextureSettings
from caricli.methods.texture.texture_face import texture_face
from caricli.render.pixels.diffuse_background import diffuse_background
from caricli.render.pixels.sample_texture import sample_pixels, sample_texture
from caricli.render.smooth_normals import smooth_normals
from caricli.render.visibility.rasterise import rasterise
from caricli.render.visibility.uv_map import pad_texture, uv_map
from caricli.structures import Camera, Pictures, Rig
from caricli.template.annotation import CAVITIES
from tests.textured_pictures import render_textured

SIZE, SIDE = 384, 400
MAGENTA = np.array([255.0, 0, 255])
FRONT = np.diag([1.0, -1, -1])
KEPT = TextureSettings(keep_light=True)


@dataclass(frozen=True)
class Texels:
    """Of a mesh: places (N, 3), unit normals (N, 3), and whether in the mouth, an eye socket or a nostril."""

    covered: np.ndarray
    places: np.ndarray
    normals: np.ndarray
    inside: np.ndarray


@dataclass(frozen=True)
class Scene:
    """A head in colours that are known, seen from one side in front of magenta, and what was made of its picture."""

    camera: Camera
    image: np.ndarray
    mask: np.ndarray
    found: object


def texels_of(vertices, template):
    face, weights = uv_map(template, SIZE)
    covered = face >= 0
    corners, weights = template.faces[face[covered]], weights[covered].astype(float)

    def blend(values):
        return np.einsum("nk,nkc->nc", weights, values[corners])

    normals = blend(smooth_normals(vertices, template.faces))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    pockets = template.mask(*CAVITIES, "nostril_left", "nostril_right").astype(float)[:, None]
    return Texels(covered, blend(vertices), normals, blend(pockets)[:, 0] > 0.1)


def wall_of(template):
    """(N,) from 0 to 1, how far texels are of the wall of the mouth."""
    face, weights = uv_map(template, SIZE)
    covered = face >= 0
    return (weights[covered] * mouth_wall(template)[template.faces[face[covered]]]).sum(1)


def colours(places):
    """Smooth, the same on both sides, nowhere near magenta."""
    x, y, z = 14 * (places - [0, 0.12, 0.05]).T
    x = np.abs(x)
    red, green, blue = 150 + 60 * np.sin(1.3 * y + z), 140 + 40 * np.cos(2 * x + y), 90 + 50 * np.sin(x - 1.5 * y + 1)
    return np.stack([red, green, blue], axis=1)


def still(vertices, template, texture):
    deltas = np.zeros((0, *vertices.shape), np.float32)
    return Rig((), template.with_vertices(vertices.astype(np.float32)), deltas, pictures=Pictures(texture))


def photograph(vertices, template, texture, camera):
    return render_textured(still(vertices, template, texture), camera.place(vertices), SIDE, SIDE, paper=MAGENTA)


@pytest.fixture(scope="module")
def template(head_template):
    return head_template


@pytest.fixture(scope="module")
def face(head):
    return head.evaluate(gender=0.2, age=0.7)


@pytest.fixture(scope="module")
def texels(face, template):
    return texels_of(face, template)


@pytest.fixture(scope="module")
def truth(texels, template):
    """The texture that the head has."""
    picture = np.zeros((SIZE, SIZE, 3))
    picture[texels.covered] = colours(texels_of(template.vertices, template).places)
    return np.round(pad_texture(picture, texels.covered)).astype(np.uint8)


@pytest.fixture(scope="module")
def scenes(face, template, truth):
    """By the angle to the side, in degrees."""
    made = {}
    for yaw in (0, 40, -50):
        rotation = rotation_matrices(np.radians([[0.0, yaw, 0]]))[0] @ FRONT
        middle = (face.min(0) + face.max(0)) / 2
        camera = Camera(1250.0, rotation, np.array([SIDE / 2, SIDE / 2]) - 1250 * rotation[:2] @ middle)
        image = photograph(face, template, truth, camera)
        mask = rasterise(camera.place(face), template.faces, SIDE, SIDE).face >= 0
        assert (image[~mask] == MAGENTA).all() and 0.15 < mask.mean() < 0.8
        made[yaw] = Scene(
            camera, image, mask, texture_face(template.with_vertices(face), Sight(camera, image, mask), SIZE, KEPT)
        )
    return made


@pytest.mark.parametrize("yaw", [0, 40, -50])
def test_it_looks_like_its_picture(yaw, scenes, face, template):
    scene = scenes[yaw]
    assert scene.found.image.shape == (SIZE, SIZE, 3) and scene.found.image.dtype == np.uint8
    again = photograph(face, template, scene.found.image, scene.camera).astype(float)
    assert np.abs(again - scene.image)[scene.mask].mean() < 0.03 * 255


@pytest.mark.parametrize("yaw", [0, 40, -50])
def test_no_background_anywhere(yaw, scenes, truth):
    distance = np.abs(scenes[yaw].found.image.astype(float) - MAGENTA).sum(-1)
    assert distance.min() > 150
    assert np.abs(truth - MAGENTA).sum(-1).min() < distance.min() + 40


@pytest.mark.parametrize("yaw", [0, 40, -50])
def test_what_is_seen_is_as_it_was(yaw, scenes, texels, truth):
    found = scenes[yaw].found
    np.testing.assert_array_equal(found.covered, texels.covered)
    assert found.seen.min() == 0 and found.seen.max() == 1 and not found.seen[~found.covered].any()
    cosine = -(texels.normals @ scenes[yaw].camera.rotation[2])
    sure = found.seen == 1
    assert sure[texels.covered][(cosine > 0.7) & ~texels.inside].mean() > 0.85
    error = np.abs(found.image.astype(float) - truth).mean(-1)
    assert error[sure].mean() < 2 and np.quantile(error[sure], 0.99) < 8


@pytest.mark.parametrize("yaw", [40, -50])
def test_the_hidden_side_is_that_of_the_other_one(yaw, scenes, texels, truth):
    scene = scenes[yaw]
    cosine = -(texels.normals @ scene.camera.rotation[2])
    # Of the front of the head, what looks away.
    hidden = (cosine < 0) & (texels.normals[:, 2] > 0.2) & ~texels.inside
    assert hidden.sum() > 500
    wanted = truth[texels.covered][hidden].astype(float)
    mirrored = np.abs(scene.found.image[texels.covered][hidden] - wanted).mean() / 255
    pixels = scene.camera.project(texels.places[hidden])
    flat = sample_pixels(diffuse_background(scene.image, scene.mask), pixels[:, 0], pixels[:, 1])
    projected = np.abs(flat - wanted).mean() / 255
    assert mirrored < 0.04 and mirrored < projected / 2, (mirrored, projected)


def test_no_face_on_the_back_of_the_head(face, template, texels, scenes):
    """A picture that is loud in front."""
    scene = scenes[0]
    squares = (np.indices((SIDE, SIDE)) // 12).sum(0) % 2 * 200
    image = np.where(scene.mask[..., None], np.uint8(squares[..., None] + [20, 30, 25]), scene.image)
    found = (
        texture_face(template.with_vertices(face), Sight(scene.camera, image, scene.mask), SIZE, KEPT)
        .image[texels.covered]
        .astype(float)
    )
    front, back = texels.normals[:, 2] > 0.7, (texels.normals[:, 2] < -0.5) & ~texels.inside
    corners = template.faces[uv_map(template, SIZE)[0][texels.covered]]
    for name in ("scalp", "neck"):
        region = back & template.mask(name)[corners].all(1)
        assert region.sum() > 500 and found[region].std(0).max() < 0.2 * found[front].std(0).min()
    assert (found[back].max(0) <= [220, 230, 225]).all()


@pytest.mark.parametrize("yaw", [0, 40])
def test_seams_are_not_seen(yaw, scenes, template):
    found = scenes[yaw].found
    corners, places = (rows[template.polygons >= 0] for rows in (template.polygons, template.uv_polygons))
    pairs = np.unique(np.stack([corners, places], axis=1), axis=0)
    colour = sample_texture(found.image, template.uvs)
    seen = sample_pixels(found.seen, template.uvs[:, 0] * SIZE - 0.5, (1 - template.uvs[:, 1]) * SIZE - 0.5)
    inside, compared = template.mask(*CAVITIES), 0
    for vertex in np.flatnonzero(np.bincount(pairs[:, 0]) > 1):
        uvs = pairs[pairs[:, 0] == vertex, 1]
        # Where what is seen ends, the picture may differ from what continues it.
        if not inside[vertex] and np.ptp(seen[uvs]) < 0.02:
            compared += 1
            assert np.ptp(colour[uvs], axis=0).max() <= 7, vertex
    assert compared >= 15


def test_borders_go_on_beyond_the_islands(scenes, texels):
    image = scenes[0].found.image
    np.testing.assert_array_equal(image, pad_texture(image, texels.covered))
    assert image[~texels.covered].min() > 0


def test_the_same_input_gives_the_same_bytes(scenes, face, template):
    scene = scenes[40]
    image, mask, vertices = scene.image.copy(), scene.mask.copy(), face.copy()
    head = template.with_vertices(vertices)
    first, again = (texture_face(head, Sight(scene.camera, image, mask), 64).image for _ in range(2))
    assert first.shape == (64, 64, 3) and first.tobytes() == again.tobytes()
    np.testing.assert_array_equal(image, scene.image)
    np.testing.assert_array_equal(mask, scene.mask)
    np.testing.assert_array_equal(vertices, face)


def test_what_covers_the_face_is_not_painted_on_it(scenes, face, template, texels):
    """A hand in front of the eyes, left out of the mask."""
    scene = scenes[0]
    image, mask = scene.image.copy(), scene.mask.copy()
    image[150:190, 120:280], mask[150:190, 120:280] = MAGENTA, False
    found = texture_face(template.with_vertices(face), Sight(scene.camera, image, mask), SIZE, KEPT)
    assert np.abs(found.image - MAGENTA).sum(-1).min() > 150
    assert found.seen.sum() < scene.found.seen.sum()


def test_a_mesh_without_mirror_map(scenes, face, template):
    scene = scenes[40]
    head = replace(template.with_vertices(face), annotation=replace(template.annotation, mirror=None))
    found = texture_face(head, Sight(scene.camera, scene.image, scene.mask), SIZE, KEPT)
    assert np.abs(found.image - MAGENTA).sum(-1).min() > 150
    assert found.seen.sum() < scene.found.seen.sum()
    again = photograph(face, template, found.image, scene.camera).astype(float)
    assert np.abs(again - scene.image)[scene.mask].mean() < 0.03 * 255


def test_fine_lines_come_back_and_nothing_else_changes(scenes, face, template):
    """Waves of about five texels between two colours."""
    scene = scenes[40]
    waves = 0.5 + 0.5 * np.sin(np.indices((SIDE, SIDE)).sum(0) * np.pi / 6)[..., None]
    image = np.where(scene.mask[..., None], [60, 90, 110] + waves * [100, 60, 20], scene.image).astype(np.uint8)
    found, errors = {}, {}
    usual = TextureSettings.rounds
    for rounds in (0, usual):
        settings = TextureSettings(rounds=rounds, keep_light=True)
        sight = Sight(scene.camera, image, scene.mask)
        found[rounds] = texture_face(template.with_vertices(face), sight, SIZE, settings)
        again = photograph(face, template, found[rounds].image, scene.camera).astype(float)
        sure = photograph(face, template, np.repeat(np.uint8(255 * found[rounds].seen)[..., None], 3, 2), scene.camera)
        shown = scene.mask & (sure.min(2) > 250)
        errors[rounds] = np.abs(again - image)[shown].mean()
    assert shown.mean() > 0.1 and errors[usual] < 0.85 * errors[0], errors
    np.testing.assert_array_equal(found[usual].seen, found[0].seen)
    unseen = found[0].covered & (found[0].seen == 0)
    np.testing.assert_array_equal(found[usual].image[unseen], found[0].image[unseen])
    # No ringing: between the two colours, as all was before.
    texels = found[usual].image[found[usual].covered][wall_of(template) == 0]
    assert (texels.min(0) >= [60, 90, 110]).all() and (texels.max(0) <= [160, 150, 130]).all()


def test_outlines_are_not_drawn_on_what_is_hardly_seen(scenes, face, template):
    """A black line inside the border of the mask, and ever more rounds."""
    scene = scenes[0]
    line = scene.mask & ~binary_erosion(scene.mask, iterations=3)
    image, found = np.where(line[..., None], np.uint8(0), scene.image), []
    for rounds in (0, 60):
        settings = TextureSettings(rounds=rounds, keep_light=True)
        sight = Sight(scene.camera, image, scene.mask)
        found.append(texture_face(template.with_vertices(face), sight, SIZE, settings))
    hardly = found[0].covered & (found[0].seen > 0) & (found[0].seen < 0.5)
    before, after = (one.image[hardly].astype(float) for one in found)
    assert hardly.sum() > 300 and (before - after).mean() < 0.6 and np.quantile(before - after, 0.99) < 20


def test_rim_light_stays_off_sides_but_not_off_hair(scenes, face, template, texels):
    """A head that is yellow where it turns away from the camera."""
    scene = scenes[0]
    head = template.with_vertices(face)
    raster = rasterise(scene.camera.place(face), template.faces, SIDE, SIDE)
    normals = smooth_normals(face, template.faces)[template.faces[raster.face]]
    facing = -(np.einsum("hwk,hwkc->hwc", raster.barycentric, normals) @ scene.camera.rotation[2])
    image = np.where((scene.mask & (facing < 0.4))[..., None], np.array([255, 255, 0], np.uint8), scene.image)
    lit, plain = (
        texture_face(head, Sight(scene.camera, picture, scene.mask), SIZE, KEPT) for picture in (image, scene.image)
    )
    yellow = np.abs(lit.image.astype(float) - plain.image).max(2)
    turned = -(texels.normals @ scene.camera.rotation[2])
    rim = np.zeros(texels.covered.shape, bool)
    rim[texels.covered] = (turned > 0.25) & (turned < 0.35)
    face_ids, _ = uv_map(template, SIZE)
    scalp = template.mask("scalp")[template.faces].all(1)[face_ids]
    assert (rim & scalp).sum() > 100 and (rim & ~scalp).sum() > 1000
    assert np.median(yellow[rim & ~scalp]) < 0.6 * np.median(yellow[rim & scalp])


def rim_error(scene, face, template, settings):
    """Mean difference near the border of the mask, of the picture from what is painted from it."""
    found = texture_face(template.with_vertices(face), Sight(scene.camera, scene.image, scene.mask), SIZE, settings)
    again = photograph(face, template, found.image, scene.camera).astype(float)
    rim = scene.mask & ~binary_erosion(scene.mask, iterations=6)
    return np.abs(again - scene.image)[rim].mean()


def test_a_rim_that_looks_like_what_is_inside_of_it_is_seen(scenes, face, template):
    nothing_alike = TextureSettings(keep_light=True, edge=0.03, other=1e-9)
    colours_alike = TextureSettings(keep_light=True, edge=0.03)
    wrong = rim_error(scenes[40], face, template, nothing_alike)
    assert rim_error(scenes[40], face, template, colours_alike) < 0.7 * wrong


def test_hair_before_the_skin_is_no_outline(scenes, face, template):
    """A fringe over the forehead, left out of the mask, that throws a shadow below it."""
    scene = scenes[0]
    top = np.flatnonzero(scene.mask.any(1))[0]
    mask = scene.mask.copy()
    mask[: top + 60] = False
    shadow = np.zeros_like(mask)
    shadow[top + 60 : top + 66] = mask[top + 60 : top + 66]
    image = np.where(shadow[..., None], scene.image // 2, scene.image)
    wrong = {}
    for whole in (None, scene.mask):
        sight = Sight(scene.camera, image, mask, whole)
        found = texture_face(template.with_vertices(face), sight, SIZE, KEPT)
        again = photograph(face, template, found.image, scene.camera).astype(float)
        middle = shadow & binary_erosion(scene.mask, iterations=12)
        wrong[whole is None] = np.abs(again - image)[middle].mean()
    assert middle.sum() > 300 and wrong[False] < 12 and wrong[True] > 3 * wrong[False], wrong


def test_what_a_collar_leaves_of_a_neck_is_not_painted(scenes, face, template):
    """A neck a little darker than the face: seen whole it is so, of a strip of it nothing is seen."""
    scene = scenes[0]
    head = template.with_vertices(face)
    shown = rasterise(scene.camera.place(face), template.faces, SIDE, SIDE).face
    neck = template.mask("neck")[template.faces].all(1)[shown] & (shown >= 0)
    image = np.where(neck[..., None], [190, 139, 111], [205, 150, 120]).astype(np.uint8)
    rows = np.flatnonzero(neck.any(1))
    collar = neck & (np.arange(SIDE)[:, None] > rows[0] + 0.3 * len(rows))
    seen = []
    for mask in (shown >= 0, (shown >= 0) & ~collar):
        texture = texture_face(head, Sight(scene.camera, image, mask, shown >= 0), SIZE)
        again = photograph(face, template, np.uint8(255 * texture.seen)[..., None].repeat(3, 2), scene.camera)
        seen.append(again[binary_erosion(neck, iterations=2)].mean() / 255)
    assert seen[0] > 0.3 and seen[1] < 0.01, seen


def test_paint_fades_out_beside_what_is_left_out(scenes, face, template):
    """A square in the middle of the face, of one colour."""
    scene = replace(scenes[0], image=np.full_like(scenes[0].image, 150))
    rows, columns = np.nonzero(scene.mask)
    middle = np.s_[int(rows.mean()) - 20 : int(rows.mean()) + 20, int(columns.mean()) - 20 : int(columns.mean()) + 20]
    mask = scene.mask.copy()
    mask[middle] = False
    settings = replace(KEPT, edge=0.06)
    sharp = Sight(scene.camera, scene.image, mask, scene.mask)
    faded = replace(sharp, beside=scene.mask & ~mask)
    edged, view = (PictureView(template.with_vertices(face), sight, settings) for sight in (sharp, faded))
    reach = settings.edge * scene.camera.scale * template.with_vertices(face).height
    away = distance_transform_edt(mask | ~scene.mask)
    inside = distance_transform_edt(scene.mask) > 2 * reach
    assert reach > 8 and not view.inside[middle].any()
    beside = inside & (away > 0) & (away <= reach)
    np.testing.assert_allclose(view.inside[beside], away[beside] / reach, atol=0.05)
    assert (view.inside[inside & (away > reach)] == 1).all() and (edged.inside[inside & mask] == 1).all()


def test_skin_under_hair_is_not_seen(scenes, face, template):
    """A fringe over the forehead, left out of the mask: what goes on under it is the face, not stripes of its rim."""
    scene = scenes[0]
    mask = scene.mask.copy()
    mask[: np.flatnonzero(mask.any(1))[0] + 60] = False
    sight = Sight(scene.camera, scene.image, mask, scene.mask)
    seen = texture_face(template.with_vertices(face), sight, SIZE, KEPT).seen
    shown = photograph(face, template, np.uint8(255 * seen)[..., None].repeat(3, 2), scene.camera)
    hair = binary_erosion(scene.mask & ~mask, iterations=6)
    skin = binary_erosion(mask, iterations=12)
    assert hair.sum() > 300 and shown[hair].mean() < 10 and shown[skin].mean() > 100


def test_the_size_follows_the_picture(scenes, face, template):
    scene = scenes[0]
    head = template.with_vertices(face)

    def size(factor, **limits):
        """Of a picture with so many times the pixels a side."""
        rows, columns = (np.indices((int(SIDE * factor),) * 2) / factor).astype(int)
        camera = scene.camera.zoomed(factor)
        settings = TextureSettings(smallest=32, **limits)
        image, mask = scene.image[rows, columns], scene.mask[rows, columns]
        return len(texture_face(head, Sight(camera, image, mask), settings=settings).image)

    sizes = [size(factor) for factor in (0.25, 0.5, 1)]
    assert sizes[0] > 32 and sizes[1] == 2 * sizes[0] and sizes[2] == 2 * sizes[1]
    assert size(1, largest=sizes[0]) == sizes[0]


def test_teeth_are_not_painted_on_the_wall_behind_them(head, template):
    """A picture of an open mouth that is white inside."""
    shape = head.evaluate(actions={"jawOpen": 0.8})
    share = wall_of(template)
    covered = uv_map(template, SIZE)[0] >= 0
    painted = np.full((SIZE, SIZE, 3), (200, 150, 120), np.uint8)
    painted[covered] = np.where(share[:, None] > 0, 255, (200, 150, 120))
    middle = (shape.min(0) + shape.max(0)) / 2
    camera = Camera(1250.0, FRONT, np.array([SIDE / 2, SIDE / 2]) - 1250 * FRONT[:2] @ middle)
    image = photograph(shape, template, painted, camera)
    mask = rasterise(camera.place(shape), template.faces, SIDE, SIDE).face >= 0
    assert ((image == 255).all(-1) & mask).sum() > 100
    texture = texture_face(template.with_vertices(shape), Sight(camera, image, mask), SIZE, KEPT).image[covered]
    assert np.abs(texture[share == 1] - MOUTH).max() < 2


def test_light_of_another_texture_is_taken_out_too(scenes, face, template):
    scene = scenes[0]
    head = template.with_vertices(face)
    sight = Sight(scene.camera, scene.image, scene.mask)
    kept = texture_face(head, sight, SIZE, KEPT)
    # Light from the left of the picture, twice as bright as from its right.
    light = Light(np.array([[3.0] * 3, [-1.5] * 3, *[[0.0] * 3] * 7]), np.tile([[0.3], [2.5]], 3), 1.0)
    unlit = texture_face(head, sight, SIZE, like=replace(kept, light=light))
    assert unlit.light is light
    same = texture_face(head, sight, SIZE, KEPT, like=kept)
    np.testing.assert_array_equal(same.image, kept.image)
    whole = kept.covered & (kept.seen > 0.9) & (unlit.seen > 0.9)
    ratio = (unlit.image[whole] / np.maximum(kept.image[whole].astype(float), 1)).mean(1)
    assert np.quantile(ratio, 0.95) > 1.15 * np.quantile(ratio, 0.05)


def test_a_collar_before_the_neck_stays_out_with_the_light(scenes, face, template):
    scene = scenes[0]
    head = template.with_vertices(face)
    shown = rasterise(scene.camera.place(face), template.faces, SIDE, SIDE).face
    neck = template.mask("neck")[template.faces].all(1)[shown] & (shown >= 0)
    collar = neck & (np.arange(SIDE)[:, None] > np.median(np.nonzero(neck)[0]))
    image = np.where(collar[..., None], [40, 60, 160], [205, 150, 120]).astype(np.uint8)
    sight = Sight(scene.camera, image, shown >= 0)
    blue = []
    for settings in (KEPT, TextureSettings()):
        texture = texture_face(head, sight, SIZE, settings)
        colours = texture.image[texture.covered].astype(int)
        blue.append((colours[:, 2] > colours[:, 0]).mean())
    assert blue[0] > 0.01 and blue[1] < 0.02 * blue[0], blue


def test_light_from_behind_stays_off_the_ears_but_darker_ears_are_as_seen(scenes, face, template):
    scene = scenes[0]
    head = template.with_vertices(face)
    shown = rasterise(scene.camera.place(face), template.faces, SIDE, SIDE).face
    ears = template.mask("ear_left", "ear_right")[template.faces].all(1)[shown] & (shown >= 0)
    lit, dark = (235, 215, 140), (170, 90, 70)
    off = {}
    for colour in (lit, dark):
        image = np.where(ears[..., None], colour, [205, 150, 120]).astype(np.uint8)
        for settings in (KEPT, TextureSettings()):
            texture = texture_face(head, Sight(scene.camera, image, shown >= 0), SIZE, settings)
            again = photograph(face, template, texture.image, scene.camera)[binary_erosion(ears, iterations=2)]
            off[colour, settings.keep_light] = np.abs(again - np.array(colour, float)).mean()
    assert off[lit, True] < 10 and off[lit, False] > 25, "skin in the place of light"
    assert off[dark, True] < 10 and off[dark, False] < 15, "as red as drawn"


def test_a_fold_that_goes_on_in_what_was_left_out_fades_before_it(pictured):
    camera = pictured.face.camera
    nose = np.round(pictured.face.landmarks[30]).astype(int)
    image = np.where(pictured.mask[..., None], (200, 160, 130), (255, 0, 255)).astype(np.uint8)
    image[nose[1] - 1 : nose[1] + 2, nose[0] - 30 :] = (90, 60, 50)
    beside = np.zeros(pictured.mask.shape, bool)
    beside[:, : nose[0] - 14] = True
    paint = pictured.mask & ~beside
    inside = PictureView(pictured.head, Sight(camera, image, paint, pictured.mask, beside), TextureSettings()).inside
    fold, skin = inside[nose[1], nose[0] - 14 : nose[0]], inside[nose[1] + 8, nose[0] - 14 : nose[0]]
    assert (skin[2:6] > 0.75).all() and (fold[2:6] < 0.6).all()
    assert (np.diff(fold) >= -1e-6).all() and fold[-1] > 0.9
