"""The kernel of `rasterise`; imported by it alone, after warp has been started."""

# mypy: ignore-errors
# Warp reads the annotations as types of its own language, which no checker of Python knows.

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.func
def across(a: wp.vec3d, b: wp.vec3d, x: wp.float64, y: wp.float64):
    """Twice the area of the triangle of a pixel and two corners.

    Corners in single precision have exact products in double: neighbours agree on which side of their edge a pixel is.
    """
    return (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)


@wp.kernel
def draw_faces(
    points: wp.array(dtype=wp.vec3),
    faces: wp.array2d(dtype=wp.int32),
    rows: wp.vec2i,
    face: wp.array2d(dtype=wp.int32),
    barycentric: wp.array2d(dtype=wp.vec3),
    depth: wp.array2d(dtype=wp.float32),
):
    """Draw all triangles into rows of a picture, one after the other: launched once, because they share its pixels.

    rows: the first, and the one after the last.
    """
    columns = face.shape[1]
    for k in range(faces.shape[0]):
        a = wp.vec3d(points[faces[k, 0]])
        b = wp.vec3d(points[faces[k, 1]])
        c = wp.vec3d(points[faces[k, 2]])
        left = wp.max(wp.min(wp.min(a[0], b[0]), c[0]), wp.float64(0.0))
        right = wp.min(wp.max(wp.max(a[0], b[0]), c[0]), wp.float64(columns - 1))
        top = wp.max(wp.min(wp.min(a[1], b[1]), c[1]), wp.float64(rows[0]))
        bottom = wp.min(wp.max(wp.max(a[1], b[1]), c[1]), wp.float64(rows[1] - 1))
        for row in range(int(wp.ceil(top)), int(wp.floor(bottom)) + 1):
            for column in range(int(wp.ceil(left)), int(wp.floor(right)) + 1):
                x = wp.float64(column)
                y = wp.float64(row)
                u = across(b, c, x, y)
                v = across(c, a, x, y)
                w = across(a, b, x, y)
                area = u + v + w
                inside = wp.min(wp.min(u, v), w) >= wp.float64(0.0) or wp.max(wp.max(u, v), w) <= wp.float64(0.0)
                if inside and area != wp.float64(0.0):
                    u = u / area
                    v = v / area
                    w = w / area
                    z = wp.float32(u * a[2] + v * b[2] + w * c[2])
                    if z < depth[row, column]:
                        depth[row, column] = z
                        face[row, column] = k
                        barycentric[row, column] = wp.vec3(wp.float32(u), wp.float32(v), wp.float32(w))
