"""The command line in this process."""

from __future__ import annotations

from click.testing import CliRunner, Result
from phaseplane.scenarios.cli import main


def phaseplane(*arguments: str) -> Result:
    """What `phaseplane` with these arguments prints, and its exit status."""
    return CliRunner().invoke(main, arguments)
