"""Warp kernels; imported by `warp_start` alone, after warp has been started."""

# mypy: ignore-errors
# Warp reads the annotations as types of its own language, which no checker of Python knows.

import warp as wp

from caricli.structures.pictures import PICTURED

# Nothing differentiates through these kernels; leaving the adjoints out halves the time to compile them.
wp.set_module_options({"enable_backward": False})

DEEP = wp.constant(0.024)  # light that reaches the deepest fold, and all that the inside of the surface gets
KEY = wp.constant(wp.normalize(wp.vec3(-0.58, -0.56, -0.59)))  # the ways to the lights, in the picture's frame
FILL = wp.constant(wp.normalize(wp.vec3(0.85, -0.05, -0.52)))
RIM = wp.constant(wp.normalize(wp.vec3(0.62, -0.50, 0.60)))
VIEW = wp.constant(wp.vec3(0.0, 0.0, -1.0))
SKIN, EYE, HAIR, BUST = (wp.constant(int(material)) for material in PICTURED)


@wp.struct
class Rays:
    """Where rays begin and end.

    mesh: what they meet.
    start: depth at which rays into a picture begin, or how far above a surface those from its vertices do.
    reach: length.
    """

    mesh: wp.uint64
    start: float
    reach: float


@wp.kernel
def nearest_face(
    rays: Rays,
    width: int,
    face: wp.array(dtype=wp.int32),
    barycentric: wp.array(dtype=wp.vec3),
    depth: wp.array(dtype=wp.float32),
):
    """First triangle that the ray through a pixel's centre meets."""
    i = wp.tid()
    origin = wp.vec3(float(i % width), float(i // width), rays.start)
    hit = wp.mesh_query_ray(rays.mesh, origin, wp.vec3(0.0, 0.0, 1.0), rays.reach)
    if hit.result:
        face[i] = hit.face
        barycentric[i] = wp.vec3(hit.u, hit.v, 1.0 - hit.u - hit.v)
        depth[i] = rays.start + hit.t


@wp.struct
class Outside:
    """Where a ray meets a mesh from outside."""

    found: int  # 1 from outside; 0 not at all; -1 from inside only
    face: int
    u: float
    v: float
    t: float


@wp.func
def outside_hit(mesh: wp.uint64, origin: wp.vec3, way: wp.vec3, reach: float):
    """Nearest triangle that faces the ray; those seen from inside are passed, as viewers of GLB files do.

    Where a fold pokes through the skin (the mouth's cavity through a receding chin) the skin behind it is found.
    """
    outside = Outside()
    travelled = float(0.0)  # noqa: UP018 (a variable to warp; a literal would be a constant)
    passed = int(0)  # noqa: UP018
    while passed < 6:  # not `for`: warp would unroll it into six copies of the whole query
        passed += 1
        hit = wp.mesh_query_ray(mesh, origin + travelled * way, way, reach - travelled)
        if not hit.result:
            return outside
        if outside.found == 0:
            outside.found = -1
            outside.face = hit.face
            outside.t = hit.t
        travelled += hit.t
        if wp.dot(hit.normal, way) < 0.0:
            outside.found = 1
            outside.face = hit.face
            outside.u = hit.u
            outside.v = hit.v
            outside.t = travelled
            return outside
        travelled += 1.0e-5 * reach
    return outside


@wp.kernel
def sky_seen(
    rays: Rays,
    points: wp.array(dtype=wp.vec3),
    normals: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),
    seen: wp.array2d(dtype=wp.float32),
):
    """One where a vertex sees the sky in a direction; zero where the mesh is in the way or it lies behind."""
    i, j = wp.tid()
    if wp.dot(normals[i], directions[j]) > 0.0:
        hit = outside_hit(rays.mesh, points[i] + rays.start * normals[i], directions[j], rays.reach)
        if hit.found != 1:
            seen[i, j] = 1.0


@wp.kernel
def light_share(
    seen: wp.array2d(dtype=wp.float32),
    normals: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),
    strengths: wp.array2d(dtype=wp.float32),
    share: wp.array2d(dtype=wp.float32),
):
    """Light that reaches a vertex over light that could without the mesh in the way; one where none could."""
    i, k = wp.tid()
    could = float(0.0)  # noqa: UP018
    does = float(0.0)  # noqa: UP018
    for j in range(directions.shape[0]):
        light = wp.max(wp.dot(normals[i], directions[j]), 0.0) * strengths[k, j]
        could += light
        does += light * seen[i, j]
    share[i, k] = 1.0
    if could > 1.0e-6:
        share[i, k] = does / could


