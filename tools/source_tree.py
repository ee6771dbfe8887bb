"""The files of this tree, as the checkers of this folder see it."""

import os
import pathlib
import sys

SOURCE_SUFFIXES = {".h", ".cc", ".proto", ".py", ".sh", ".ts", ".js"}
# Built or downloaded, never written by hand.
_SKIPPED = {"build", "node_modules", "__pycache__", "_generated"}


def root_from_arguments() -> pathlib.Path:
    """The tree to check: the only argument, or the one that this file is in."""
    return pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)


def source_files(root: pathlib.Path, suffixes: set[str]) -> list[pathlib.Path]:
    """Paths relative to the root of every source file with such a suffix, sorted."""
    found = []
    for folder, folders, files in os.walk(root):
        folders[:] = [f for f in folders if not f.startswith(".") and f not in _SKIPPED]
        found += [pathlib.Path(folder, f).relative_to(root) for f in files if pathlib.Path(f).suffix in suffixes]
    return sorted(found)


def report(problems: list[str], rule: str) -> int:
    """Prints what is wrong, and the rule that says so; the exit status of the checker."""
    for problem in problems:
        print(problem)
    if problems:
        print(f"\n{len(problems)} problem(s). The rule: {rule}")
    return 1 if problems else 0
