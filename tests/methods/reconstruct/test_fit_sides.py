from dataclasses import replace

import cv2
import numpy as np
import pytest
import trimesh

from caricli.geometry.repair.flipped_triangles import flipped_triangles
from caricli.methods.reconstruct.fit_sides import fit_sides
from caricli.render.visibility.covered_pixels import covered_pixels
from caricli.structures import Camera, Face, Mesh
from caricli.structures.detection import ParsedPicture
from caricli.structures.parsing import Region
from caricli.template.template import Template

SIZE = 400


def seen_from(template, yaw=0.0):
    """A Face of a head in the middle of a picture."""
    turn = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    rotation = np.diag([1.0, -1.0, -1.0]) @ turn
    scale = 300 / template.height
    middle = (template.vertices.min(0) + template.vertices.max(0)) / 2
    return Face(template, Camera(scale, rotation, SIZE / 2 - scale * (rotation @ middle)[:2]))


def narrowed(template, by=0.7):
    """A head whose neck is as narrow up to the jaw's angle, what landmarks show aside."""
    return template.neck.widen(template.vertices, by, np.zeros(3))


def labelled(face, vertices, template):
    """The ParsedPicture of another head (V, 3) of a face's camera."""
    regions = np.zeros((SIZE, SIZE), np.uint8)
    regions[covered_pixels(face.camera.place(vertices), template.faces, SIZE, SIZE)] = Region.SKIN
    return ParsedPicture(np.zeros((SIZE, SIZE, 3), np.uint8), regions)


def before_background(face, picture):
    """How many pixels of the background a face stands before."""
    return (
        covered_pixels(face.camera.place(face.vertices), face.faces, SIZE, SIZE)
        & (picture.regions == Region.BACKGROUND)
    ).sum()


@pytest.mark.parametrize("yaw", [0.0, 0.4])
@pytest.mark.parametrize("zoom", [1, 3])
def test_sides_come_in_to_where_the_head_ends(head_template, yaw, zoom):
    face = seen_from(head_template, yaw)
    picture = labelled(face, narrowed(head_template), head_template)
    marks = head_template.annotation.landmarks
    before = before_background(face, picture)
    large = ParsedPicture(
        picture.pixels, cv2.resize(picture.regions, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_NEAREST)
    )
    fitted = fit_sides(replace(face, camera=face.camera.zoomed(zoom)), head_template, large, marks)
    assert before_background(replace(fitted, camera=face.camera), picture) < 0.25 * before
    moves = np.linalg.norm(fitted.vertices - face.vertices, axis=1) / head_template.height
    assert moves.max() > 0.02 and moves[marks].max() < 0.003
    assert moves[head_template.mask("ear_left", "ear_right")].max() < 0.003
    # At its depth: nothing goes to or from the camera.
    np.testing.assert_allclose((fitted.vertices - face.vertices) @ face.camera.rotation[2], 0, atol=1e-12)
    assert flipped_triangles(fitted.vertices, head_template.gradients).mean() < 2e-3


def test_what_is_as_usual_or_hidden_stays(head_template):
    face = seen_from(head_template)
    thin = narrowed(head_template)
    marks = head_template.annotation.landmarks
    same = labelled(face, head_template.vertices, head_template)
    assert fit_sides(face, head_template, same, marks) is face
    picture = labelled(face, thin, head_template)
    for hiding in (Region.CLOTH, Region.HAIR, Region.OTHER):
        covered = np.where(picture.regions == Region.BACKGROUND, np.uint8(hiding), picture.regions)
        assert fit_sides(face, head_template, ParsedPicture(picture.pixels, covered), marks) is face
    assert fit_sides(face, head_template, ParsedPicture(picture.pixels), marks) is face


def test_a_slight_difference_is_none(head_template):
    face = seen_from(head_template)
    picture = labelled(face, narrowed(head_template, 0.97), head_template)
    assert fit_sides(face, head_template, picture, head_template.annotation.landmarks) is face


def test_a_skull_stays_for_its_hair_to_say_where_it_is(head_template):
    face = seen_from(head_template)
    lower = np.array(head_template.vertices, float)
    top = lower[:, 1].max()
    lower[:, 1] -= 0.04 * head_template.height * np.clip((lower[:, 1] - top + 0.05) / 0.05, 0, 1)
    picture = labelled(face, lower, head_template)
    assert before_background(face, picture) > 500
    assert fit_sides(face, head_template, picture, head_template.annotation.landmarks) is face


def test_parts_that_nothing_holds_and_heads_without_ears_are_no_hindrance(head_template):
    """A ball beside the head's vertices, as eyes of own meshes are, and an annotation of landmarks alone."""
    head = head_template
    ball = trimesh.creation.icosphere(1, 0.005)
    mesh = Mesh(
        np.concatenate([head.vertices, ball.vertices + head.vertices.mean(0)]),
        np.concatenate([head.faces, ball.faces + len(head.vertices)]),
    )
    regions = {name: ids for name, ids in head.annotation.regions.items() if not name.startswith("ear")}
    bare = replace(head.annotation, curves={}, regions=regions, mirror=None)
    template = Template(mesh.vertices, mesh.polygons, annotation=bare)
    face = seen_from(template)
    narrow = np.array(template.vertices)
    narrow[: len(head.vertices)] = narrowed(head)
    picture = labelled(face, narrow, template)
    fitted = fit_sides(face, template, picture, head.annotation.landmarks)
    assert before_background(fitted, picture) < 0.4 * before_background(face, picture)
    assert np.isfinite(fitted.vertices).all()


def test_what_lies_outside_of_the_picture_is_not_told(head_template):
    face = seen_from(head_template)
    picture = labelled(face, narrowed(head_template), head_template)
    away = replace(face, camera=replace(face.camera, translation=face.camera.translation + 2 * SIZE))
    assert fit_sides(away, head_template, picture, head_template.annotation.landmarks) is away
