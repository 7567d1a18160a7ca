"""The pages' programs and commands run as they stand, and print what the pages say.

A page is worked through from top to bottom in a folder of its own. An indented block is a file if the
sentence before it names one, a program if it starts with an import, and otherwise a list of commands
if it starts with one; `<!-- not run: reason -->` above a block leaves it out. A program has the FMUs that
the page packs before it. What is printed may go on
where the page ends it with `...`.
"""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from textwrap import dedent

import command_line
import pytest
from phaseplane.suspension.units import UNITS
from phaseplane.vehicle_fmus.build import build

import phaseplane

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
PROGRAM = Path(sys.executable).with_name("phaseplane")
NAMED = re.compile(r"`([\w.]+\.(?:toml|csv|py))`")


@dataclass(frozen=True)
class Block:
    """An indented block, with the sentence before it and the block that says what it prints."""

    page: str
    line: int
    before: str
    text: str
    printed: str | None

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"

    @property
    def omitted(self) -> bool:
        return self.before.endswith("-->") and "<!-- not run: " in self.before

    @property
    def is_program(self) -> bool:
        return self.text.startswith(("from ", "import "))

    @property
    def file(self) -> str | None:
        """The name of the file that this is."""
        names = NAMED.findall(self.before)
        ends = self.before.endswith((":", ",")) and not self.is_program and not self.commands
        return names[0] if names and ends else None

    @property
    def commands(self) -> list[tuple[str, str | None]]:
        """Each command, with what it prints where the block shows it."""
        if self.text.startswith("$ "):
            parts = re.split(r"^\$ (.*)\n", self.text + "\n", flags=re.MULTILINE)[1:]
            return list(zip(parts[::2], parts[1::2], strict=True))
        lines = [re.sub(r"\s+# .*", "", line) for line in self.text.splitlines()]
        lines = [line.removeprefix(".venv/bin/") for line in lines if line]
        if not lines or not all(line.startswith("phaseplane ") for line in lines):
            return []
        return [(line, self.printed if len(lines) == 1 else None) for line in lines]


def _name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path) -> Iterator[Block]:
    """The indented blocks of a page."""
    text = page.read_text(encoding="utf-8")
    # runs of indented lines and of what stands between them, in turn
    parts = re.split(r"((?:^    .*\n|^\n(?=    ))+)", text, flags=re.MULTILINE)
    for k in range(1, len(parts), 2):
        line = "".join(parts[:k]).count("\n") + 1
        before = parts[k - 1].strip().split("\n\n")[-1]
        tells = parts[k + 1].strip().lower().split("\n\n")[-1].endswith("prints")
        printed = dedent(parts[k + 2]).strip("\n") if tells and k + 2 < len(parts) else None
        yield Block(_name(page), line, before, dedent(parts[k]).strip("\n"), printed)


BLOCKS = {_name(page): tuple(blocks(page)) for page in PAGES}
PROGRAMS = [block for page in BLOCKS.values() for block in page if block.is_program]
WITH_COMMANDS = [page for page, found in BLOCKS.items() if any(b.commands for b in found)]


