import numpy as np
import pytest
import torch

from caricli.geometry.alignment.head_rotation import head_rotation
from caricli.geometry.triangle_normals import triangle_normals
from caricli.methods.morphable.renderer import DARKEST, LAMBERT, MorphableRenderer, Posed
from caricli.methods.reconstruct.landmark_vertices import landmark_vertices
from caricli.methods.texture.estimate_light import GAMMA, harmonics
from caricli.render.visibility.rasterise import rasterise
from caricli.store.models import load_morphable

SIDE = 96


@pytest.fixture(scope="module")
def renderer():
    return MorphableRenderer(load_morphable(), torch.float64)


@pytest.fixture(scope="module")
def scene(renderer):
    """Coefficients (2, D) of two people who look aside in light from above."""
    generator = np.random.default_rng(3)
    x = np.zeros((2, renderer.layout.size))
    x[:, : renderer.layout.face] = 0.7 * generator.normal(size=(2, renderer.layout.face))
    parts = renderer.layout.parts(x)
    parts["light"][:] = [2.4, 0.2, -0.8, -1.2, 0.1, 0.2, 0.1, -0.1, 0.2]
    parts["pose"][:] = [[0.1, 0.4, -0.15, 46, 50, 300], [-0.1, -0.3, 0.2, 49, 45, 330]]
    return torch.tensor(x)


def slow_colours(renderer, row):
    """What ``pose`` says of one face, from the numpy parts of the package: placed vertices and their colours."""
    model = renderer.model
    parts = renderer.layout.parts(row.numpy())
    vertices = model.decode(np.concatenate([parts["identity"], parts["expression"]]))
    turned = (vertices - vertices.mean(0)) @ head_rotation(parts["pose"][:3]).T
    placed = parts["pose"][5] * turned + [*parts["pose"][3:5], 0]
    normals = np.zeros_like(turned)
    for corner in model.template.faces.T:
        np.add.at(normals, corner, triangle_normals(turned, model.template.faces))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    light = harmonics(normals) @ (LAMBERT * parts["light"])
    light = (light + np.hypot(light, DARKEST)) / 2
    return placed, model.albedo.combine(parts["albedo"]) * light[:, None] ** (1 / GAMMA)


def test_faces_are_placed_and_lit_as_the_numpy_parts_of_the_package_do(renderer, scene):
    posed = renderer.pose(scene)
    for number, row in enumerate(scene):
        placed, colours = slow_colours(renderer, row)
        np.testing.assert_allclose(posed.placed[number].numpy(), placed, atol=1e-8)
        np.testing.assert_allclose(posed.colours[number].numpy(), colours, atol=1e-6)


def test_pixels_have_the_colours_of_their_place_on_the_surface(renderer, scene):
    posed = renderer.pose(scene)
    sight = renderer.look(posed, SIDE, SIDE + 8)
    painted = renderer.paint(posed, sight).numpy()
    for number in range(2):
        raster = rasterise(posed.placed[number].numpy(), renderer.model.template.faces, SIDE + 8, SIDE)
        own = (sight.picture == number).numpy()
        row, column = sight.row[own].numpy(), sight.column[own].numpy()
        assert len(row) > 2000 and (raster.face[row, column] == sight.face[own].numpy()).all()
        corners = renderer.model.template.faces[raster.face[row, column]]
        expected = (raster.barycentric[row, column][..., None] * posed.colours[number].numpy()[corners]).sum(1)
        np.testing.assert_allclose(painted[own], expected, atol=2e-3)


def test_what_is_seen_from_inside_is_no_sight(renderer, scene):
    away = scene.clone()
    renderer.layout.parts(away)["pose"][:, 1] += np.pi
    front, back = (renderer.look(renderer.pose(x), SIDE, SIDE) for x in (scene, away))
    nose = torch.as_tensor(renderer.model.template.mask("nose")[renderer.model.template.faces].all(1))
    assert nose[front.face].any() and not nose[back.face].any()


def test_landmarks_stand_where_fits_put_them(renderer, scene):
    posed = renderer.pose(scene)
    anchors = renderer.anchors(posed, 68)
    projected = renderer.landmarks(posed, anchors)
    for number in range(2):
        vertices, turn = posed.vertices[number].numpy(), posed.rotation[number].numpy()
        ids = landmark_vertices(vertices, turn, renderer.model.template, 68)
        np.testing.assert_array_equal(anchors[number].numpy(), ids)
        np.testing.assert_allclose(projected[number].numpy(), posed.placed[number].numpy()[ids, :2])


def test_derivatives_are_those_of_finite_differences(renderer, scene):
    sight = renderer.look(renderer.pose(scene), SIDE, SIDE)

    def painted(x):
        return renderer.paint(renderer.pose(x), sight)

    for name, step in (("identity", 1e-4), ("expression", 1e-4), ("albedo", 1e-4), ("light", 1e-5), ("pose", 1e-6)):
        way = torch.zeros_like(scene)
        part = renderer.layout.parts(way)[name]
        part[:] = torch.as_tensor(np.random.default_rng(0).normal(size=part.shape))
        _, exact = torch.func.jvp(painted, (scene,), (way,))
        rough = (painted(scene + step * way) - painted(scene - step * way)) / (2 * step)
        assert (exact - rough).abs().max() < 1e-4 * exact.abs().max()


def test_a_picture_that_is_drawn_anew_changes_as_the_derivatives_say(renderer, scene):
    """Where a pixel goes on to the next triangle, too: only where something else comes into sight there is a jump."""
    way = torch.zeros_like(scene)
    renderer.layout.parts(way)["identity"][:, :20] = 1.0
    renderer.layout.parts(way)["pose"][:, :2] = 0.05
    step = 0.02

    def drawn(x):
        posed = renderer.pose(x)
        sight = renderer.look(posed, SIDE, SIDE)
        picture = torch.full((2, SIDE, SIDE, 3), torch.nan, dtype=torch.float64)
        picture[sight.picture, sight.row, sight.column] = renderer.paint(posed, sight)
        return picture

    sight = renderer.look(renderer.pose(scene), SIDE, SIDE)
    _, exact = torch.func.jvp(lambda x: renderer.paint(renderer.pose(x), sight), (scene,), (way,))
    rough = sight.of((drawn(scene + step * way) - drawn(scene - step * way)) / (2 * step))
    both = rough.isfinite().all(1)
    errors = (exact - rough)[both].abs().max(1).values
    assert both.double().mean() > 0.95 and errors.median() < 0.1 * exact[both].abs().max(1).values.median()


def test_single_precision_and_batches_change_nothing_that_is_seen(renderer, scene):
    single = MorphableRenderer(renderer.model).pose(scene.float())
    alone = renderer.pose(scene[1:])
    assert isinstance(alone, Posed)
    np.testing.assert_allclose(alone.placed[0].numpy(), renderer.pose(scene).placed[1].numpy(), atol=1e-9)
    np.testing.assert_allclose(single.placed.numpy(), renderer.pose(scene).placed.numpy(), atol=1e-3)
