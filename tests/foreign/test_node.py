"""A foreign client in JavaScript: @grpc/grpc-js and reflection, none of our files."""

import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent


def test_node_drives_a_world_through_reflection(server_address):
    done = subprocess.run(["node", str(HERE / "crate_and_ball.js"), server_address], cwd=HERE,
                          capture_output=True, text=True, timeout=120)

    assert done.returncode == 0, done.stderr + done.stdout
    assert done.stdout.strip().endswith("ok")
