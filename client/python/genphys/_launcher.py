"""Finds genphysd, starts it for this program alone, and ends it."""

from __future__ import annotations

import os
import pathlib
import select
import shutil
import signal
import subprocess
import tempfile
import time
import weakref

from ._connection import Connection
from .errors import LaunchError

ENVIRONMENT_VARIABLE = "GENPHYS_SERVER"

_BINARY = "genphysd"
_CHECKOUT_BINARY = pathlib.Path(__file__).resolve().parents[3] / "build" / "release" / "bin" / _BINARY
_READY = b"genphysd listening on "
# genphysd promises to end within 5 s of a signal.
_GRACE_SECONDS = 7.0
_LOG_TAIL_BYTES = 2000
_READ_BYTES = 4096


def find_server(binary: str | os.PathLike[str] | None) -> str:
    """Returns the path of genphysd: the one given, $GENPHYS_SERVER, on PATH, or in build/release/bin.

    Raises:
        LaunchError: it is not where it was said to be, or nowhere.
    """
    said = [("the argument `binary`", binary), (f"${ENVIRONMENT_VARIABLE}", os.environ.get(ENVIRONMENT_VARIABLE))]
    for source, path in said:
        if path:
            if not os.access(path, os.X_OK) or os.path.isdir(path):
                raise LaunchError(f"{source} says {os.fspath(path)!r}, which is no program that can be run")
            return os.path.abspath(path)
    on_path = shutil.which(_BINARY)
    if on_path:
        return on_path
    if os.access(_CHECKOUT_BINARY, os.X_OK):
        return str(_CHECKOUT_BINARY)
    raise LaunchError(
        f"{_BINARY} was not found on PATH nor at {_CHECKOUT_BINARY}. Build it in a checkout of genphys with "
        f"`script/build release`, and if this package is not used from there, set {ENVIRONMENT_VARIABLE} to its path, "
        "which is build/release/bin/genphysd in the checkout, or pass launch(binary=...)."
    )


class ServerProcess:
    """One genphysd that lives as long as this object, and no longer than this program."""

    def __init__(self, binary: str, arguments: list[str], start_timeout: float) -> None:
        self._folder = tempfile.mkdtemp(prefix="genphys-")
        # A unix socket needs no free port, is closed to other users, and is faster than TCP.
        listen = f"unix:{self._folder}/socket"
        log = os.path.join(self._folder, "log")
        try:
            with open(log, "wb") as stderr:
                self._process = subprocess.Popen(
                    [binary, "--listen", listen, "--exit-with-parent", *arguments],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=stderr,
                    # Ctrl-C in a terminal is for this program, which may want to go on using the server.
                    start_new_session=True,
                )
        except OSError as error:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise LaunchError(f"{binary} cannot be run: {error.strerror}") from error
        # Also at the exit of the interpreter. If that is killed, the server sees its stdin close.
        self._finalizer = weakref.finalize(self, _end, self._process, self._folder, os.getpid())
        try:
            self.address = self._wait_until_ready(binary, log, start_timeout)
        except BaseException:
            self.end()
            raise

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def connect(self, timeout: float) -> Connection:
        """Returns a connection that keeps this server alive."""
        return Connection(self.address, timeout, keep_alive=self)

    def end(self) -> None:
        """Ends the server gracefully, or by force after some seconds. May be called again."""
        self._finalizer()

    def _wait_until_ready(self, binary: str, log: str, start_timeout: float) -> str:
        assert self._process.stdout is not None
        deadline = time.monotonic() + start_timeout
        output = self._process.stdout.fileno()
        received = b""
        while True:
            readable, _, _ = select.select([output], [], [], max(0.0, deadline - time.monotonic()))
            if not readable:
                raise LaunchError(f"{binary} does not serve after {start_timeout:g} s{_tail(log)}")
            chunk = os.read(output, _READ_BYTES)
            if not chunk:
                code = self._process.wait()
                raise LaunchError(f"{binary} ended with exit code {code} before it served{_tail(log)}")
            received += chunk
            for line in received.split(b"\n")[:-1]:
                if line.startswith(_READY):
                    return line[len(_READY) :].strip().decode()


def _tail(log: str) -> str:
    with open(log, "rb") as file:
        text = file.read()[-_LOG_TAIL_BYTES:].decode(errors="replace").strip()
    return f":\n{text}" if text else ""


def _end(process: subprocess.Popen[bytes], folder: str, owner: int) -> None:
    if os.getpid() != owner:
        return  # A fork of the program that started it ends: that one still uses it.
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(_GRACE_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    shutil.rmtree(folder, ignore_errors=True)
