"""Exit statuses, error messages, common options and the progress bar of all commands."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from errno import ENAMETOOLONG
from importlib import import_module
from math import isfinite
from pathlib import Path
from time import monotonic
from types import FrameType
from typing import Any, NamedTuple

import click

from ..errors import InputError, RunError, one_line
from ..progress import Progress, silent

DONE, FAILED, BAD_INPUT, INTERRUPTED, PIPE_CLOSED, TERMINATED = 0, 1, 2, 130, 141, 143
_SHOW_BAR_AFTER = 1.0  # s
# new objects before cycles are looked for: imports make many, and all of them stay
_GARBAGE = 200_000


class _PipeClosedError(Exception):
    """The reader of the output has closed the pipe."""


class Entry(NamedTuple):
    """A command in the list of commands.

    Parameters
    ----------
    place : its module, and its name in that module
    help : the first sentence of its docstring
    """

    place: str
    help: str


class _PandasForOthers:
    """A finder that prevents pandas from being imported where it is not used.

    At its first array, pyarrow imports pandas wherever it is installed, which takes as long as a run
    with its pictures. Code that imports pandas directly, such as a controller, still gets it.
    """

    _WITHOUT = ("phaseplane", "rerun", "pyarrow")

    @classmethod
    def find_spec(cls, name: str, _path: object = None, _target: object = None) -> None:
        """Refuse pandas if it is asked for on behalf of these packages."""
        if name != "pandas":
            return
        asking: FrameType | None = sys._getframe(1)
        while asking is not None and asking.f_globals["__name__"].startswith("importlib"):
            asking = asking.f_back
        if asking is not None and asking.f_globals["__name__"].partition(".")[0] in cls._WITHOUT:
            raise ModuleNotFoundError("pandas is not used by this command", name=name)


class _Imported(Mapping[str, click.Command]):
    """Commands by name, each imported on lookup."""

    def __init__(self, entries: Mapping[str, Entry], package: str):
        self._entries = entries
        self._package = package

    def __getitem__(self, name: str) -> click.Command:
        module, attribute = self._entries[name].place.split(".")
        return getattr(import_module(f"{self._package}.{module}"), attribute)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)


class Commands(click.Group):
    """A command group that exits with a status and reports any error in one line on stderr.

    Parameters
    ----------
    entries : the commands by name; each is imported when called
    package : the package of their modules
    """

    def __init__(self, *args: Any, entries: Mapping[str, Entry], package: str, **extra: Any):
        super().__init__(*args, **extra)
        self.entries = entries
        self.commands = _Imported(entries, package)  # type: ignore[assignment]

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.entries)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, entry.help) for name, entry in self.entries.items()])

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
        if args is None:  # it is the program
            _leave_ascii()
        sys.meta_path.insert(0, _PandasForOthers)
        # matrices here are small, and a thread that waits for large ones spins for 50 ms first
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        # no command opens a window, but matplotlib cannot be imported if the name is unknown
        os.environ.pop("MPLBACKEND", None)
        gc.set_threshold(_GARBAGE)
        atexit.register(gc.freeze)  # the interpreter would look for cycles in all that is left
        for name in ("stdout", "stderr"):
            if getattr(sys, name) is None:  # it is closed
                setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
            with suppress(AttributeError, ValueError):
                getattr(sys, name).reconfigure(errors="replace")
        try:
            with _cleaning_up_when_terminated():
                status = run()
        except click.ClickException as error:
            if isinstance(error, click.NoSuchOption):
                alike = _alike(error.option_name, error.possibilities or ())
                error = click.NoSuchOption(
                    error.option_name, possibilities=list(alike), ctx=error.ctx
                )
            complain(_complaint(error))
            status = BAD_INPUT
        except InputError as error:
            complain(error)
            status = BAD_INPUT
        except RunError as error:
            complain(error)
            status = FAILED
        except OSError as error:
            complain(
                f"{error.filename}: {error.strerror}" if error.filename else error.strerror or error
            )
            status = BAD_INPUT if error.errno == ENAMETOOLONG else FAILED
        except click.Abort as abort:  # raised by click from the interrupt, which may carry a text
            complain(f"interrupted {abort.__cause__ or ''}")
            status = INTERRUPTED
        except _PipeClosedError:
            status = PIPE_CLOSED
        sys.exit(status or DONE)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            status = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            with suppress(OSError, ValueError):  # so that the flush at exit is silent
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise _PipeClosedError from None
        return status


def _leave_ascii() -> None:
    """Start this program again in UTF-8 mode if names of files are in ASCII.

    UTF-8 mode is what Python chooses in the C locale, unless PYTHONUTF8=0 forbids it. In ASCII, names of
    files with other letters are surrogates, which the libraries that write tables and recordings refuse.
    """
    if sys.getfilesystemencoding() == "ascii":
        os.environ["PYTHONUTF8"] = "1"  # for the processes that it starts
        os.execv(sys.executable, [sys.executable, "-X", "utf8", *sys.orig_argv[1:]])


def _complaint(error: click.ClickException) -> str:
    """Return the message of an error; one about the command line that proposes nothing names the help."""
    message = error.format_message()
    proposes = message.endswith(("?", "?)")) or type(error) is click.BadParameter
    if not isinstance(error, click.UsageError) or error.ctx is None or proposes:
        return message
    _, *names = error.ctx.command_path.split()
    return f"{message.rstrip('.')}; see '{' '.join(['phaseplane', *names])} --help'"


def _alike(option: str, options: Iterable[str]) -> Iterator[str]:
    """Yield the options with similar names; click also counts the dashes, which all have."""
    from difflib import get_close_matches  # noqa: PLC0415  (for mistakes only)

    for other in options:
        if get_close_matches(option.lstrip("-"), [other.lstrip("-")]):
            yield other


@contextmanager
def _cleaning_up_when_terminated() -> Iterator[None]:
    """On SIGTERM raise SystemExit, so that all clean-up code runs."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, lambda _number, _frame: sys.exit(TERMINATED))
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def complain(message: object) -> None:
    """Print a message as one line on stderr."""
    click.echo(f"phaseplane: {one_line(message)}", err=True)


