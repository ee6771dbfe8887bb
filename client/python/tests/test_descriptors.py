"""The wire contract is found, made, renewed and, when that cannot be, explained."""

import shutil
import subprocess
import sys

import pytest

from genphys import _descriptors

ORIGINAL_PROTO_ROOT = _descriptors.PROTO_ROOT
CLIENT = _descriptors.GENERATED.parents[2]


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout of its own, so that the real one stays as it is."""
    shutil.copytree(ORIGINAL_PROTO_ROOT, tmp_path / "proto")
    monkeypatch.setattr(_descriptors, "PROTO_ROOT", tmp_path / "proto")
    monkeypatch.setattr(_descriptors, "GENERATED", tmp_path / "_generated" / "genphys.binpb")
    return tmp_path


def test_a_fresh_checkout_makes_the_contract_once(checkout):
    first = _descriptors.load()
    made = _descriptors.GENERATED.stat().st_mtime_ns

    assert _descriptors.load() == first
    assert _descriptors.GENERATED.read_bytes() == first
    assert _descriptors.GENERATED.stat().st_mtime_ns == made


def test_a_changed_proto_is_made_again(checkout):
    before = _descriptors.load()
    with open(checkout / "proto" / "genphys" / "v1" / "types.proto", "a") as file:
        file.write("\nmessage Novelty {}\n")

    after = _descriptors.load()

    assert b"Novelty" in after
    assert b"Novelty" not in before


def test_a_checkout_that_cannot_be_written_works(checkout):
    _descriptors.GENERATED.parent.write_text("in the way")

    assert b"genphys.v1" in _descriptors.load()


def test_a_proto_that_does_not_compile_is_shown(checkout):
    (checkout / "proto" / "genphys" / "v1" / "types.proto").write_text("message {")

    with pytest.raises(_descriptors.DescriptorsMissing, match="types.proto"):
        _descriptors.load()


def test_without_a_compiler_it_says_what_to_do(checkout, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(_descriptors.importlib.util, "find_spec", lambda name: None)

    with pytest.raises(_descriptors.DescriptorsMissing, match="protobuf-compiler"):
        _descriptors.load()


def test_an_installed_package_reads_its_file_and_says_when_that_is_missing(checkout):
    data = _descriptors.load()
    shutil.rmtree(checkout / "proto")
    assert _descriptors.load() == data

    _descriptors.GENERATED.unlink()
    with pytest.raises(_descriptors.DescriptorsMissing, match="pip"):
        _descriptors.load()


def test_it_lives_beside_another_packages_copy_of_the_google_messages():
    program = """
from google.protobuf import descriptor_pb2, descriptor_pool
other = descriptor_pb2.FileDescriptorProto(name="google/rpc/status.proto", package="google.rpc", syntax="proto3")
other.message_type.add(name="Status").field.add(name="code", number=1, type=5, label=1)
descriptor_pool.Default().AddSerializedFile(other.SerializeToString())
import genphys
"""
    subprocess.run([sys.executable, "-c", program], check=True, cwd=CLIENT)
