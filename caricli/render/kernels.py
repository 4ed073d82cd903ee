"""Warp kernels; imported by `load_kernels` alone, after warp has been started."""

# mypy: ignore-errors
# Warp reads the annotations as types of its own language, which no checker of Python knows.

import warp as wp

from caricli.render.light_functions import DEEP, eye_albedo, hair_lit, lit, picture_colour, to_srgb, wet_eye
from caricli.structures import Material
from caricli.structures.pictures import PICTURED

# Nothing differentiates through these kernels; leaving the adjoints out halves the time to compile them.
wp.set_module_options({"enable_backward": False})

SKIN, EYE, HAIR, BUST = (wp.constant(int(material)) for material in PICTURED)

EYE_SHADOW = wp.constant(0.5)  # of what lids take from an eye's light: its colours, from a picture, lack it already
TEETH = wp.constant(int(Material.TEETH))
TEETH_SHADOW = wp.constant(0.75)  # of what lips take from the light of teeth: a mouth throws light about
UNLIKE = wp.constant(0.2)  # linear light between neighbouring pixels: from there on they show their steps


@wp.struct
class Rays:
    """Where rays from a surface begin and end.

    mesh: what they meet.
    start: how far above the surface.
    reach: length.
    """

    mesh: wp.uint64
    start: float
    reach: float


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
    shine: wp.array(dtype=float)  # how much strands of hair shine
    light: wp.array(dtype=wp.vec3)  # how much of the key light, the fill light and the sky reaches the vertex
    places: wp.array(dtype=wp.vec3)  # of the vertices in the pictures: u, v, and the Material
    finishes: wp.array(dtype=wp.vec3)  # by Material: roughness, how far light wanders under it, and how wet it is
    skin: wp.array3d(dtype=wp.uint8)  # sRGB, the top row first; empty where there is none
    eyes: wp.array3d(dtype=wp.uint8)
    hair: wp.array3d(dtype=wp.uint8)
    bust: wp.array3d(dtype=wp.uint8)
    eyeballs: wp.array(dtype=wp.vec4)  # centre and radius
    gaze: wp.vec3


@wp.func
def ball_colour(n: wp.vec3, scene: Scene):
    """Linear colour of an eyeball beside the mesh: its picture, which is unrolled from the front, or a simple one."""
    gaze = scene.gaze
    away = wp.acos(wp.clamp(wp.dot(n, gaze), -1.0, 1.0))
    outward = wp.normalize(n - gaze)
    outward = wp.normalize(outward - wp.dot(outward, n) * n)
    albedo = eye_albedo(away)
    if scene.eyes.shape[0] > 0:
        aside = wp.normalize(wp.cross(wp.vec3(0.0, -1.0, 0.0), gaze))
        across = wp.dot(n, aside)
        upward = wp.dot(n, wp.cross(gaze, aside))
        reach = away / (2.0 * wp.pi * wp.max(wp.sqrt(across * across + upward * upward), 1.0e-6))
        albedo = picture_colour(scene.eyes, 0.5 + reach * across, 0.5 + reach * upward)
    # The brow and the upper lid shade the ball from above.
    open_sky = wp.smoothstep(-0.55, -0.02, n[1])
    light = wp.vec3(0.20 + 0.70 * open_sky, 0.8, 0.30 + 0.30 * open_sky)
    return wet_eye(albedo, n, light, away, outward)


@wp.struct
class Spot:
    """A point of a surface: its triangle, and what lies there of what the vertices carry."""

    face: int
    place: wp.vec3
    n: wp.vec3
    light: wp.vec3
    shine: float


@wp.func
def outward_way(scene: Scene, spot: Spot):
    """The way (unit length) on a triangle's surface along which the place in its picture moves off the picture's
    middle; zero where there is none."""
    face = spot.face
    place = spot.place
    a = scene.places[wp.mesh_get_index(scene.mesh, face * 3)]
    b = scene.places[wp.mesh_get_index(scene.mesh, face * 3 + 1)]
    c = scene.places[wp.mesh_get_index(scene.mesh, face * 3 + 2)]
    p = wp.mesh_get_point(scene.mesh, face * 3)
    along = wp.mesh_get_point(scene.mesh, face * 3 + 1) - p
    aside = wp.mesh_get_point(scene.mesh, face * 3 + 2) - p
    x = place[0] - 0.5
    y = place[1] - 0.5
    twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if wp.abs(twice) < 1.0e-12:
        return wp.vec3(0.0)
    outward = (x * (c[1] - a[1]) - y * (c[0] - a[0])) * along + (y * (b[0] - a[0]) - x * (b[1] - a[1])) * aside
    outward = outward * wp.sign(twice)
    return wp.normalize(outward - wp.dot(outward, spot.n) * spot.n)


@wp.func
def mesh_eye_colour(scene: Scene, spot: Spot, albedo: wp.vec3):
    """Linear colour of an eyeball of the mesh; its places in the picture are unrolled from its front, at the middle."""
    outward = outward_way(scene, spot)
    away = 2.0 * wp.pi * wp.length(wp.vec2(spot.place[0] - 0.5, spot.place[1] - 0.5))
    light = EYE_SHADOW * spot.light + (1.0 - EYE_SHADOW) * wp.vec3(1.0)
    if wp.length(outward) == 0.0 or away > 1.6:
        return lit(albedo, spot.n, light, wp.vec3(1.0, 0.3, 0.0))
    return wet_eye(albedo, spot.n, light, away, outward)