@wp.struct
class Scene:
    """A mesh in pixels (x right, y down, z into the picture) with what its vertices carry, and eyeballs."""

    mesh: wp.uint64
    start: float
    reach: float
    normals: wp.array(dtype=wp.vec3)
    colours: wp.array(dtype=wp.vec3)
    light: wp.array(dtype=wp.vec3)  # how much of the key light, the fill light and the sky reaches the vertex
    places: wp.array(dtype=wp.vec3)  # of the vertices in the pictures: u, v, and the Material; or empty
    skin: wp.array3d(dtype=wp.uint8)  # sRGB, the top row first; empty where there is none
    eyes: wp.array3d(dtype=wp.uint8)
    hair: wp.array3d(dtype=wp.uint8)
    bust: wp.array3d(dtype=wp.uint8)
    eyeballs: wp.array(dtype=wp.vec4)  # centre and radius
    gaze: wp.vec3


@wp.func
def lit(albedo: wp.vec3, n: wp.vec3, light: wp.vec3, gloss: float):
    """Linear colour of a soft matte surface under a warm key, a cool fill, a rim light and the sky."""
    # Red light wanders further under skin, so red wraps further round the terminator than blue.
    wrap = wp.vec3(0.30, 0.16, 0.12)
    toward = wp.dot(n, KEY)
    direct = wp.vec3(0.0)
    for c in range(3):
        direct[c] = wp.max((toward + wrap[c]) / (1.0 + wrap[c]), 0.0)
    ambient = wp.lerp(wp.vec3(0.20, 0.165, 0.15), wp.vec3(0.40, 0.42, 0.46), 0.5 - 0.5 * n[1])
    # Light that bounces inside a fold is tinted by the skin: occlusion darkens red last.
    sky = wp.vec3(wp.pow(light[2], 1.15), wp.pow(light[2], 1.45), wp.pow(light[2], 1.55))
    received = (
        light[0] * wp.cw_mul(wp.vec3(1.02, 0.97, 0.90), direct)
        + light[1] * wp.max(wp.dot(n, FILL), 0.0) * wp.vec3(0.20, 0.23, 0.28)
        + wp.cw_mul(sky, ambient)
        + DEEP * wp.vec3(1.0)
    )
    edge = wp.pow(1.0 - wp.clamp(wp.dot(n, VIEW), 0.0, 1.0), 3.0)
    shine = gloss * light[0] * wp.pow(wp.max(wp.dot(n, wp.normalize(KEY + VIEW)), 0.0), 24.0)
    glow = 0.55 * light[2] * edge * wp.max(wp.dot(n, RIM) + 0.25, 0.0)
    return wp.cw_mul(albedo, received) + wp.vec3(shine + glow * 0.9, shine + glow * 0.95, shine + glow)


@wp.func
def linear(srgb: float):
    """One channel from sRGB, 0 to 1, to linear light."""
    if srgb <= 0.04045:
        return srgb / 12.92
    return wp.pow((srgb + 0.055) / 1.055, 2.4)


@wp.func
def texel(picture: wp.array3d(dtype=wp.uint8), row: int, column: int):
    """sRGB, 0 to 255; beyond the picture its outermost texels go on."""
    i = wp.clamp(row, 0, picture.shape[0] - 1)
    j = wp.clamp(column, 0, picture.shape[1] - 1)
    return wp.vec3(float(picture[i, j, 0]), float(picture[i, j, 1]), float(picture[i, j, 2]))


