#!/usr/bin/python3
"""Counts the test cases that GoogleTest and pytest reported in each build folder, and fails if one failed or did not run.

Usage: summarize_reports.py <build folder>...
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def count(report: pathlib.Path) -> tuple[int, int, int]:
    """The test cases of one JUnit-like report: run, failed, and skipped or disabled."""
    run = failed = idle = 0
    for case in ElementTree.parse(report).iter("testcase"):
        if case.get("status") == "notrun" or case.find("skipped") is not None:
            idle += 1
        else:
            run += 1
            failed += case.find("failure") is not None or case.find("error") is not None
    return run, failed, idle


def main(folders: list[str]) -> int:
    good = True
    for folder in map(pathlib.Path, folders):
        counts = [count(report) for report in sorted(folder.glob("reports/*.xml"))]
        run, failed, idle = (sum(column) for column in zip(*counts)) if counts else (0, 0, 0)
        print(f"{folder.name:>12}: {run} test cases, {failed} failed, {idle} skipped or disabled")
        good = good and run > 0 and failed == 0 and idle == 0
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
