"""What light does on a surface, for the kernels; imported by them alone."""

# mypy: ignore-errors
# Warp reads the annotations as types of its own language, which no checker of Python knows.

import warp as wp

from caricli.render import lights

STRANDS = wp.constant(400)  # fine unevennesses around a head,
LOCKS = wp.constant(70)  # and coarse ones
STRAND_SEED = wp.constant(wp.uint32(7))
DEEP = wp.constant(0.024)  # light that reaches the deepest fold, and all that the inside of the surface gets
KEY = wp.constant(wp.vec3(*lights.KEY))
FILL = wp.constant(wp.vec3(*lights.FILL))
RIM = wp.constant(wp.vec3(*lights.RIM))
VIEW = wp.constant(wp.vec3(0.0, 0.0, -1.0))


@wp.func
def shine(n: wp.vec3, way: wp.vec3, roughness: float):
    """Light from one way that a dielectric throws straight at the camera: normalised Blinn and Phong, Schlick."""
    if roughness >= 1.0:
        return 0.0
    half = wp.normalize(way + VIEW)
    alpha = wp.max(roughness * roughness, 0.04)
    power = 2.0 / (alpha * alpha) - 2.0
    # Seen from the side everything mirrors, but what is rough much less.
    grazing = wp.pow(1.0 - wp.clamp(wp.dot(half, VIEW), 0.0, 1.0), 5.0)
    mirrored = 0.04 + 0.96 * (1.0 - roughness) * grazing
    lobe = (power + 8.0) / 8.0 * wp.pow(wp.max(wp.dot(n, half), 0.0), power)
    return mirrored * lobe * wp.smoothstep(0.0, 0.3, wp.dot(n, way))


@wp.func
def softbox(n: wp.vec3):
    """How much of the key light, a round softbox, a wet surface mirrors into the camera, 0 to 1."""
    mirrored = 2.0 * wp.dot(n, VIEW) * n - VIEW
    toward = wp.dot(mirrored, KEY)
    if toward <= 0.0:
        return 0.0
    across = wp.normalize(wp.cross(wp.vec3(0.0, 1.0, 0.0), KEY))
    x = wp.dot(mirrored, across) / toward
    y = wp.dot(mirrored, wp.cross(KEY, across)) / toward
    return wp.smoothstep(0.40, 0.28, wp.sqrt(x * x + y * y))


@wp.func
def lit(albedo: wp.vec3, n: wp.vec3, light: wp.vec3, finish: wp.vec3):
    """Linear colour of a surface under a warm key, a cool fill, a rim light and the sky.

    light: shares of key, fill and sky that arrive. finish: roughness, how far light wanders under the
    surface, and how wet it is.
    """
    # Red light wanders furthest under skin: it wraps round the terminator, and fills the borders of shadows.
    soft = finish[1]
    wrap = soft * wp.vec3(0.32, 0.15, 0.10)
    arrives = wp.vec3(wp.pow(light[0], 1.1 - 0.2 * soft), wp.pow(light[0], 1.1), wp.pow(light[0], 1.1 + 0.2 * soft))
    toward = wp.dot(n, KEY)
    direct = wp.vec3(0.0)
    for c in range(3):
        direct[c] = arrives[c] * wp.max((toward + wrap[c]) / (1.0 + wrap[c]), 0.0)
    ambient = wp.lerp(wp.vec3(0.17, 0.14, 0.125), wp.vec3(0.35, 0.37, 0.41), 0.5 - 0.5 * n[1])
    # A wet mouth throws light about: it is lit from all sides, and reaches what no ray from the sky does.
    ambient = wp.lerp(ambient, wp.vec3(0.42, 0.37, 0.34), finish[2])
    # Light that bounces inside a fold is tinted by the skin: occlusion darkens red last.
    dim = 1.3 - 0.8 * finish[2]
    sky = wp.vec3(wp.pow(light[2], dim), wp.pow(light[2], dim + 0.35 * soft), wp.pow(light[2], dim + 0.5 * soft))
    received = (
        wp.cw_mul(wp.vec3(1.00, 0.94, 0.87), direct)
        + light[1] * wp.max(wp.dot(n, FILL), 0.0) * wp.vec3(0.20, 0.23, 0.28)
        + wp.cw_mul(sky, ambient)
        + DEEP * wp.vec3(1.0)
    )
    gloss = light[0] * shine(n, KEY, finish[0]) + 0.35 * light[1] * shine(n, FILL, finish[0])
    # What is dark on skin is painted hair, which does not shine as skin does.
    brightness = (albedo[0] + albedo[1] + albedo[2]) / 3.0
    gloss *= wp.lerp(1.0, wp.smoothstep(0.0, 0.1, brightness), soft)
    # Nor does what is far back in a mouth, and painted darker for it, mirror what is before the lips.
    gloss += 0.5 * finish[2] * light[0] * softbox(n)
    gloss *= wp.lerp(1.0, wp.smoothstep(0.0, 0.25, brightness), finish[2])
    # Borders within a head are a pixel wide: as bright as its outline could be, they would be dotted lines.
    edge = wp.pow(1.0 - wp.clamp(wp.dot(n, VIEW), 0.25, 1.0), 3.0)
    glow = wp.lerp(0.2, 0.5, wp.smoothstep(0.0, 0.3, brightness)) * light[2] * edge * wp.max(wp.dot(n, RIM) + 0.25, 0.0)
    return wp.cw_mul(albedo, received) + wp.vec3(gloss + glow * 0.9, gloss + glow * 0.95, gloss + glow)


