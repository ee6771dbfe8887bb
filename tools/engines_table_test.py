"""The page of engines tells what was proven, and its checker sees what was not."""

import os
import pathlib
import subprocess

import pytest

TOOLS = pathlib.Path(__file__).resolve().parent
ROWS = '<property name="rows" value="Shapes: box|Joints: ball|"/>'
TABLE = (f'<testcase name="AreTheRows" status="run" classname="Claims"><properties>{ROWS}<property name="features" value="shape_box|'
         'joint_ball|"/><property name="engines" value="ode|"/></properties></testcase>')


def case(name: str, proves: str, inside: str = "", refused: str = "") -> str:
    return (f'<testcase name="{name}/ode" value_param="&quot;ode&quot;" status="run" classname="Engines/Suite">{inside}<properties>'
            f'<property name="proves" value="{proves}"/><property name="refused" value="{refused}"/></properties></testcase>')


REFUSES = ('<testcase name="Refuses/ode" value_param="&quot;ode&quot;" status="run" classname="Engines/Caps"><properties>'
           '<property name="refuses" value="joint_ball "/></properties></testcase>')
GOOD = [TABLE, REFUSES, case("Stands", "Shapes: box|"), case("Swings", "Joints: ball|", refused="joint_ball ")]


@pytest.fixture(name="table")
def _table(tmp_path):
    def write(cases: list[str]) -> subprocess.CompletedProcess:
        (tmp_path / "conformance.0.xml").write_text(f"<testsuites><testsuite>{''.join(cases)}</testsuite></testsuites>")
        return subprocess.run([TOOLS / "engines_table", tmp_path], capture_output=True, text=True, check=False)
    return write


def test_what_was_proven_is_told_and_what_was_refused(table):
    result = table(GOOD)
    assert result.returncode == 0, result.stderr
    assert "| box | yes |" in result.stdout
    assert "| ball | refused: `joint_ball` |" in result.stdout


@pytest.mark.parametrize("cases, complaint", [
    ([TABLE, REFUSES], "no test proves \"Shapes: box\""),
    ([*GOOD, case("Falls", "")], "Falls/ode does not say what it proves"),
    ([*GOOD, case("Falls", "Shapes: box|", inside="<failure/>")], "a test of \"Shapes: box\" fails on ode"),
    ([*GOOD, case("Turns", "Joints: ball|")], "proven on ode, which refuses joint_ball"),
    ([TABLE, case("Stands", "Shapes: box|", refused="shape_box "), REFUSES], "no test proves \"Shapes: box\""),
])
def test_what_is_not_right_is_said(table, cases, complaint):
    result = table(cases)
    assert result.returncode == 1
    assert complaint in result.stderr


def test_the_checker_sees_a_stale_page_and_a_missing_run(tmp_path, table):
    written = table(GOOD).stdout
    (tmp_path / "docs").mkdir()
    page = tmp_path / "docs" / "engines.md"

    def check(reports: pathlib.Path) -> int:
        environment = {**os.environ, "GENPHYS_BUILD_DIR": str(tmp_path)}
        return subprocess.run([TOOLS / "check_engines_table", tmp_path, reports], env=environment, capture_output=True, check=False).returncode

    page.write_text(written)
    assert check(tmp_path) == 0
    page.write_text(written.replace("yes", "perhaps"))
    assert check(tmp_path) == 1
    assert check(tmp_path / "nowhere") == 1