def failed(name: str, reasons: Sequence[str]) -> int:
    """Print the first of the reasons for which something failed, if any; return the exit status."""
    if not reasons:
        return DONE
    more = f" (and {len(reasons) - 1} more)" if len(reasons) > 1 else ""
    complain(f"{name}: {reasons[0]}{more}")
    return FAILED


def warn(messages: Iterable[str]) -> None:
    """Print warnings on stderr, one line each."""
    for message in messages:
        complain(f"warning: {message}")


set_option = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Set a key of the scene or a parameter, e.g. 'road.height=8 cm'. Repeatable.",
)
json_option = click.option("--json", "as_data", is_flag=True, help="Print JSON only.")


class FiniteRange(click.FloatRange):
    """A finite number within a range (click's own ranges accept nan)."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"{value} must be a finite number.", param, ctx)
        return number

    def _describe_range(self) -> str:  # click's own says x<=None of a range without bounds
        return "" if self.min is self.max is None else super()._describe_range()


class TimeRange(FiniteRange):
    """A time within a range, in s, or a string with a unit."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str):
            from phaseplane.suspension.units import UnitError, to_si  # noqa: PLC0415  (rarely needed)

            try:
                value = to_si(value, "s")
            except UnitError as error:
                self.fail(f"{error}.", param, ctx)
        return super().convert(value, param, ctx)


def pair(text: str) -> tuple[str, ...]:
    """Return the two names in the text of an option."""
    names = tuple(name.strip() for name in text.split(","))
    if len(names) != 2 or not all(names):
        raise click.BadParameter(f"{text}: give two columns, such as x,y.")
    return names


def output_option(default: str) -> Callable[[Any], Any]:
    """Return the option `--output DIR`, with its default in the help."""
    return click.option(
        "-o",
        "--output",
        type=click.Path(path_type=Path),
        metavar="DIR",
        help=f"Folder for the results; replaced as a whole. [default: {default}]",
    )


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """Show a progress bar on a terminal after the first second; until it is called, the time taken."""
    if not sys.stderr.isatty():
        yield silent
        return
    bar: Any = None
    started = monotonic()
    ended = threading.Event()

    def clear() -> None:
        """Stop the clock and clear its line."""
        ended.set()
        clock.join()
        if monotonic() - started > _SHOW_BAR_AFTER:
            click.echo("\r\033[K", err=True, nl=False)

    def tick() -> None:
        while not ended.wait(_SHOW_BAR_AFTER):
            click.echo(f"\r{label}  {monotonic() - started:.0f} s", err=True, nl=False)

    def show(part: float) -> None:
        nonlocal bar
        if bar is None and monotonic() - started > _SHOW_BAR_AFTER:
            clear()
            bar = click.progressbar(length=1000, label=label, file=sys.stderr)
            bar.__enter__()
        if bar is not None and int(1000 * part) > bar.pos:
            bar.update(int(1000 * part) - bar.pos)

    clock = threading.Thread(target=tick, daemon=True)
    clock.start()
    try:
        yield show
    finally:
        if bar is not None:
            bar.__exit__(None, None, None)
        else:
            clear()
