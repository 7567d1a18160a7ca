"""The README's Python examples run as they stand and print what it says."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from textwrap import dedent

import pytest

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
# runs of indented lines and of what stands between them, in turn
PARTS = re.split(r"((?:^    .*\n|^\n(?=    ))+)", README, flags=re.MULTILINE)
PROGRAMS = [
    k for k in range(1, len(PARTS), 2) if PARTS[k].lstrip().startswith(("from ", "import "))
]


@pytest.mark.parametrize("number", PROGRAMS)
def test_an_example_runs_and_prints_what_is_said(number: int) -> None:
    printed = StringIO()
    with redirect_stdout(printed):
        exec(compile(dedent(PARTS[number]), "README.md", "exec"), {"__name__": "example"})
    if PARTS[number + 1].strip() == "prints":
        assert dedent(PARTS[number + 2]).strip("\n") == printed.getvalue().strip("\n")


def test_there_are_examples_and_one_tells_what_it_prints() -> None:
    assert len(PROGRAMS) >= 4
    assert any(PARTS[number + 1].strip() == "prints" for number in PROGRAMS)
