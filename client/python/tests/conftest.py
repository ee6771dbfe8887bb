"""A real server for the live tests: without one they fail, so that a green run has run them."""

import os

import pytest

import genphys
from genphys import _launcher

ENGINES = ["bullet", "ode"]
STEP_SIZE = 1 / 240
GRAVITY = 9.81


@pytest.fixture(scope="session")
def binary():
    """The path of genphysd."""
    path = os.environ.get(_launcher.ENVIRONMENT_VARIABLE)
    if not path:
        pytest.fail(f"${_launcher.ENVIRONMENT_VARIABLE} must name the genphysd that the live tests shall run against")
    return path


@pytest.fixture(scope="session")
def server(binary):
    """A private server for all tests."""
    with genphys.launch(binary=binary) as launched:
        yield launched


@pytest.fixture(params=ENGINES)
def world(server, request):
    """A world with a floor, on each engine in turn."""
    with server.create_world(engine=request.param, gravity=(0, 0, -GRAVITY), step_size=STEP_SIZE) as created:
        yield created


@pytest.fixture
def space(server):
    """A world with nothing in it, not even gravity."""
    with server.create_world(gravity=(0, 0, 0), ground_plane=False, step_size=STEP_SIZE) as created:
        yield created
