"""The pages' Python examples run as they stand and print what the pages say."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from textwrap import dedent

import pytest
from phaseplane.vehicle_fmus.build import build

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
# runs of indented lines and of what stands between them, in turn
PARTS = {
    page.name: re.split(
        r"((?:^    .*\n|^\n(?=    ))+)", page.read_text(encoding="utf-8"), flags=re.MULTILINE
    )
    for page in PAGES
}
PROGRAMS = [
    (page, k)
    for page, parts in PARTS.items()
    for k in range(1, len(parts), 2)
    if parts[k].lstrip().startswith(("from ", "import "))
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the examples run: with the FMU that the README packs before."""
    place = tmp_path_factory.mktemp("examples")
    build(["QuarterCar"], place / "fmus")
    return place


@pytest.mark.parametrize(("page", "number"), PROGRAMS)
def test_an_example_runs_and_prints_what_is_said(
    page: str, number: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    parts = PARTS[page]
    printed = StringIO()
    with redirect_stdout(printed):
        exec(compile(dedent(parts[number]), page, "exec"), {"__name__": "example"})
    if parts[number + 1].strip() == "prints":
        assert dedent(parts[number + 2]).strip("\n") == printed.getvalue().strip("\n")


def test_there_are_examples_and_one_tells_what_it_prints() -> None:
    assert len(PROGRAMS) >= 5
    assert any(PARTS[page][number + 1].strip() == "prints" for page, number in PROGRAMS)


def test_the_readme_is_short() -> None:
    assert len(PAGES[0].read_text(encoding="utf-8").splitlines()) <= 150


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        assert (page.parent / target).exists(), f"{page.name}: {target}"
