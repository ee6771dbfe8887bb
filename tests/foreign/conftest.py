"""Starts a server for a test and ends it."""

import os
import subprocess

import pytest


@pytest.fixture
def server_address():
    """Address of a fresh server on a free port of the loopback interface."""
    server = subprocess.Popen(
        [os.environ["GENPHYS_SERVER"], "--listen", "127.0.0.1:0", "--exit-with-parent"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        line = server.stdout.readline()
        assert "listening on" in line, f"the server did not start: {line!r}"
        yield line.split()[-1]
    finally:
        server.terminate()
        server.wait(timeout=20)
