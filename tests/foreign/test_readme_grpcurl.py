"""A foreign client with none of our files: the README's own grpcurl lines, run as they stand."""

import json
import os
import re
import shlex
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ADDRESS_IN_README = "127.0.0.1:50051"


def readme_lines():
    """The grpcurl command lines of the README, in order."""
    return re.findall(r"^grpcurl .*$", (ROOT / "README.md").read_text(), re.MULTILINE)


def run(line, address, may_time_out=False):
    """Runs one line against `address` and returns the JSON messages that it printed."""
    words = shlex.split(line.replace(ADDRESS_IN_README, address))
    words[0] = os.environ["GENPHYS_GRPCURL"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 or (may_time_out and "DeadlineExceeded" in done.stderr), done.stderr
    decoder, text, messages = json.JSONDecoder(), done.stdout.strip(), []
    while text:
        message, end = decoder.raw_decode(text)
        messages.append(message)
        text = text[end:].lstrip()
    return messages


def test_the_lines_of_the_readme_do_what_it_says(server_address):
    lines = readme_lines()
    assert len(lines) == 7

    [empty] = run(lines[0], server_address)
    assert empty["world"]["name"].startswith("worlds/")
    [lab] = run(lines[1], server_address)
    assert lab["world"]["name"] == "worlds/lab"
    [crate] = run(lines[2], server_address)
    assert crate["entity"]["id"] == "2"
    [ball] = run(lines[3], server_address)
    assert ball["entity"]["id"] == "3"
    run(lines[4], server_address)
    [step] = run(lines[5], server_address)
    assert step["stamp"]["step"] == "120"
    began = [event for event in step["events"]["events"] if "contact_began" in event]
    assert {(e["contact_began"]["entity_a"], e["contact_began"]["entity_b"]) for e in began} >= {("1", "2"), ("1", "3")}
    assert len(step["frame"]["positions"]) > 0

    watched = [event for message in run(lines[6], server_address, may_time_out=True)
               for event in message.get("batch", {}).get("events", [])]
    assert [int(event["sequence"]) for event in watched] == list(range(1, len(watched) + 1))
    assert [event for event in watched if "contact_began" in event] == began


def test_a_mistyped_line_is_told_which_field_is_wrong(server_address):
    line = readme_lines()[2].replace('"box": {}', '"box": {"half_extents": {"x": 0, "y": 1, "z": 1}}')
    run(readme_lines()[1].replace("lab", "typo"), server_address)
    words = shlex.split(line.replace(ADDRESS_IN_README, server_address).replace("worlds/lab", "worlds/typo"))
    words[0] = os.environ["GENPHYS_GRPCURL"]

    done = subprocess.run(words, capture_output=True, text=True, timeout=60)

    assert done.returncode != 0
    assert "InvalidArgument" in done.stderr
    assert "entity.rigid_body.geometries[0].shape.box.half_extents.x" in done.stderr
