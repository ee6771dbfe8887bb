"""Puts the wire contract into the package before it is built; the rest is in pyproject.toml."""

import importlib.util
import pathlib

from setuptools import setup

# By its path: the package itself needs numpy and gRPC, which a build does not have.
path = pathlib.Path(__file__).parent / "genphys" / "_descriptors.py"
spec = importlib.util.spec_from_file_location("_descriptors", path)
descriptors = importlib.util.module_from_spec(spec)
spec.loader.exec_module(descriptors)
descriptors.load()

setup()