@wp.func
def hair_colour(scene: Scene, spot: Spot, albedo: wp.vec3):
    """Linear colour of hair, whose strands run outwards from the middle of its picture."""
    outward = outward_way(scene, spot)
    if wp.length(outward) == 0.0:
        return lit(albedo, spot.n, spot.light, scene.finishes[HAIR])
    x = spot.place[0] - 0.5
    y = spot.place[1] - 0.5
    around = wp.atan2(x, y) / (2.0 * wp.pi) + 0.5
    place = wp.vec2(around, wp.sqrt(x * x + y * y))
    return hair_lit(albedo, spot.n, spot.light, outward, place, spot.shine)


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


@wp.struct
class Sample:
    """What a point of the picture shows: linear colour and coverage, its depth, and the Material, -1 for none."""

    colour: wp.vec4
    depth: float
    material: int


@wp.func
def before_eyeballs(scene: Scene, x: float, y: float, behind: Sample):
    """The nearest eyeball at (x, y), or what is behind it."""
    sample = behind
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
            if t < sample.depth and wp.dot(n, scene.gaze) > 0.3:
                rgb = ball_colour(n, scene)
                sample.colour = wp.vec4(rgb[0], rgb[1], rgb[2], 1.0)
                sample.depth = t
                sample.material = EYE
    return sample


@wp.func
def sample_at(scene: Scene, x: float, y: float):
    """What is seen at the point (x, y) of the picture."""
    origin = wp.vec3(x, y, scene.start)
    hit = outside_hit(scene.mesh, origin, wp.vec3(0.0, 0.0, 1.0), scene.reach)
    sample = Sample()
    sample.depth = scene.reach
    sample.material = -1
    if hit.found == 1:
        a = wp.mesh_get_index(scene.mesh, hit.face * 3)
        b = wp.mesh_get_index(scene.mesh, hit.face * 3 + 1)
        c = wp.mesh_get_index(scene.mesh, hit.face * 3 + 2)
        w = 1.0 - hit.u - hit.v
        spot = Spot()
        spot.face = hit.face
        spot.n = wp.normalize(hit.u * scene.normals[a] + hit.v * scene.normals[b] + w * scene.normals[c])
        spot.place = hit.u * scene.places[a] + hit.v * scene.places[b] + w * scene.places[c]
        spot.shine = hit.u * scene.shine[a] + hit.v * scene.shine[b] + w * scene.shine[c]
        plain = hit.u * scene.colours[a] + hit.v * scene.colours[b] + w * scene.colours[c]
        albedo = painted(scene, spot.place, plain)
        light = hit.u * scene.light[a] + hit.v * scene.light[b] + w * scene.light[c]
        # On an edge a weight may be a rounding error below zero, and powers of negative light are not numbers.
        spot.light = wp.max(light, wp.vec3(0.0))
        sample.material = int(spot.place[2] + 0.5)
        finish = scene.finishes[sample.material]
        if sample.material == EYE:
            rgb = mesh_eye_colour(scene, spot, albedo)
        elif sample.material == HAIR:
            rgb = hair_colour(scene, spot, albedo)
        else:
            if sample.material == TEETH:
                spot.light = TEETH_SHADOW * spot.light + (1.0 - TEETH_SHADOW) * wp.vec3(1.0)
            rgb = lit(albedo, spot.n, spot.light, finish)
        sample.colour = wp.vec4(rgb[0], rgb[1], rgb[2], 1.0)
        sample.depth = hit.t
    elif hit.found == -1:
        rgb = DEEP * scene.colours[wp.mesh_get_index(scene.mesh, hit.face * 3)]
        sample.colour = wp.vec4(rgb[0], rgb[1], rgb[2], 1.0)
    return before_eyeballs(scene, x, y, sample)


@wp.kernel
def centre_sample(scene: Scene, width: int, centres: wp.array(dtype=Sample)):
    """What is seen at the centre of a pixel."""
    i = wp.tid()
    centres[i] = sample_at(scene, float(i % width), float(i // width))


@wp.kernel
def shaded_pixel(
    scene: Scene,
    width: int,
    height: int,
    samples: int,
    centres: wp.array(dtype=Sample),
    picture: wp.array(dtype=wp.vec4),
):
    """sRGB colour and coverage of a pixel: of its centre where its neighbours are like it, else of many samples."""
    i = wp.tid()
    column = i % width
    row = i // width
    centre = centres[i]
    border = bool(False)  # noqa: UP018
    low = centre.colour
    high = centre.colour
    for j in range(9):
        x = wp.clamp(column + j % 3 - 1, 0, width - 1)
        y = wp.clamp(row + j // 3 - 1, 0, height - 1)
        other = centres[y * width + x]
        border = border or other.material != centre.material
        low = wp.min(low, other.colour)
        high = wp.max(high, other.colour)
    total = centre.colour
    count = int(1)  # noqa: UP018
    if border or wp.max(high - low) > UNLIKE:
        count = samples * samples
        total = wp.vec4(0.0)
        for j in range(count):
            # A lattice on which, unlike on a grid, no two samples share a column or a row.
            dx = (float(j) + 0.5) / float(count) - 0.5
            dy = (float(j * (samples + 1) % count) + 0.5) / float(count) - 0.5
            sample = sample_at(scene, float(column) + dx, float(row) + dy)
            total += sample.colour
    if total[3] > 0.0:
        picture[i] = wp.vec4(
            to_srgb(total[0] / total[3]),
            to_srgb(total[1] / total[3]),
            to_srgb(total[2] / total[3]),
            total[3] / float(count),
        )
