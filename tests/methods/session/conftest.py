"""What all sessions are played with."""

import pytest


@pytest.fixture(scope="session")
def tools():
    from caricli.store.session_tools import SessionTools

    return SessionTools()


@pytest.fixture(scope="session")
def start(tools):
    from caricli.store.session_tools import load_start

    return load_start(None, tools)