@wp.func
def strand_shine(along: wp.vec3, n: wp.vec3, way: wp.vec3, power: float):
    """Light from one way that strands throw at the camera (Kajiya and Kay 1989). along: their way."""
    half = wp.normalize(way + VIEW)
    slant = wp.dot(along, half)
    return wp.pow(wp.max(1.0 - slant * slant, 0.0), 0.5 * power) * wp.smoothstep(-0.1, 0.4, wp.dot(n, way))


@wp.func
def hair_lit(albedo: wp.vec3, n: wp.vec3, light: wp.vec3, along: wp.vec3, place: wp.vec2, shine: float):
    """Linear colour of hair.

    along: the way of strands on its surface. place: around and along them, turns and shares. shine: 0 to 1, of strands.

    Strands lie beside each other unevenly, so that highlights, which run across them, break up into lines (Scheuermann
    2004): a white one nearer to the root, one in the colour of hair nearer to the end.
    """
    fine = wp.pnoise(STRAND_SEED, wp.vec2(place[0] * float(STRANDS), place[1] * 6.0), STRANDS, 64)
    locks = wp.pnoise(STRAND_SEED, wp.vec2(place[0] * float(LOCKS), place[1] * 3.0), LOCKS, 64)
    uneven = 0.3 * fine + 0.6 * locks
    side = wp.cross(n, along)
    turned = wp.normalize(n + 0.35 * uneven * side)
    colour = lit((1.0 + 0.3 * uneven) * albedo, turned, light, wp.vec3(1.0, 0.0, 0.0))
    first = wp.normalize(along + (0.12 + 0.25 * uneven) * n)
    second = wp.normalize(along + (-0.12 + 0.25 * uneven) * n)
    for k in range(2):
        way = KEY
        strength = shine * light[0]
        if k == 1:
            way = FILL
            strength = 0.35 * shine * light[1]
        colour += 0.05 * strength * strand_shine(first, n, way, 90.0) * wp.vec3(1.0)
        colour += 0.45 * strength * strand_shine(second, n, way, 25.0) * (1.0 + uneven) * (albedo + wp.vec3(0.004))
    return colour


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
def wet_eye(albedo: wp.vec3, n: wp.vec3, light: wp.vec3, away: float, outward: wp.vec3):
    """Linear colour of an eyeball at an angle from its front; outward: the way on its surface that leads from there.

    The cornea bulges before the iris and mirrors the key light alone, or a veil would lie on the pupil; what falls
    through it lights the iris' far side.
    """
    before_iris = wp.smoothstep(0.62, 0.40, away)
    bulge = 0.8 * away * before_iris
    cornea = wp.cos(bulge) * n + wp.sin(bulge) * outward
    across = wp.smoothstep(0.18, 0.30, away) * before_iris * wp.max(-wp.dot(outward, KEY), 0.0)
    colour = lit((1.0 + 0.9 * light[0] * across) * albedo, n, light, wp.vec3(1.0, 0.3, 0.0))
    highlight = (0.2 + 0.65 * before_iris) * (0.6 + 0.4 * wp.smoothstep(0.05, 0.40, light[0])) * softbox(cornea)
    return colour + highlight * wp.vec3(1.0)


@wp.func
def to_srgb(x: float):
    """One channel from linear light, with a soft shoulder, to sRGB."""
    y = x
    if y > 0.7:
        y = 1.0 - 0.3 * wp.exp((0.7 - y) / 0.3)
    if y <= 0.0031308:
        return 12.92 * y
    return 1.055 * wp.pow(y, 1.0 / 2.4) - 0.055
