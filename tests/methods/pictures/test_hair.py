from dataclasses import replace

import numpy as np
import pytest

from caricli.methods.hair.head_sphere import HeadSphere
from caricli.methods.hair.settings import ShellSettings
from caricli.methods.pictures import hair
from caricli.methods.pictures.hair import HATS, random_beard, random_hat, random_wig
from caricli.methods.pictures.piece import make_piece
from caricli.methods.pictures.settings import SitterSettings
from caricli.render.smooth_normals import smooth_normals
from caricli.structures.parsing import Region

SEEDS = range(6)
BROWN = np.array([0.2, 0.1, 0.05])


@pytest.fixture(scope="module")
def sphere(head_template):
    return HeadSphere(head_template, ShellSettings(coarse=(40, 48)))


def wigs(sphere, **settings):
    return [
        random_wig(sphere, BROWN, np.random.default_rng(seed), replace(SitterSettings(), **settings)) for seed in SEEDS
    ]


def above_skin(sphere, points):
    """Metres that points stand above the skin, along the ways from the middle of the head."""
    longitudes, angles, radii = sphere.seen_from(points)
    return radii - sphere.sample(sphere.radii, longitudes, angles)


def rings(piece):
    """(R, C, 3) vertices, from the whorl to the edge."""
    return piece.vertices[1:].reshape(hair.ROWS, hair.COLUMNS, 3)


def boundary_of(faces):
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0, return_counts=True)


def test_hair_is_a_cap_that_faces_outwards(sphere):
    for piece, _ in wigs(sphere):
        edges, counts = boundary_of(piece.faces)
        last = np.arange(hair.COLUMNS) + 1 + (hair.ROWS - 1) * hair.COLUMNS
        assert counts.max() == 2 and set(edges[counts == 1].ravel()) == set(last)
        middles = piece.vertices[piece.faces].mean(1) - sphere.middle
        a, b, c = np.moveaxis(piece.vertices[piece.faces], 1, 0)
        outwards = (np.cross(b - a, c - a) * middles).sum(1) > 0
        assert outwards.mean() > 0.9 and outwards[(piece.faces == 0).any(1)].all()
        assert (piece.region == Region.HAIR).all()


def test_hair_stands_off_the_skin_and_ends_below_it(sphere):
    height = sphere.head.height
    for piece, thickness in wigs(sphere, thickness=(0.05, 0.05), sides=(80, 80), back=(100, 100)):
        assert (thickness > 0).all()
        crown = thickness[sphere.angles < 0.5]
        assert 0.02 * height < crown.min() and crown.max() < 0.09 * height
        above = above_skin(sphere, rings(piece).reshape(-1, 3)).reshape(hair.ROWS, hair.COLUMNS)
        assert (above[:-1] > -1e-3 * height).mean() > 0.97 and np.median(above[4]) > 0.03 * height
        # It closes towards its edge, which is in the skin.
        assert np.median(above[-1]) == pytest.approx(-0.01 * height, abs=0.003 * height)
        assert np.median(above[-2]) < 0.6 * np.median(above[4])


def test_hair_ends_where_it_is_to_over_the_forehead_beside_it_and_behind(sphere):
    for piece, _ in wigs(sphere, fringe=(60, 60), sides=(100, 100), back=(140, 140)):
        longitudes, angles, _ = sphere.seen_from(rings(piece)[-1])
        away, down = np.abs(np.degrees(longitudes)), np.degrees(angles)
        assert down[away < 20].mean() == pytest.approx(60, abs=12)
        assert down[np.abs(away - 90) < 8].mean() == pytest.approx(100, abs=10)
        assert down[away > 170].mean() == pytest.approx(140, abs=8)


