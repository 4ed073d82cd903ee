from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.hair.far_side import facing_of
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.make_shell import _taper, _without_islands, make_shell
from caricli.methods.hair.move_skull import lower_skull, raise_skull, sink_skull
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.visible_hair import union_share, visible_hair
from caricli.render.visibility.rasterise import rasterise
from caricli.structures import Mesh
from caricli.template.annotation import EARS
from tests.methods.hair.conftest import CAMERA


@pytest.fixture(scope="module")
def shell(sitter):
    return make_shell(sitter.head, CAMERA, sitter.hair)[0]


def test_the_outline_is_that_of_the_hair(shell, sitter):
    seen = visible_hair(sitter.head, shell, CAMERA, sitter.hair.pixels.shape)
    assert union_share(seen, sitter.hair.pixels) > 0.88


def test_it_is_closed_towards_the_skin_and_faces_outwards(shell):
    mesh = shell.shell
    assert (mesh.polygons[:, 3] >= 0).mean() > 0.9
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 1).sum() == 192 and uses.max() == 2
    middle = mesh.vertices.mean(0)
    outwards = (triangle_normals(mesh.vertices, mesh.faces) * (mesh.vertices[mesh.faces].mean(1) - middle)).sum(1) > 0
    assert outwards.mean() > 0.97


def test_where_nobody_sees_it_hair_leads_flat_into_the_skin():
    left = np.linspace(-0.01, 0.1, 200)
    seen, hidden = (
        _taper(left, np.full(200, 0.02), np.full(200, share), 0.24, ShellSettings()) for share in (0.0, 1.0)
    )
    for taper in (seen, hidden):
        assert not taper[left <= 0].any() and taper[-1] == 1 and (np.diff(taper) >= 0).all()
    thin = (left > 0.001) & (left < 0.01)
    assert (hidden[thin] < 0.5 * seen[thin]).all()


def test_its_rim_is_on_the_skin(shell, sitter):
    feet = shell.footing(sitter.head.vertices)
    away = np.linalg.norm(shell.shell.vertices - feet, axis=1) / sitter.head.height
    # Over ears the skin that it stands on is beside it.
    assert np.quantile(away[-192:], 0.8) < 0.01 and np.median(away[:-192]) > 0.03
    np.testing.assert_allclose(shell.weights.sum(1), 1)


def test_what_goes_on_below_the_hairline_is_deep_under_the_skin(sitter):
    """So that brows that move do not uncover it."""
    depths = []
    for deep in (ShellSettings.under, ShellSettings.deep):
        shell, head = make_shell(sitter.head, CAMERA, sitter.hair, ShellSettings(deep=deep))
        sphere = HeadSphere(head, ShellSettings(), fine=True)
        depths.append(-sphere.heights(shell.shell.vertices[:-192]) / head.height)
    below = depths[0] > 0.9 * ShellSettings.under
    above = depths[0] < 0
    assert below.sum() > 300 and np.median(depths[1][below]) > 0.015
    np.testing.assert_allclose(depths[1][above], depths[0][above], atol=1e-3)


def bare_beside(sitter, rows):
    """The hair of a sitter who has none in some rows of the picture, at the temples."""
    pixels, behind = sitter.hair.pixels.copy(), sitter.hair.behind.copy()
    pixels[rows] = False
    shown = rasterise(CAMERA.place(sitter.head.vertices), sitter.head.faces, *pixels.shape[::-1]).face >= 0
    behind[rows] = ~shown[rows]
    return replace(sitter.hair, pixels=pixels, behind=behind)


def test_skin_that_is_seen_from_aside_hardly_says_that_there_is_no_hair(sitter):
    brows = int(sitter.face.landmarks[17:27, 1].min())
    mask = bare_beside(sitter, slice(brows - 20, brows + 30))
    covered = []
    for aside in (0.0, 0.4):
        shell, head = make_shell(sitter.head, CAMERA, mask, ShellSettings(aside=aside))
        sphere = HeadSphere(head, ShellSettings(), fine=True)
        around, down = np.meshgrid(sphere.longitudes, sphere.angles)
        outer = sphere.cover(shell.shell.vertices, shell.shell.faces, around, down)
        covered.append(np.isfinite(outer) & (outer > sphere.radii))
    cut, kept = covered
    added = kept & ~cut
    facing = facing_of(sphere.points(around, down, sphere.radii), CAMERA)[added]
    assert added.sum() > 300 and not (cut & ~kept).any()
    assert np.quantile(facing, 0.9) < 0.4 and np.median(facing) < 0.2


