"""Finds the wire contract as a serialised FileDescriptorSet, making it from proto/ in a checkout.

The package carries descriptors instead of generated classes: generated code is bound to the protobuf version that
made it, a descriptor set works with every one. This module uses the standard library alone, because the build of the
wheel runs it before the dependencies are there.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

_PACKAGE = pathlib.Path(__file__).resolve().parent
GENERATED = _PACKAGE / "_generated" / "genphys.binpb"
PROTO_ROOT = _PACKAGE.parents[2] / "proto"

_PROTOC_TIMEOUT_SECONDS = 60.0


class DescriptorsMissing(ImportError):
    """The wire contract is not there and cannot be made; the message says what to do."""


def load() -> bytes:
    """Returns the serialised FileDescriptorSet of the contract.

    Raises:
        DescriptorsMissing: there is neither a made one nor a way to make it.
    """
    sources = proto_files(PROTO_ROOT)
    if not sources:
        if GENERATED.is_file():
            return GENERATED.read_bytes()
        raise DescriptorsMissing(
            f"{GENERATED} is missing, so this copy of genphys is incomplete. "
            "Install it again with pip, or import it from client/python of a complete checkout."
        )
    digest = _digest(sources)
    stamp = GENERATED.with_suffix(".sha256")
    if GENERATED.is_file() and stamp.is_file() and stamp.read_text() == digest:
        return GENERATED.read_bytes()
    data = compile_protos(PROTO_ROOT, sources)
    try:
        GENERATED.parent.mkdir(exist_ok=True)
        _replace(GENERATED, data)
        _replace(stamp, digest.encode())
    except OSError:
        pass  # A read-only checkout: it is made again at the next import.
    return data


def proto_files(root: pathlib.Path) -> list[pathlib.Path]:
    """Returns the files of the contract below `root`, in order of name; none if it is no proto folder."""
    return sorted([*root.glob("genphys/v1/*.proto"), *root.glob("google/rpc/*.proto")])


def compile_protos(root: pathlib.Path, sources: list[pathlib.Path]) -> bytes:
    """Returns the descriptor set of `sources` and all they import, made by protoc or by grpcio-tools.

    Raises:
        DescriptorsMissing: no compiler is installed, or it refused the files.
    """
    with tempfile.TemporaryDirectory(prefix="genphys-") as folder:
        output = pathlib.Path(folder) / "genphys.binpb"
        arguments = [f"-I{root}", "--include_imports", f"--descriptor_set_out={output}", *map(str, sources)]
        result = subprocess.run(
            [*_compiler(), *arguments], capture_output=True, text=True, timeout=_PROTOC_TIMEOUT_SECONDS, check=False
        )
        if result.returncode != 0:
            raise DescriptorsMissing(f"protoc refused the files of {root}:\n{result.stderr.strip()}")
        return output.read_bytes()


def _compiler() -> list[str]:
    protoc = shutil.which("protoc")
    if protoc:
        return [protoc]
    if importlib.util.find_spec("grpc_tools"):
        # grpc_tools adds its own well-known protos only through its wrapper, which `-m` runs.
        return [sys.executable, "-m", "grpc_tools.protoc"]
    raise DescriptorsMissing(
        "genphys is imported from a checkout and needs a protobuf compiler once, to read proto/. "
        "Run script/bootstrap, or `apt-get install protobuf-compiler`, or `pip install grpcio-tools`."
    )


def _digest(sources: list[pathlib.Path]) -> str:
    digest = hashlib.sha256()
    for source in sources:
        digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()


def _replace(path: pathlib.Path, data: bytes) -> None:
    # Several processes may import a fresh checkout at once: each writes its own file, the last rename wins whole.
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
    os.chmod(temporary, 0o644)
    os.replace(temporary, path)
