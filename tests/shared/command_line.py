"""The command line in this process, and the files of scenes that tests give it."""

from __future__ import annotations

import json
from pathlib import Path
from shlex import split
from typing import Any

from click.testing import CliRunner, Result
from phaseplane.scenarios.cli import main


def phaseplane(line: str = "", *more: object) -> Result:
    """What `phaseplane` with the words of a line, and more of them, prints, and its exit status."""
    result = CliRunner().invoke(main, [*split(line), *map(str, more)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exc_info
    return result


def printed(line: str = "", *more: object) -> str:
    """What a command that succeeds prints; warnings alone may be on stderr."""
    result = phaseplane(line, *more)
    assert result.exit_code == 0, result.output
    assert all(x.startswith("phaseplane: warning: ") for x in result.stderr.splitlines())
    return result.stdout


def reported(line: str, *more: object) -> Any:
    """The data that a command which succeeds prints with --json."""
    return json.loads(printed(line, *more, "--json"))


def complaint(line: str, *more: object, status: int = 2) -> str:
    """The one line on stderr of a command that has bad input, or fails."""
    result = phaseplane(line, *more)
    assert result.exit_code == status, result.output
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert result.stderr.startswith("phaseplane: ")
    assert status != 2 or result.stdout == ""
    return result.stderr


def settings(*given: str) -> tuple[str, ...]:
    """The options that set keys of a scene, from texts such as `road.height=8 cm`."""
    return tuple(word for setting in given for word in ("--set", setting))


UNDRAWN = ("show.figures=[]", "show.recording=false")
BARE = settings(*UNDRAWN)


def written(text: str, name: str = "scene.toml") -> str:
    """The name of a file with this text in the current folder, which is the test's own."""
    Path(name).write_text(text, encoding="utf-8")
    return name