def test_a_head_that_is_bare_at_its_sides_in_the_picture_is_so(sitter):
    """Where a shell that goes on there is far from the mask."""
    brows = int(sitter.face.landmarks[17:27, 1].min())
    mask = bare_beside(sitter, slice(brows - 20, brows + 30))
    settings = (ShellSettings(overlap=0.0), ShellSettings(overlap=1.0), ShellSettings(aside=0.0))
    usual, bare, cut = (make_shell(sitter.head, CAMERA, mask, own)[0].shell.vertices for own in settings)
    np.testing.assert_array_equal(bare, cut)
    assert np.abs(usual - bare).max() > 0.001


def creases(shell):
    """(N,) degrees by which quads side by side are turned, behind the head and away from the rim."""
    columns, rows = ShellSettings.columns, ShellSettings.rows
    grid = shell.shell.vertices[1:].reshape(rows, columns, 3)[rows // 4 : rows // 2, columns // 3 : -columns // 3]
    along, around = np.diff(grid, axis=0)[:, :-1], np.diff(grid, axis=1)[:-1]
    normals = np.cross(along, around)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return np.degrees(np.arccos(np.clip((normals[:, 1:] * normals[:, :-1]).sum(2), -1, 1))).ravel()


def test_it_has_no_creases_where_skin_has_edges(shell, sitter):
    sharp, _ = make_shell(sitter.head, CAMERA, sitter.hair, ShellSettings(facets=1e-3))
    assert np.quantile(creases(shell), 0.99) < 0.7 * np.quantile(creases(sharp), 0.99)


def test_it_has_a_place_of_its_own_in_the_picture(shell):
    mesh = shell.shell
    corners = mesh.uvs[mesh.uv_faces]
    turns = np.linalg.det(np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], 1))
    assert (turns < 0).all() or (turns > 0).all()
    assert 0 < mesh.uvs.min() and mesh.uvs.max() < 1


def test_it_goes_along_with_a_larger_head(shell, sitter):
    vertices = sitter.head.vertices
    moved = shell.moved(vertices, vertices + [0, 0.1, 0])
    np.testing.assert_allclose(
        moved.shell.vertices - shell.shell.vertices, np.broadcast_to([0, 0.1, 0], shell.shell.vertices.shape), atol=1e-9
    )


def test_a_skull_that_stands_out_is_drawn_in(sitter):
    low = replace(sitter.hair, pixels=np.roll(sitter.hair.pixels, 45, axis=0))
    low = replace(low, behind=np.roll(sitter.hair.behind, 45, axis=0) | (np.mgrid[:320, :320][0] < 60))
    sunk = sink_skull(sitter.head, CAMERA, low)
    assert CAMERA.project(sunk.vertices)[:, 1].min() > CAMERA.project(sitter.head.vertices)[:, 1].min() + 5
    face = sitter.head.annotation.regions["mouth"]
    np.testing.assert_allclose(sunk.vertices[face], sitter.head.vertices[face], atol=1e-4)
    assert isinstance(sunk, Mesh)
    untouched = sink_skull(sitter.head, CAMERA, sitter.hair)
    assert np.abs(untouched.vertices - sitter.head.vertices).max() < 0.01 * sitter.head.height


def test_ears_stay_where_they_are_seen_beside_a_skull_that_is_drawn_in(sitter):
    columns = np.nonzero(sitter.hair.pixels.any(0))[0]
    middle = columns.mean()
    narrow = np.clip(np.rint(middle + (np.arange(320) - middle) / 0.7), 0, 319).astype(int)
    seen = replace(sitter.hair, pixels=sitter.hair.pixels[:, narrow], behind=sitter.hair.behind[:, narrow])
    sunk = sink_skull(sitter.head, CAMERA, seen)
    moves = np.linalg.norm(sunk.vertices - sitter.head.vertices, axis=1) / sitter.head.height
    scalp, ears = (moves[sitter.head.mask(*names)] for names in (("scalp",), EARS))
    assert scalp.max() > 0.03 and np.quantile(ears, 0.75) < 0.005
    assert flipped_triangles(sunk.vertices, sitter.head.gradients).mean() < 1e-3


