"""The page of limits follows the contract, and its checker sees when it does not."""

import pathlib
import shutil
import subprocess

import pytest

TOOLS = pathlib.Path(__file__).resolve().parent
RADIUS = "| `radius` | double | 1e-5 to 1e5 | Metres. Unset: 0.5. |"


@pytest.fixture(name="tree")
def _tree(tmp_path):
    shutil.copytree(TOOLS.parent / "proto", tmp_path / "proto")
    (tmp_path / "core/include/genphys").mkdir(parents=True)
    shutil.copy(TOOLS.parent / "core/include/genphys/limits.h", tmp_path / "core/include/genphys")
    (tmp_path / "docs").mkdir()
    subprocess.run([TOOLS / "limits_table", "--write", tmp_path], check=True)
    return tmp_path


def edit(path: pathlib.Path, old: str, new: str):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def check(tree: pathlib.Path) -> tuple[int, str]:
    result = subprocess.run([TOOLS / "check_limits_table", tree], capture_output=True, text=True, check=False)
    assert result.stderr == ""
    return result.returncode, result.stdout


def test_a_page_just_written_is_current(tree):
    assert RADIUS in (tree / "docs" / "limits.md").read_text()
    assert check(tree) == (0, "")


def test_what_a_world_holds_is_read_where_the_model_reads_it(tree):
    assert "1,000,000 entities" in (tree / "docs" / "limits.md").read_text()
    edit(tree / "core/include/genphys/limits.h", "kEntitiesMax = 1'000'000", "kEntitiesMax = 2'000'000")
    status, output = check(tree)
    assert status == 1
    assert "2,000,000 entities" in output


def test_what_shapes_of_a_world_take_is_read_where_the_model_reads_it(tree):
    page = (tree / "docs" / "limits.md").read_text()
    assert "1,000,000 geometries" in page and "1,024 MiB" in page


def test_a_changed_limit_makes_the_page_stale(tree):
    edit(tree / "proto/genphys/v1/shape.proto", "max: 1e5", "max: 2e5")
    status, output = check(tree)
    assert status == 1
    assert "-" + RADIUS in output
    assert "+" + RADIUS.replace("1e5 |", "2e5 |") in output


def test_a_changed_comment_makes_the_page_stale(tree):
    edit(tree / "proto/genphys/v1/shape.proto", "// A ball.", "// A round ball.")
    assert check(tree)[0] == 1


def test_a_page_edited_by_hand_is_refused(tree):
    edit(tree / "docs/limits.md", "1e-5 to 1e5", "0 to 1e5")
    assert check(tree)[0] == 1


def test_a_missing_page_is_refused(tree):
    (tree / "docs/limits.md").unlink()
    assert check(tree)[0] == 1
