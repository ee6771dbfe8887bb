"""A private server is found, awaited and ended; if it cannot be, the error says what to do."""

import os
import pathlib
import subprocess
import sys
import time

import pytest

import genphys
from genphys import _launcher

SHORT_SECONDS = 0.3
PATIENCE_SECONDS = 10.0


@pytest.fixture(autouse=True)
def nowhere(monkeypatch, tmp_path):
    """A machine without any genphysd."""
    monkeypatch.delenv(_launcher.ENVIRONMENT_VARIABLE, raising=False)
    monkeypatch.setattr(_launcher, "_CHECKOUT_BINARY", tmp_path / "build" / "genphysd")
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")


def program(path, *lines):
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(["#!/bin/sh", *lines, ""]))
    path.chmod(0o755)
    return str(path)


def test_a_missing_server_is_explained():
    with pytest.raises(genphys.LaunchError, match="script/build release.*GENPHYS_SERVER"):
        genphys.launch()


def test_it_is_looked_for_in_the_documented_order(tmp_path, monkeypatch):
    in_build = program(tmp_path / "build" / "genphysd")
    assert _launcher.find_server(None) == in_build
    on_path = program(tmp_path / "genphysd")
    assert _launcher.find_server(None) == on_path
    in_environment = program(tmp_path / "from_environment")
    monkeypatch.setenv(_launcher.ENVIRONMENT_VARIABLE, in_environment)
    assert _launcher.find_server(None) == in_environment
    as_argument = program(tmp_path / "as_argument")
    assert _launcher.find_server(as_argument) == as_argument


def test_a_wrong_path_is_refused_and_not_replaced_by_another(tmp_path, monkeypatch):
    program(tmp_path / "genphysd")
    with pytest.raises(genphys.LaunchError, match="the argument `binary` says '/nowhere'"):
        genphys.launch(binary="/nowhere")
    monkeypatch.setenv(_launcher.ENVIRONMENT_VARIABLE, str(tmp_path))
    with pytest.raises(genphys.LaunchError, match=r"\$GENPHYS_SERVER says"):
        genphys.launch()


def test_a_server_that_ends_at_once_shows_its_last_words(tmp_path):
    binary = program(tmp_path / "genphysd", "echo 'no such option' >&2", "exit 3")

    with pytest.raises(genphys.LaunchError, match="exit code 3 before it served:\nno such option"):
        genphys.launch(binary=binary)


def test_a_server_that_never_serves_is_given_up_and_ended(tmp_path):
    binary = program(tmp_path / "genphysd", f"echo $$ > {tmp_path}/pid", "exec sleep 60")
    begin = time.monotonic()

    with pytest.raises(genphys.LaunchError, match="does not serve after 0.3 s"):
        genphys.launch(binary=binary, start_timeout=SHORT_SECONDS)

    assert time.monotonic() - begin < PATIENCE_SECONDS
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_options_of_a_server_are_a_list_and_its_engine_a_text(tmp_path):
    binary = program(tmp_path / "genphysd", 'echo "genphysd listening on $2"', "exec sleep 60")
    with pytest.raises(TypeError, match="arguments is '--workers 1', not a list"):
        genphys.launch(binary=binary, arguments="--workers 1")
    with pytest.raises(TypeError, match='engine is 3, not a text, as in "ode"'):
        genphys.launch(binary=binary, engine=3)
    genphys.launch(binary=binary, arguments=["--workers", 1]).close()


def test_what_cannot_be_run_is_said(tmp_path):
    binary = tmp_path / "genphysd"
    binary.write_text("")
    binary.chmod(0o755)

    with pytest.raises(genphys.LaunchError, match="Exec format error"):
        genphys.launch(binary=str(binary))


def test_close_ends_the_server_and_may_be_called_again(tmp_path):
    binary = program(
        tmp_path / "genphysd", f"echo $* > {tmp_path}/arguments", 'echo "genphysd listening on $2"', "exec sleep 60"
    )
    server = genphys.launch(binary=binary, engine="bullet", arguments=["--workers", "1"])
    pid = server._process.pid
    folder = server.address.removeprefix("unix:").removesuffix("/socket")
    assert os.path.isdir(folder)

    server.close()
    server.close()

    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert not os.path.exists(folder)
    assert (tmp_path / "arguments").read_text().strip() == (
        f"--listen unix:{folder}/socket --exit-with-parent --default-engine bullet --workers 1"
    )


FORKS = """
import os, sys
import genphys

server = genphys.launch(binary=sys.argv[1])
if os.fork() == 0:
    sys.exit()  # and with it all that ends at the exit of a program
os.wait()
os.kill(server._process.pid, 0)
print(os.path.isdir(os.path.dirname(server.address.removeprefix("unix:"))))
"""


def test_a_fork_that_ends_leaves_the_server_to_who_started_it(tmp_path):
    binary = program(tmp_path / "genphysd", 'echo "genphysd listening on $2"', "exec sleep 60")
    package = str(pathlib.Path(genphys.__file__).parents[1])

    surroundings = {**os.environ, "PYTHONPATH": package}
    told = subprocess.run(
        [sys.executable, "-c", FORKS, binary], env=surroundings, stdout=subprocess.PIPE, check=True
    )

    assert told.stdout.split() == [b"True"]