@wp.func
def picture_colour(picture: wp.array3d(dtype=wp.uint8), u: float, v: float):
    """Linear colour at a place of a picture, bilinear; (0, 0) is its bottom left corner."""
    x = u * float(picture.shape[1]) - 0.5
    y = (1.0 - v) * float(picture.shape[0]) - 0.5
    column = int(wp.floor(x))
    row = int(wp.floor(y))
    right = x - float(column)
    down = y - float(row)
    upper = wp.lerp(texel(picture, row, column), texel(picture, row, column + 1), right)
    lower = wp.lerp(texel(picture, row + 1, column), texel(picture, row + 1, column + 1), right)
    srgb = wp.lerp(upper, lower, down) / 255.0
    return wp.vec3(linear(srgb[0]), linear(srgb[1]), linear(srgb[2]))


@wp.func
def eye_albedo(away: float):
    """Linear colour of a simple eyeball at an angle from its front: off-white, brown iris with a dark rim, pupil."""
    white = wp.vec3(0.78, 0.74, 0.70)
    iris = wp.lerp(wp.vec3(0.16, 0.085, 0.04), wp.vec3(0.045, 0.022, 0.012), wp.smoothstep(0.30, 0.44, away))
    albedo = wp.lerp(iris, white, wp.smoothstep(0.43, 0.47, away))
    return wp.lerp(wp.vec3(0.006, 0.005, 0.005), albedo, wp.smoothstep(0.17, 0.20, away))


@wp.func
def eye_colour(n: wp.vec3, scene: Scene):
    """Linear colour of an eyeball: its picture, which is unrolled from the front, or a simple one; one highlight."""
    gaze = scene.gaze
    away = wp.acos(wp.clamp(wp.dot(n, gaze), -1.0, 1.0))
    albedo = eye_albedo(away)
    if scene.eyes.shape[0] > 0:
        aside = wp.normalize(wp.cross(wp.vec3(0.0, -1.0, 0.0), gaze))
        across = wp.dot(n, aside)
        upward = wp.dot(n, wp.cross(gaze, aside))
        reach = away / (2.0 * wp.pi * wp.max(wp.sqrt(across * across + upward * upward), 1.0e-6))
        albedo = picture_colour(scene.eyes, 0.5 + reach * across, 0.5 + reach * upward)
    glint = wp.smoothstep(0.985, 0.992, wp.dot(n, wp.normalize(wp.vec3(-0.22, -0.27, -0.94))))
    # The brow and the upper lid shade the ball from above.
    open_sky = wp.smoothstep(-0.70, -0.10, n[1])
    light = wp.vec3(0.35 + 0.5 * open_sky, 0.8, 0.45 + 0.15 * open_sky)
    return lit(albedo, n, light, 0.0) + 0.9 * glint * wp.vec3(1.0)


@wp.func
def painted(scene: Scene, place: wp.vec3, plain: wp.vec3):
    """Linear colour of a place in the pictures; the plain one where its material has no picture."""
    material = int(place[2] + 0.5)
    if material == SKIN and scene.skin.shape[0] > 0:
        return picture_colour(scene.skin, place[0], place[1])
    if material == EYE and scene.eyes.shape[0] > 0:
        return picture_colour(scene.eyes, place[0], place[1])
    if material == HAIR and scene.hair.shape[0] > 0:
        return picture_colour(scene.hair, place[0], place[1])
    if material == BUST and scene.bust.shape[0] > 0:
        return picture_colour(scene.bust, place[0], place[1])
    return plain


@wp.func
def before_eyeballs(scene: Scene, x: float, y: float, reach: float, behind: wp.vec4):
    """Linear colour and coverage of the nearest eyeball within reach at (x, y), or what is behind."""
    colour = behind
    nearest = reach
    for k in range(scene.eyeballs.shape[0]):
        ball = scene.eyeballs[k]
        dx = x - ball[0]
        dy = y - ball[1]
        inside = ball[3] * ball[3] - dx * dx - dy * dy
        if inside > 0.0:
            dz = -wp.sqrt(inside)
            t = ball[2] + dz - scene.start
            n = wp.vec3(dx, dy, dz) / ball[3]
            # No lid opens further than this: beyond it the ball would only show through a thin temple.
            if t < nearest and wp.dot(n, scene.gaze) > 0.3:
                nearest = t
                rgb = eye_colour(n, scene)
                colour = wp.vec4(rgb[0], rgb[1], rgb[2], 1.0)
    return colour


