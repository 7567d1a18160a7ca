"""The command line `phaseplane`.

Every command imports what it needs when it runs, so that help costs nothing.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic
from typing import Any

import click

from .errors import InputError, RunError, one_line

DONE, FAILED, BAD_INPUT, INTERRUPTED, PIPE_CLOSED = 0, 1, 2, 130, 141
_SHOW_BAR_AFTER = 1.0  # s


class _PipeClosedError(Exception):
    """Nobody reads the output any more."""


class _Commands(click.Group):
    """Commands that end with a status and, if anything is wrong, one line on stderr."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        def run() -> Any:
            name = prog_name or "phaseplane"
            return click.Group.main(self, args, name, complete_var, standalone_mode=False, **extra)

        if not standalone_mode:
            return run()
        for stream in (sys.stdout, sys.stderr):
            with suppress(AttributeError, ValueError):
                stream.reconfigure(errors="replace")  # type: ignore[union-attr]
        try:
            status = run()
        except click.ClickException as error:
            _complain(error.format_message())
            status = BAD_INPUT
        except InputError as error:
            _complain(error)
            status = BAD_INPUT
        except (RunError, OSError) as error:
            _complain(error)
            status = FAILED
        except click.Abort:
            _complain("interrupted")
            status = INTERRUPTED
        except _PipeClosedError:
            status = PIPE_CLOSED
        sys.exit(status or DONE)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            status = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            with suppress(OSError, ValueError):  # so that the interpreter's own flush is silent
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise _PipeClosedError from None
        return status


def _complain(message: object) -> None:
    click.echo(f"phaseplane: {one_line(message)}", err=True)


def _version(ctx: click.Context, _option: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415

        try:
            click.echo(f"phaseplane {version('phaseplane')}")
        except PackageNotFoundError:
            click.echo("phaseplane, not installed")
        ctx.exit()


@click.group(
    cls=_Commands,
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


_set = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Set a key of the scene or a parameter, e.g. 'road.height=8 cm'. Repeatable.",
)
_json = click.option("--json", "as_data", is_flag=True, help="Print JSON and nothing else.")


@main.command()
@click.argument("scene")
@_set
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder of the results, replaced whole. [default: out/SCENE]",
)
@_json
def run(scene: str, overrides: tuple[str, ...], output: Path | None, as_data: bool) -> int:
    """Run SCENE: the name of a case (see `list`) or a scene file."""
    from .job import run_scene  # noqa: PLC0415
    from .report import failures, report  # noqa: PLC0415
    from .results import as_json  # noqa: PLC0415

    with _progress(scene) as progress:
        summary, folder = run_scene(scene, overrides, output, progress)
    click.echo(as_json(summary) if as_data else report(summary, folder))
    told = failures(summary)
    if told:
        more = f" (and {len(told) - 1} more)" if len(told) > 1 else ""
        _complain(f"{summary['scene']}: {told[0]}{more}")
    return FAILED if told else DONE


@main.command()
@click.argument("models", nargs=-1, metavar="[MODEL]...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    metavar="DIR",
    help="Folder for the FMUs.",
)
@_json
def build(models: tuple[str, ...], output: Path, as_data: bool) -> None:
    """Pack FMUs: the MODELs named, or all."""
    from .job import build_models  # noqa: PLC0415
    from .results import as_json  # noqa: PLC0415

    files = [str(path) for path in build_models(models, output)]
    click.echo(as_json({"files": files}) if as_data else "\n".join(files))


@main.command("list")
@_json
def list_cases(as_data: bool) -> None:
    """List the scenes that come with the package."""
    from .layers import case_titles  # noqa: PLC0415
    from .results import as_json  # noqa: PLC0415

    titles = case_titles()
    width = max(map(len, titles))
    click.echo(
        as_json(titles)
        if as_data
        else "\n".join(f"{name:<{width}}  {title}" for name, title in titles.items())
    )


@main.command()
@click.argument("what", metavar="SCENE|RESULTS")
@_set
@click.option("--construction", "rule", metavar="RULE", help="How a step is made, e.g. delta.")
@click.option("--step", metavar="TIME", help="Step of the construction, e.g. '2.5 ms'.")
@click.option(
    "--save", type=click.Path(path_type=Path), metavar="F.rrd", help="Write a rerun recording."
)
@click.option(
    "--figure",
    type=click.Path(path_type=Path),
    metavar="F.png",
    help="Write a picture of the phase planes (.png, .svg or .pdf).",
)
@_json
def replay(
    *,
    what: str,
    overrides: tuple[str, ...],
    rule: str | None,
    step: str | None,
    save: Path | None,
    figure: Path | None,
    as_data: bool,
) -> None:
    """Replay the graphical construction of a SCENE, or lay it over the RESULTS of a run."""
    from .job import replay as make  # noqa: PLC0415
    from .results import as_json  # noqa: PLC0415

    if save is None and figure is None:
        raise InputError("replay: nothing to write; give --save F.rrd or --figure F.png or both")
    extra = (("construction.rule", rule), ("construction.step", step))
    settings = (*overrides, *(f"{key}={value}" for key, value in extra if value is not None))
    told = make(what, settings, save, figure)
    click.echo(
        as_json(told)
        if as_data
        else f"{told['title']}: {told['steps']} steps in {', '.join(told['files'])}"
    )


@contextmanager
def _progress(label: str) -> Iterator[Callable[[float], None] | None]:
    """A bar on a terminal, for what takes over a second."""
    if not sys.stderr.isatty():
        yield None
        return
    bar: Any = None
    started = monotonic()

    def show(part: float) -> None:
        nonlocal bar
        if bar is None and monotonic() - started > _SHOW_BAR_AFTER:
            bar = click.progressbar(length=1000, label=label, file=sys.stderr)
            bar.__enter__()
        if bar is not None and int(1000 * part) > bar.pos:
            bar.update(int(1000 * part) - bar.pos)

    try:
        yield show
    finally:
        if bar is not None:
            bar.__exit__(None, None, None)


if __name__ == "__main__":
    main()