def test_a_parting_lifts_the_fringe_on_one_side_alone(sphere):
    """Nothing of it is behind the ears."""
    odd = []
    for piece, _ in wigs(sphere, fringe=(60, 60), sides=(100, 100), back=(140, 140)):
        longitudes, angles, _ = sphere.seen_from(rings(piece)[-1])
        left, right = (np.degrees(angles[np.abs(longitudes - side * 0.9) < 0.3].mean()) for side in (1, -1))
        behind = [np.degrees(angles[np.abs(longitudes - side * 2.6) < 0.3].mean()) for side in (1, -1)]
        assert abs(behind[0] - behind[1]) < 4
        odd.append(left - right)
    assert max(odd) > 4


def test_long_hair_falls_and_does_not_follow_the_neck(sphere):
    neck = 0.0
    for piece, thickness in wigs(sphere, fringe=(60, 60), sides=(140, 140), back=(150, 150), thickness=(0.03, 0.03)):
        longitudes, angles, _ = sphere.seen_from(piece.vertices)
        low = (np.abs(longitudes) > 2) & (angles > np.radians(115)) & (angles < np.radians(130))
        neck = max(neck, np.median(above_skin(sphere, piece.vertices[low])) / sphere.head.height)
        face = np.abs(sphere.longitudes) < 0.5
        assert thickness[np.ix_(sphere.angles > 2.0, face)].max() < 0.06 * sphere.head.height
    assert neck > 0.06


def test_hair_has_its_colour_and_whole_pictures_of_strands_around(sphere):
    for piece, _ in wigs(sphere):
        np.testing.assert_allclose(
            piece.colours / piece.colours[:, :1], np.tile(BROWN / BROWN[0], (len(piece.colours), 1))
        )
        across, along = piece.strands[1:].reshape(hair.ROWS, hair.COLUMNS, 2).transpose(2, 0, 1)
        step = np.diff(across, axis=1)
        assert np.ptp(step) < 1e-9 and (step[0, 0] * hair.COLUMNS) % 1 == pytest.approx(0, abs=1e-9)
        assert (np.diff(along, axis=0) > 0).all() and not np.ptp(along, axis=1).any()


def hats(sphere, monkeypatch, kind, thickness=0.0, **changes):
    monkeypatch.setattr(hair, "HATS", {kind: replace(HATS[kind], **changes)})
    return [random_hat(sphere, thickness, np.random.default_rng(seed)) for seed in SEEDS]


def test_a_hat_is_over_the_hair_and_as_high_as_its_crown(sphere, monkeypatch):
    height = sphere.head.height
    tops = []
    for thickness, crown in ((0.0, 0.0), (0.05 * height, 0.0), (0.0, 0.3)):
        pieces = hats(sphere, monkeypatch, "beanie", thickness, crown=(crown, crown))
        tops.append(np.mean([shell.vertices[:, 1].max() for shell, *_ in pieces]))
        for shell, *_ in pieces:
            assert np.isnan(shell.strands).all(), "a hat has no strands"
    assert tops[1] - tops[0] == pytest.approx(0.05 * height, rel=0.2)
    assert tops[2] - tops[0] == pytest.approx(0.3 * height, rel=0.2)


def test_a_hood_falls_straight_behind_the_neck(sphere, monkeypatch):
    for kind, low, high in (("hood", 0.08, 0.5), ("beanie", -0.02, 0.06)):
        shapes = hats(sphere, monkeypatch, kind, crown=(0, 0), back=(140, 140), folds=False)
        for points in (shell.vertices for shell, *_ in shapes):
            longitudes, angles, _ = sphere.seen_from(points)
            behind = (np.abs(longitudes) > 2.2) & (angles > np.radians(112)) & (angles < np.radians(128))
            assert low < np.median(above_skin(sphere, points[behind])) / sphere.head.height < high


def test_a_top_hat_has_upright_walls_and_a_flat_top(sphere, monkeypatch):
    height = sphere.head.height
    for shell, *_ in hats(sphere, monkeypatch, "top hat", crown=(0.4, 0.4), brim=0):
        out = shell.vertices - sphere.middle
        top = out[out[:, 1] > out[:, 1].max() - 0.02 * height]
        wide = np.hypot(out[:, 0], out[:, 2])
        assert len(top) > 40 and np.hypot(top[:, 0], top[:, 2]).max() > 0.8 * wide.max()