def test_hair_has_no_holes(sitter):
    """Skin that the mask shows in the middle of hair, as where a picture and a head differ at a grazing angle."""
    rows, columns = np.nonzero(sitter.hair.pixels)
    middle = columns[rows < np.quantile(rows, 0.3)].mean()
    away = np.indices(sitter.hair.pixels.shape) - np.reshape([rows.min() + 28, middle], (2, 1, 1))
    hole = (np.hypot(*away) < 9) & sitter.hair.pixels
    assert hole.sum() > 200
    hair, head = make_shell(sitter.head, CAMERA, replace(sitter.hair, pixels=sitter.hair.pixels & ~hole))
    assert visible_hair(head, hair, CAMERA, hole.shape)[hole].mean() > 0.9


def test_a_skull_goes_out_and_in_as_far_as_it_has_to(sitter):
    head = sitter.head
    sphere = HeadSphere(head, ShellSettings(), fine=True)
    patch = (sphere.angles[:, None] < 0.6) & (np.abs(np.cos(sphere.longitudes)) > 0.5)
    limit = 0.02 * head.height
    _, _, radii = sphere.seen_from(head.vertices)
    inside = sphere.nearest(patch, head.vertices)
    ears = head.mask("ear_left", "ear_right")
    for farther in (0.01, 0.05):
        least = np.where(patch, sphere.radii + farther * head.height, -np.inf)
        _, _, raised = sphere.seen_from(raise_skull(head, sphere, least, limit).vertices)
        wanted = np.clip(sphere.nearest(least, head.vertices)[inside] - radii[inside], 0, limit)
        assert (raised[inside] - radii[inside] >= wanted - 1e-9).all()
        assert (raised - radii).max() <= limit + 1e-9 and (raised >= radii - 1e-9).all()
        np.testing.assert_allclose(raised[ears], radii[ears], atol=1e-9)
        assert (raised - radii)[head.annotation.regions["mouth"]].max() < 1e-9
    most = np.where(patch, 0.97 * sphere.radii, np.inf)
    _, _, lowered = sphere.seen_from(lower_skull(head, sphere, most).vertices)
    assert (
        lowered[inside] <= np.maximum(sphere.nearest(most, head.vertices)[inside], 0.5 * radii[inside]) + 1e-9
    ).all()
    assert (lowered <= radii + 1e-9).all()


def test_the_farthest_of_points_counts_near_their_directions(sitter):
    sphere = HeadSphere(sitter.head, ShellSettings())
    longitudes, angles = np.array([0.0, 0.0, 3.1]), np.array([0.5, 0.5, 1.2])
    points = sphere.points(longitudes, angles, np.array([0.1, 0.2, 0.15]))
    farthest = sphere.farthest(points)
    np.testing.assert_allclose(sphere.nearest(farthest, points), [0.2, 0.2, 0.15])
    row = np.abs(sphere.angles - 0.5).argmin()
    assert farthest[row, -1] == farthest[row, 1] == pytest.approx(0.2), "it goes on around the grid's end"
    assert np.isneginf(farthest).mean() > 0.97


def test_bare_skin_is_no_island_wherever_longitudes_begin():
    """Half bare at random, in patches."""
    generator = np.random.default_rng(0)
    field = gaussian_filter(generator.normal(size=(156, 192)), 10, mode=("nearest", "wrap"))
    left = field - np.median(field)
    free = np.ones_like(left)
    expected = _without_islands(left, free, 0.5)
    for turn in (30, 77, 120):
        turned = _without_islands(np.roll(left, turn, axis=1), free, 0.5)
        np.testing.assert_array_equal(np.roll(turned, -turn, axis=1), expected)
