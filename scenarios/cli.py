"""The command line `phaseplane`.

Each command is in a module that is imported only when the command or its help is called. The list
of commands comes from the table below.
"""

from __future__ import annotations

import click

import phaseplane

from .commands.console import Commands, Entry

COMMANDS = {
    "run": Entry("run.run", "Run a scene, a system or an FMU, and write its results."),
    "sweep": Entry("sweeping.sweep", "Run a scene many times with varied parameters."),
    "optimise": Entry("design.optimise", "Find the best parameters of a scene within bounds."),
    "fit": Entry("design.fit", "Fit parameters of a scene to measured signals."),
    "replay": Entry("replay.replay", "Draw the construction of a SCENE or of a run's RESULTS."),
    "portrait": Entry("modelling.portrait", "Draw the phase portrait of SCENE."),
    "modes": Entry(
        "modelling.modes", "List the modes of SCENE about rest: frequencies, damping, shapes."
    ),
    "exercise": Entry(
        "exercise.exercise", "Write an exercise: construct the first steps of SCENE by hand."
    ),
    "list": Entry(
        "listing.list_cases", "List built-in scenes, sweeps and models, or the parameters of FMU."
    ),
    "new": Entry("new.new", "Write a commented scene to start from."),
    "schema": Entry("guide.schema", "Explain the keys of a scene, or the variables of MODEL."),
    "show": Entry("results.show", "Summarise RESULTS: a run's folder or a table."),
    "compare": Entry("results.compare", "Compare the results A and B column by column."),
    "serve": Entry("viewing.serve", "Show the recordings in a folder on a web page."),
    "build": Entry("build.build", "Pack the given MODELs, or all models, as FMUs."),
    "ladder": Entry("modelling.ladder", "Find the smallest model that is accurate for SCENE."),
    "accuracy": Entry("studies.accuracy", "Measure error against run time."),
    "rules": Entry("studies.rules", "Compare the step rules with the exact motion."),
    "stability": Entry(
        "studies.stability", "Find the largest stable steps, in theory and in runs."
    ),
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