def packed_before(block: Block) -> list[str]:
    """The commands of a page that pack FMUs before a block, without the name of the program."""
    earlier = [b for b in BLOCKS[block.page] if b.line < block.line and not b.omitted]
    commands = [command.removeprefix("phaseplane ") for b in earlier for command, _ in b.commands]
    return [command for command in commands if command.startswith("build ")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the programs run: with the FMU that the README packs before."""
    place = tmp_path_factory.mktemp("examples")
    build(["QuarterCar"], place / "fmus")
    return place


@pytest.mark.sampled
@pytest.mark.parametrize("block", PROGRAMS, ids=str)
def test_a_program_runs_and_prints_what_is_said(
    block: Block, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    for command in packed_before(block):
        command_line.printed(command)
    printed = StringIO()
    with redirect_stdout(printed):
        exec(compile(block.text, str(block), "exec"), {"__name__": "example"})
    if block.printed is not None:
        assert printed.getvalue().strip("\n") == block.printed


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_COMMANDS)
def test_commands_run_and_print_what_is_said(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # FMUs are packed, as it is told
    monkeypatch.setenv("PHASEPLANE_CACHE", str(tmp_path / "cache"))
    for block in BLOCKS[page]:
        if block.file:
            (tmp_path / block.file).write_text(block.text + "\n", encoding="utf-8")
        for command, printed in [] if block.omitted else block.commands:
            arguments = ["-c", f'exec "$0" {command.removeprefix("phaseplane ")}', PROGRAM]
            done = subprocess.run(
                ["sh", *arguments], cwd=tmp_path, check=False, capture_output=True, text=True
            )
            refused = printed is not None and printed.startswith("phaseplane: ")
            assert done.returncode == (2 if refused else 0), f"{block}: {command}\n{done.stderr}"
            if printed is not None:
                found = _without_times(done.stderr if refused else done.stdout)
                told = _without_times(printed)
                if told.endswith("\n..."):
                    told = told.removesuffix("...")
                    found = found[: len(told)]
                assert found == told, f"{block}: {command}"


def _without_times(text: str) -> str:
    """Leave out times, which differ from run to run, and how wide columns are."""
    text = re.sub(r"\b[\d.]+ m?s\b", "some time", text)
    return "\n".join(re.sub(" +", " ", line.rstrip()) for line in text.strip("\n").splitlines())


def test_there_are_examples_and_some_tell_what_they_print() -> None:
    assert len(PROGRAMS) >= 5
    assert len(WITH_COMMANDS) >= 6
    assert any(block.printed for block in PROGRAMS)
    told = [printed for p in WITH_COMMANDS for b in BLOCKS[p] for _, printed in b.commands]
    assert sum(printed is not None for printed in told) >= 3


@pytest.mark.parametrize("page", BLOCKS)
def test_no_program_stands_below_commands_of_its_block(page: str) -> None:
    """As such a block is neither, it would not be run."""
    for block in BLOCKS[page]:
        first, *others = block.text.split("\n\n")
        if first.startswith(("phaseplane ", "$ ")):
            assert not any(part.startswith(("from ", "import ")) for part in others), block


def test_the_units_on_the_page_are_those_accepted() -> None:
    text = (ROOT / "docs" / "terms.md").read_text(encoding="utf-8")
    rows = [row.split("|")[2:4] for row in text.splitlines() if re.match(r"\| [a-z ]+ \| `", row)]
    told = {si.strip(" `"): re.findall(r"`([^`]+)`", others) for si, others in rows}
    assert told == {name: list(unit.display) for name, unit in UNITS.items()}


@pytest.mark.slow
def test_the_errors_of_the_step_rules_on_the_page_are_those_found() -> None:
    text = (ROOT / "docs" / "constructions.md").read_text(encoding="utf-8")
    columns = r" \| ([\d.]+)" * 3 + r" \| (\d) \| ([\d., ]+) \|$"
    told = re.findall(r"^\| (?:integrator, )?`(\w+)`" + columns, text, re.MULTILINE)
    found = [
        (
            rule["rule"].removeprefix("integrator: "),
            *(f"{1e3 * error:.3g}" for error in rule["errors"].values()),
            str(rule["stated_order"]),
            ", ".join(f"{order:.2f}" for order in rule["orders"]),
        )
        for rule in command_line.reported("rules")["rules"]
    ]
    assert told == found


@pytest.mark.slow
def test_the_touchdowns_under_a_controller_on_the_page_are_those_found() -> None:
    text = (ROOT / "docs" / "controllers.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| (event-triggered, and )?evaluated every ([\d.]+) ms[^|]*\| ([\d.]+) ms \|.*\| (\d+) N \|$",
        text,
        re.MULTILINE,
    )
    assert len(rows) == 5
    for woken, period, touchdown, force in rows:
        controller = {"controller.events": bool(woken), "controller.period": f"{period} ms"}
        run = phaseplane.run("woken_by_lift_off", {**controller, "show.output_interval": 1e-5})
        (found,) = run.measures["touchdowns"]
        later = run["contact_force"][run["time"] >= found]
        assert (f"{1e3 * found:.3f}", f"{later.max():.0f}") == (touchdown, force)


def test_the_version_is_the_same_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    headings = re.findall(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert re.findall(r"^version: (.+)$", citation, re.MULTILINE) == [project["version"]]
    assert headings[0] == project["version"]


def test_the_readme_is_short() -> None:
    assert len(PAGES[0].read_text(encoding="utf-8").splitlines()) <= 150


def test_the_site_shows_every_page() -> None:
    shown = runpy.run_path(str(ROOT / "docs" / "conf.py"))["CONTENTS"].values()
    pages = {page.relative_to(ROOT / "docs").with_suffix("").as_posix() for page in PAGES[1:]}
    assert {name for names in shown for name in names} == pages


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_links_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        assert (page.parent / target).exists(), f"{_name(page)}: {target}"
