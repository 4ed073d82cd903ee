from dataclasses import replace

import numpy as np
import pytest

from caricli.data.albedo import random_albedos, vertex_painter
from caricli.data.appearance import STYLES, random_appearance
from caricli.data.texture_painter import TexturePainter
from caricli.errors import InputError
from caricli.structures.mesh import triangle_fans

SIZE = 192


@pytest.fixture(scope="module")
def painter(head_template):
    return vertex_painter(head_template)


@pytest.fixture(scope="module")
def texture(head_template):
    return TexturePainter(head_template, SIZE)


@pytest.fixture
def plain():
    """A appearance of fair skin with nothing on it but brown hair and brows."""
    appearance = random_appearance(np.random.default_rng(5), "flat")
    hair = np.array([0.05, 0.03, 0.02])
    nothing = {"spots": 0, "stubble": 0.0, "flush": (0.0, 0.0, 0.0), "lipstick": None, "shadow": 0.0}
    return replace(appearance, melanin=0.15, blood=0.1, hair=hair, scalp=1.0, brow=(0.06, 0.9), lips=0.7, **nothing)


def sampled(picture, uvs):
    """Colours of the texels that UVs lie in."""
    size = len(picture)
    column, row = (np.clip((a * size).astype(int), 0, size - 1) for a in (uvs[:, 0], 1 - uvs[:, 1]))
    return picture[row, column]


@pytest.mark.parametrize("style", [*STYLES, None])
def test_the_same_generator_gives_the_same_colours(painter, texture, style):
    appearances = [random_appearance(np.random.default_rng(seed), style) for seed in (1, 1, 2)]
    first, again, other = (painter.draw(appearance) for appearance in appearances)
    assert first.shape == (4200, 3) and np.array_equal(first, again) and not np.array_equal(first, other)
    pictures = [texture.draw(appearance) for appearance in appearances[:2]]
    assert pictures[0].shape == (SIZE, SIZE, 3) and pictures[0].dtype == np.uint8
    assert np.array_equal(*pictures)


def test_both_styles_are_drawn_unless_one_is_asked_for():
    appearances = [random_appearance(np.random.default_rng(k)) for k in range(40)]
    assert {appearance.flat for appearance in appearances} == {True, False}
    assert (
        random_appearance(np.random.default_rng(0), "flat").flat
        and not random_appearance(np.random.default_rng(0), "soft").flat
    )


def test_colours_lie_where_they_belong(head_template, painter, plain):
    colours, note = 255 * painter.draw(plain), head_template.annotation
    marks = note.landmarks
    cheek = colours[note.regions["cheek_left"]].mean(0)
    lips = colours[note.regions["lips"]].mean(0)
    for brow in (19, 24):
        assert colours[marks[brow]].mean() < 0.6 * cheek.mean()
    assert lips[0] / lips[1] > 1.15 * cheek[0] / cheek[1]
    assert colours[marks[36:48]].mean() < 0.8 * cheek.mean()
    assert np.abs(colours[marks[[30, 8, 33]]] - cheek).max() < 25
    assert colours[note.regions["scalp"]].mean(0) == pytest.approx(255 * np.array([0.25, 0.19, 0.15]), abs=35)
    # Paint is on the skin's outside as much as on the left and the right.
    assert np.abs(colours - colours[note.mirror])[marks].max() < 20


def test_pigments_darken_and_redden(painter, plain):
    cheek = painter.places[:, 2] > painter.marks[30, 2] - 0.25
    fair, dark, red = (
        painter.draw(replace(plain, scalp=0.0, **change))[cheek].mean(0)
        for change in ({}, {"melanin": 0.8}, {"blood": 0.5})
    )
    assert (dark < 0.75 * fair).all()
    assert red[0] / red[1] > 1.1 * fair[0] / fair[1]


@pytest.mark.parametrize(
    "change", [{"spots": 80}, {"stubble": 0.7}, {"flush": (0.5, 0.5, 0.5)}, {"lipstick": np.array([0.5, 0.05, 0.1])}]
)
def test_each_ornament_changes_the_face_and_leaves_the_back_of_the_head(head_template, painter, plain, change):
    difference = np.abs(painter.draw(replace(plain, **change)) - painter.draw(plain)).max(1)
    assert difference[head_template.region("face")].max() > 0.03
    assert difference[head_template.vertices[:, 2] < -0.01].max() < 1e-9


def test_seams_agree(head_template, texture, plain):
    corners = np.stack([head_template.faces, triangle_fans(head_template.uv_polygons)], -1).reshape(-1, 2)
    pairs = np.unique(corners, axis=0)
    _, at, counts = np.unique(pairs[:, 0], return_inverse=True, return_counts=True)
    # The seams of mouth and eye sockets lie inside, where colours change from one texel to the next.
    outside = ~head_template.mask("inner_mouth", "eye_socket_left", "eye_socket_right")
    seam = pairs[(counts[at] > 1) & outside[pairs[:, 0]]]
    assert len(seam) > 100
    for appearance in (plain, random_appearance(np.random.default_rng(8), "soft")):
        colours = sampled(texture.draw(appearance), head_template.uvs[seam[:, 1]]).astype(int)
        order = np.argsort(seam[:, 0], kind="stable")
        ids, colours = seam[order, 0], colours[order]
        across = np.abs(np.diff(colours, axis=0)).max(1)[np.diff(ids) == 0]
        assert np.median(across) <= 2 and across.max() < 20


def test_texture_and_vertices_tell_the_same(head_template, texture, painter):
    appearance = random_appearance(np.random.default_rng(3), "soft")
    corners = np.stack([head_template.faces, triangle_fans(head_template.uv_polygons)], -1).reshape(-1, 2)
    difference = (
        sampled(texture.draw(appearance), head_template.uvs[corners[:, 1]])
        - 255 * painter.draw(appearance)[corners[:, 0]]
    )
    assert np.median(np.abs(difference)) < 3


def test_the_padding_has_no_colour_of_its_own(texture, plain):
    picture = texture.draw(plain)
    inside = {tuple(c) for c in picture[texture.covered]}
    assert {tuple(c) for c in picture[~texture.covered]} <= inside


def test_an_annotation_of_landmarks_alone_is_enough(head_template):
    bare = replace(head_template.annotation, curves={}, regions={}, landmarks=head_template.annotation.landmarks[:68])
    colours = random_albedos(replace(head_template, annotation=bare), 0, 3)
    assert colours.shape == (3, 4200, 3) and len({c.tobytes() for c in colours}) == 3
    assert colours.std(axis=1).min() > 1


def test_albedos_need_uvs(head_template):
    with pytest.raises(InputError, match="UVs"):
        TexturePainter(replace(head_template, uvs=None, uv_polygons=None), SIZE)