@wp.func
def seen_colour(scene: Scene, x: float, y: float):
    """Linear colour and coverage (one or zero) of the point (x, y) of the picture."""
    origin = wp.vec3(x, y, scene.start)
    hit = outside_hit(scene.mesh, origin, wp.vec3(0.0, 0.0, 1.0), scene.reach)
    colour = wp.vec4(0.0)
    nearest = scene.reach
    if hit.found == 1:
        nearest = hit.t
        a = wp.mesh_get_index(scene.mesh, hit.face * 3)
        b = wp.mesh_get_index(scene.mesh, hit.face * 3 + 1)
        c = wp.mesh_get_index(scene.mesh, hit.face * 3 + 2)
        w = 1.0 - hit.u - hit.v
        n = wp.normalize(hit.u * scene.normals[a] + hit.v * scene.normals[b] + w * scene.normals[c])
        albedo = hit.u * scene.colours[a] + hit.v * scene.colours[b] + w * scene.colours[c]
        if scene.places.shape[0] > 0:
            place = hit.u * scene.places[a] + hit.v * scene.places[b] + w * scene.places[c]
            albedo = painted(scene, place, albedo)
        light = hit.u * scene.light[a] + hit.v * scene.light[b] + w * scene.light[c]
        # On an edge a weight may be a rounding error below zero, and powers of negative light are not numbers.
        light = wp.max(light, wp.vec3(0.0))
        rgb = lit(albedo, n, light, 0.05)
        colour = wp.vec4(rgb[0], rgb[1], rgb[2], 1.0)
    elif hit.found == -1:
        rgb = DEEP * scene.colours[wp.mesh_get_index(scene.mesh, hit.face * 3)]
        colour = wp.vec4(rgb[0], rgb[1], rgb[2], 1.0)
    return before_eyeballs(scene, x, y, nearest, colour)


@wp.func
def to_srgb(x: float):
    """One channel from linear light, with a soft shoulder, to sRGB."""
    y = x
    if y > 0.7:
        y = 1.0 - 0.3 * wp.exp((0.7 - y) / 0.3)
    if y <= 0.0031308:
        return 12.92 * y
    return 1.055 * wp.pow(y, 1.0 / 2.4) - 0.055


@wp.kernel
def centre_colour(scene: Scene, width: int, centres: wp.array(dtype=wp.vec4)):
    """Linear colour and coverage at the centre of a pixel."""
    i = wp.tid()
    centres[i] = seen_colour(scene, float(i % width), float(i // width))


@wp.kernel
def shaded_pixel(
    scene: Scene,
    width: int,
    height: int,
    samples: int,
    centres: wp.array(dtype=wp.vec4),
    picture: wp.array(dtype=wp.vec4),
):
    """sRGB colour and coverage of a pixel: of its centre where its neighbours are like it, else of many samples."""
    i = wp.tid()
    column = i % width
    row = i // width
    low = centres[i]
    high = centres[i]
    for j in range(9):
        x = wp.clamp(column + j % 3 - 1, 0, width - 1)
        y = wp.clamp(row + j // 3 - 1, 0, height - 1)
        low = wp.min(low, centres[y * width + x])
        high = wp.max(high, centres[y * width + x])
    total = centres[i]
    count = int(1)  # noqa: UP018
    if wp.max(high - low) > 0.12:
        count = samples * samples
        total = wp.vec4(0.0)
        for j in range(count):
            # A lattice on which, unlike on a grid, no two samples share a column or a row.
            dx = (float(j) + 0.5) / float(count) - 0.5
            dy = (float(j * (samples + 1) % count) + 0.5) / float(count) - 0.5
            total += seen_colour(scene, float(column) + dx, float(row) + dy)
    if total[3] > 0.0:
        picture[i] = wp.vec4(
            to_srgb(total[0] / total[3]),
            to_srgb(total[1] / total[3]),
            to_srgb(total[2] / total[3]),
            total[3] / float(count),
        )
