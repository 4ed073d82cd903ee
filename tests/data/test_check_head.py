from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from caricli.data.check_head import check_head
from caricli.errors import InputError
from caricli.structures import Mesh
from caricli.structures.landmarks import MIRRORED
from caricli.template.annotation import parse_annotation
from caricli.template.template import Template

EXPECTED = r"scans, by the landmarks of a\.json: expected a head that looks to .* and its left side at \+x"
TURNED = {
    "lying": ([[1, 0, 0], [0, 0, -1], [0, 1, 0]], "found one turned by 90 degrees"),
    "aside": ([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], "found one turned by 90 degrees"),
    "mirrored": (np.diag([-1, 1, 1]), "found its mirror image"),
    "mirrored and lying": ([[1, 0, 0], [0, 0, 1], [0, 1, 0]], "found its mirror image"),
}


def check(template):
    check_head(template, Path("scans"), Path("a.json"))


def without_mirror(template, order=None):
    """The template with nothing but landmarks, in another order where one is given."""
    landmarks = template.annotation.landmarks[:68]
    value = {"ibug68": landmarks[list(range(68)) if order is None else order].tolist()}
    return replace(template, annotation=parse_annotation(value, len(template.vertices), "a.json"))


def mask_of(template):
    """Faces of the front of a head, open at its rim."""
    return template.faces[template.mask("face")[template.faces].all(1)]


def test_heads_as_they_have_to_stand_are_taken(head_template, head):
    check(head_template)
    check(head.open_mouth_template())
    check(head_template.with_vertices(2 * head_template.vertices + [0, 1, 0]))
    bare = without_mirror(head_template)
    check(bare)
    check(Template(bare.vertices, mask_of(head_template), annotation=bare.annotation))


@pytest.mark.parametrize("axes", TURNED)
def test_heads_that_lie_look_aside_or_are_mirrored_are_refused(head_template, axes):
    turn, words = TURNED[axes]
    for template in (head_template, without_mirror(head_template)):
        with pytest.raises(InputError, match=f"^{EXPECTED}, {words}$"):
            check(template.with_vertices(template.vertices @ np.transpose(turn)))


def test_landmarks_whose_sides_are_exchanged_are_refused(head_template):
    with pytest.raises(InputError, match=f"^{EXPECTED}, found its mirror image$"):
        check(without_mirror(head_template, list(MIRRORED[:68])))


def test_heads_and_masks_inside_out_are_refused(head_template):
    bare = without_mirror(head_template)
    for faces in (head_template.faces, mask_of(head_template)):
        inwards = Mesh(bare.vertices, faces[:, ::-1])
        with pytest.raises(InputError, match="^scans: expected faces that are counter-clockwise from outside, found"):
            check(Template(inwards.vertices, inwards.polygons, annotation=bare.annotation))
