"""The command line `phaseplane`.

Each command lies in a module that is imported when the command is called, or its own help is asked
for; the list of commands is told from the table here.
"""

from __future__ import annotations

import click

import phaseplane

from .commands.console import Commands, Entry

COMMANDS = {
    "run": Entry("run.run", "Run SCENE: a case (see `list`), a scene file, or any .fmu file."),
    "sweep": Entry("sweeping.sweep", "Run a scene many times, as SWEEP says."),
    "replay": Entry(
        "replay.replay", "Draw the construction of a SCENE, or over the RESULTS of a run."
    ),
    "portrait": Entry(
        "modelling.portrait", "Show the phase portrait of SCENE: equilibria, cycles, sections."
    ),
    "list": Entry(
        "listing.list_cases", "List the scenes and the sweeps that come with the package."
    ),
    "new": Entry("new.new", "Write a scene to begin with, its choices explained."),
    "schema": Entry("schema.schema", "Explain the keys of a scene, or the variables of MODEL."),
    "show": Entry("results.show", "Show what is in RESULTS: the folder of a run, or a table."),
    "compare": Entry("results.compare", "Compare the results A and B column by column."),
    "serve": Entry("viewing.serve", "Show all recordings of a folder on a page, until Ctrl-C."),
    "build": Entry("build.build", "Pack FMUs: the MODELs named, or all."),
    "ladder": Entry(
        "modelling.ladder", "Find the smallest model that serves SCENE, by running them all."
    ),
    "accuracy": Entry(
        "studies.accuracy", "Compare error with run time, on SCENEs or the package's problems."
    ),
    "rules": Entry("studies.rules", "Compare the construction's step rules with the exact motion."),
    "stability": Entry("studies.stability", "Find where steps grow, in theory and in runs."),
}


def _version(ctx: click.Context, _option: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        click.echo(f"phaseplane {phaseplane.__version__}")
        ctx.exit()


@click.group(
    cls=Commands,
    entries=COMMANDS,
    package=f"{__package__}.commands",
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

    Exit status: 0 done, 1 a run or an expectation failed, 2 bad input, 130 interrupted.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


if __name__ == "__main__":
    main()
