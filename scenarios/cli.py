"""The command line `phaseplane`.

Every command imports what it needs when it runs, so that help costs nothing.
"""

from __future__ import annotations

import click

from .commands import (
    authoring,
    build,
    listing,
    modelling,
    replay,
    results,
    run,
    studies,
    sweeping,
    viewing,
)
from .commands.console import Commands


def _version(ctx: click.Context, _option: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415

        try:
            click.echo(f"phaseplane {version('phaseplane')}")
        except PackageNotFoundError:
            click.echo("phaseplane, not installed")
        ctx.exit()


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_version,
    help="Show the version and exit.",
)
@click.pass_context
def main(ctx: click.Context) -> None:
    """Nonlinear vehicle suspensions: FMUs, scripted runs and the graphical construction of 1957.

    Exit status: 0 done, 1 a run or an expectation failed, 2 bad input.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


for _command in (
    run.run,
    replay.replay,
    build.build,
    listing.list_cases,
    viewing.serve,
    results.show,
    results.compare,
    modelling.ladder,
    modelling.portrait,
    sweeping.sweep,
    studies.accuracy,
    studies.rules,
    studies.stability,
    authoring.new,
    authoring.schema,
):
    main.add_command(_command)


if __name__ == "__main__":
    main()
