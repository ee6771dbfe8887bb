"""What the documents show runs as it stands there."""

import pathlib
import re

import pytest

_ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("page", ["README.md", "client/python/README.md"])
def test_the_first_program_runs(page, capsys):
    program = re.search(r"```python\n(.*?)```", (_ROOT / page).read_text(), re.DOTALL).group(1)
    exec(compile(program, page, "exec"), {})
    position, *events = capsys.readouterr().out.strip().splitlines()
    assert position.startswith("[")
    assert any("ContactBegan" in event for event in events)
