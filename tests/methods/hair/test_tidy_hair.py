from dataclasses import replace

import igl
import numpy as np

from caricli.geometry.vertex_neighbours import vertex_neighbours
from caricli.methods.hair import tidy_hair as module
from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.hair.shell_net import ShellNet
from caricli.methods.hair.snap_border import snap_border
from caricli.methods.parts.close_neck import neck_edge
from tests.methods.hair.conftest import CAMERA


def test_the_skull_is_well_under_the_hair_where_this_is_thin(shell, sitter):
    """In a dent of the hair that is hardly above the skin, and no larger than the skull's triangles."""
    least = ShellSettings.least * sitter.head.height
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    longitudes, angles, radii = sphere.seen_from(shell.shell.vertices)
    dent = np.hypot(angles - 0.3, np.sin(longitudes) * 0.3) < 0.05
    radii[dent] = sphere.ground(longitudes, angles)[dent] + 0.1 * least
    points = sphere.points(longitudes, angles, radii)
    head = module._clear_of(replace(shell, shell=shell.shell.with_vertices(points)), sphere, ShellSettings())
    after = HeadSphere(head, ShellSettings(), fine=True)
    gaps = after.heights(points[dent])
    assert dent.sum() > 5 and np.median(gaps) > 0.8 * least and gaps.min() > 0.2 * least


def test_hair_in_the_neck_below_the_skin_holds_nothing_together(shell, sitter):
    """The shell's last rings are in the neck below the nape's end, and one of their vertices far below its foot."""
    head = sitter.head
    sphere = HeadSphere(head, ShellSettings(), fine=True)
    net = ShellNet(shell.shell, sphere)
    rim = head.vertices[neck_edge(head)]
    inwards = rim[0] + 0.2 * (rim.mean(0) - rim[0])
    points = shell.shell.vertices.copy()
    points[-20 * net.columns :] = [inwards[0], (inwards[1] + head.vertices[:, 1].min()) / 2, inwards[2]]
    points[-1, 1] -= 0.2 * head.height
    assert not sphere.in_neck(points[-1:]).any()
    low = replace(shell, shell=shell.shell.with_vertices(points))
    after = module._hanging_together(low, sphere, CAMERA, net, ShellSettings()).shell.vertices
    assert sphere.in_neck(after[-20 * net.columns :]).all()
    np.testing.assert_allclose(after[1 : net.columns], points[1 : net.columns], atol=1e-12)


def test_hair_that_is_seen_from_aside_has_no_ridges(shell, sitter, monkeypatch):
    """A dented shell is evened there, and where it faces the camera it is as it was."""
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    longitudes, angles, radii = sphere.seen_from(shell.shell.vertices)
    dents = 0.01 * sitter.head.height * np.random.default_rng(0).random(len(radii))
    dented = replace(shell, shell=shell.shell.with_vertices(sphere.points(longitudes, angles, radii - dents)))
    cosines = -igl.per_vertex_normals(shell.shell.vertices, shell.shell.faces) @ CAMERA.rotation[2]
    _, mean = vertex_neighbours(shell.shell.faces, len(radii))
    rough = []
    for rounds in (0, 3):
        monkeypatch.setattr(module, "_EVEN_ROUNDS", rounds)
        points = snap_border(dented, sitter.head, CAMERA, sitter.hair)[0].shell.vertices
        away = np.linalg.norm(points - mean @ points, axis=1)
        rough.append([np.median(away[part]) for part in ((cosines > 0) & (cosines < 0.4), cosines > 0.9)])
    assert rough[1][0] < 0.8 * rough[0][0], rough
    np.testing.assert_allclose(rough[1][1], rough[0][1], rtol=0.05)


def test_hair_is_laid_where_the_picture_shows_it(shell, sitter, monkeypatch):
    """Slopes beside what goes under the skin had left a gap on a temple."""
    sphere = HeadSphere(sitter.head, ShellSettings(), fine=True)
    longitudes, angles, radii = sphere.seen_from(shell.shell.vertices)
    gap = (np.abs(longitudes - 0.3) < 0.3) & (angles < 1.2)
    buried = np.where(gap, sphere.ground(longitudes, angles) - 0.01 * sitter.head.height, radii)
    torn = replace(shell, shell=shell.shell.with_vertices(sphere.points(longitudes, angles, buried)))
    overlaps = []
    for good in (0, 1):
        monkeypatch.setattr(module, "GOOD", good)
        overlaps.append(snap_border(torn, sitter.head, CAMERA, sitter.hair)[2])
    assert overlaps[0] < 0.92 and overlaps[1] > 0.97, overlaps
