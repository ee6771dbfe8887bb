"""Tests that the client whose time is taken still speaks with the server."""

import subprocess
import sys
from pathlib import Path

import genphys
import pytest

_CLIENT = Path(__file__).with_name("python_client.py")


@pytest.mark.parametrize("what", ["cycle", "forces", "numpy", "frames"])
def test_each_question_is_answered_with_as_many_numbers_as_were_asked_for(what: str) -> None:
    count = 3
    with genphys.launch() as server, server.create_world(name="flyers", ground_plane=False) as world:
        for i in range(10):
            world.add_sphere(radius=0.1, mass=1, position=(i, 0, 1))
        world.step()
        answers = subprocess.run(
            [sys.executable, str(_CLIENT), server.address],
            input=f"{what} flyers {count}\n",
            capture_output=True,
            check=True,
            text=True,
            timeout=60,
        ).stdout.splitlines()
    assert len(answers) == 2  # versions first
    numbers = [float(number) for number in answers[1].split()]
    assert len(numbers) == count
    assert min(numbers) > 0
