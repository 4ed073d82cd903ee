"""Meshes that several folders of tests share, and which tests run in one process."""

import signal

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from xdist.scheduler import LoadFileScheduling

# What a shell starts with `&` ignores SIGINT, and so would every command that a test stops by it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

TOGETHER = ("tests/data/", "tests/methods/detect/")
"""Folders whose files share what takes long to make."""


class FolderScheduling(LoadFileScheduling):
    """Tests of a file run in one process, and so do all of a folder in TOGETHER, which makes what they share once."""

    def _split_scope(self, nodeid):
        return next((folder for folder in TOGETHER if nodeid.startswith(folder)), super()._split_scope(nodeid))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    return FolderScheduling(config, log) if config.getoption("dist") == "loadfile" else None


@pytest.fixture(scope="session")
def ball():
    """A unit sphere of 300 vertices without any symmetry; faces counter-clockwise from outside."""
    count = 300
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(count)
    vertices = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)
    faces = ConvexHull(vertices).simplices
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    inwards = (np.cross(b - a, c - a) * a).sum(1) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return vertices, faces.astype(np.int32)


@pytest.fixture(scope="session")
def head():
    """The open head, from the user's cache."""
    from caricli.template.head import load_head

    return load_head()


@pytest.fixture(scope="session")
def head_template(head):
    """The open head's neutral shape as a Template."""
    return head.template()


@pytest.fixture(scope="session")
def people(head):
    """(40, 4200, 3) random neutral heads."""
    from dataclasses import asdict

    from caricli.data.identities import random_identity

    generator = np.random.default_rng(7)
    return np.array([head.evaluate(**asdict(random_identity(head, generator))) for _ in range(40)])
