"""The command line in this process."""

from __future__ import annotations

from click.testing import CliRunner, Result
from phaseplane.scenarios.cli import main


def phaseplane(*arguments: str) -> Result:
    """What `phaseplane` with these arguments prints, and its exit status."""
    return CliRunner().invoke(main, arguments)


def settings(*given: str) -> tuple[str, ...]:
    """The options that set keys of a scene, from texts such as `road.height=8 cm`."""
    return tuple(word for setting in given for word in ("--set", setting))


BARE = settings("show.figures=[]", "show.recording=false")