def test_brims_lead_outwards_and_down_of_caps_ahead_alone(sphere, monkeypatch):
    for kind in ("cap", "hat"):
        for shell, brim in hats(sphere, monkeypatch, kind):
            assert brim.thin.all()
            inner, outer = np.split(brim.vertices, 2)
            reach = np.linalg.norm((outer - inner)[:, [0, 2]], axis=1) / sphere.head.height
            outward = inner - sphere.middle
            ahead = outward[:, 2] / np.hypot(outward[:, 0], outward[:, 2])
            assert 0.1 < reach[ahead > 0.95].min() and reach.max() < 0.45
            assert (reach[ahead < -0.5] > 0.1).all() if kind == "hat" else reach[ahead < -0.5].max() < 1e-6
            wide = reach > 0.05
            assert ((outer - inner)[wide] * outward[wide])[:, [0, 2]].sum(1).min() > 0
            assert (outer[wide, 1] < inner[wide, 1]).all()
            edges, counts = boundary_of(brim.faces)
            assert (counts == 1).sum() == len(brim.vertices) and counts.max() == 2
            lengths = np.linalg.norm(np.diff(brim.vertices[edges], axis=1)[:, 0], axis=1)
            assert lengths.max() < 0.5 * sphere.head.height
            assert shell.vertices[:, 1].max() > brim.vertices[:, 1].max()


def test_some_hats_have_a_band_around_their_edge_and_some_stripes_down(sphere):
    banded = striped = 0
    for seed in range(40):
        shell = random_hat(sphere, 0.0, np.random.default_rng(seed))[0]
        colours = shell.colours[1:].reshape(hair.ROWS, hair.COLUMNS, 3)
        other = (colours != shell.colours[0]).any(2)
        if other.all(1).any():
            banded += 1
            rows = np.flatnonzero(other.all(1))
            assert 3 <= len(rows) < 8 and rows[-1] == hair.ROWS - 1 and other.sum() == len(rows) * hair.COLUMNS
        elif other.any():
            striped += 1
            assert (other == other[0]).all() and other.mean() == pytest.approx(0.5, abs=0.1)
    assert 5 < banded < 25 and 1 < striped < 15


def test_only_hoods_and_turbans_have_folds(sphere, monkeypatch):
    for kind, shape in HATS.items():
        still, folded = (hats(sphere, monkeypatch, kind, folds=folds)[0][0].vertices for folds in (False, True))
        usual = hats(sphere, monkeypatch, kind)[0][0].vertices
        assert np.abs(still - folded).max() > 1e-3
        np.testing.assert_allclose(usual, folded if shape.folds else still)


def test_a_beard_stands_off_the_skin_where_it_grows_and_hangs(head_template):
    vertices = head_template.vertices
    normals = smooth_normals(vertices, head_template.faces)
    skin = make_piece(vertices, head_template.faces, Region.SKIN, np.full(3, 0.5))
    grown = np.zeros(len(vertices))
    jaw = head_template.annotation.regions["chin"]
    grown[jaw] = 1
    thickness = 0.01
    beard = random_beard(skin, normals, grown, BROWN, thickness)
    assert (beard.region == Region.BEARD).all() and (beard.colours == BROWN).all()
    roots = jaw[np.isin(jaw, head_template.faces[(grown[head_template.faces] > 0).all(1)])]
    assert len(beard.vertices) == len(roots)
    roots = np.sort(roots)
    off = beard.vertices - vertices[roots]
    assert (off * normals[roots]).sum(1).mean() == pytest.approx(thickness, rel=0.6)
    sideways = off - (off * normals[roots]).sum(1, keepdims=True) * normals[roots]
    assert sideways[:, 1].mean() < -0.2 * thickness
    assert np.abs(off).max() < 2 * thickness
    assert random_beard(skin, normals, 0 * grown, BROWN, thickness) is None
