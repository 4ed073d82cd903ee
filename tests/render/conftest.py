"""Meshes for the render tests, built in code."""

import numpy as np
import pytest

from caricli.structures import Mesh
from caricli.template.annotation import Annotation
from caricli.template.template import Template


@pytest.fixture(scope="session")
def bare():
    """An annotation that knows nothing."""
    return Annotation(np.zeros(68, int), (), {}, {}, None, {}, {})


@pytest.fixture(scope="session")
def lopsided_head(lopsided, bare):
    """The lopsided sphere as a Template without names."""
    return Template(*lopsided, annotation=bare)


@pytest.fixture(scope="session")
def lopsided_mesh(lopsided):
    return Mesh(*lopsided)


@pytest.fixture(scope="session")
def sphere():
    """A unit sphere of 512 triangles, mirror-symmetric in every axis; faces counter-clockwise from outside."""
    vertices = [np.eye(3)[k] * s for k in range(3) for s in (1.0, -1.0)]
    faces = []
    for x in (0, 1):
        for y in (2, 3):
            for z in (4, 5):
                odd = (x + y + z) % 2
                faces.append((y, x, z) if odd else (x, y, z))
    for _ in range(3):
        finer, middle = [], {}
        for face in faces:
            ids = []
            for a, b in ((0, 1), (1, 2), (2, 0)):
                key = tuple(sorted((face[a], face[b])))
                if key not in middle:
                    middle[key] = len(vertices)
                    point = vertices[key[0]] + vertices[key[1]]
                    vertices.append(point / np.linalg.norm(point))
                ids.append(middle[key])
            m0, m1, m2 = ids
            finer += [(face[0], m0, m2), (face[1], m1, m0), (face[2], m2, m1), (m0, m1, m2)]
        faces = finer
    vertices, faces = np.array(vertices), np.array(faces, np.int32)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((normals * corners.mean(1)).sum(1) > 0).all()
    return vertices, faces


@pytest.fixture(scope="session")
def lopsided(sphere):
    """The sphere with a nose in front (+z), a chin that hangs to -x, and no symmetry."""
    vertices, faces = sphere
    nose = np.exp(-8 * ((vertices - [0, 0, 1]) ** 2).sum(1))
    chin = np.exp(-4 * ((vertices - [-0.3, -0.9, 0.3]) ** 2).sum(1))
    return vertices + nose[:, None] * [0, 0, 0.5] + chin[:, None] * [-0.3, -0.4, 0], faces
