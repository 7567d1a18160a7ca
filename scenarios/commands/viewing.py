"""`phaseplane serve`, and the options that show recordings in a viewer or on a web page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from functools import wraps
from pathlib import Path
from signal import SIGTERM, default_int_handler, signal
from typing import Any

import click

from phaseplane import recording

from ..errors import PICTURES, InputError, RunError, check_file
from ..look import FigureFile, look_of
from .console import warn

_LOOPBACK = "127.0.0.1"
_OPTIONS = (
    click.option(
        "--connect", "viewer", default="", metavar="URL",
        help="Display in the running viewer at this address, e.g. rerun+http://127.0.0.1:9876/proxy.",
    ),
    click.option("--serve", "served", is_flag=True, help="Display on a web page, until Ctrl-C."),
    click.option(
        "--address", default=_LOOPBACK, show_default=True, metavar="ADDRESS",
        help="Address to serve the page on; any but a loopback address opens it to other machines.",
    ),
)  # fmt: skip


save_option = click.option(
    "--save", type=click.Path(path_type=Path), metavar="F.rrd", help="Write a rerun recording."
)


_LOOK = (
    click.option("--dark", is_flag=True, help="Use a dark background."),
    click.option(
        "--no-title", is_flag=True,
        help="Omit the heading, in favour of a caption; it is stored as the title of the file.",
    ),
    click.option("--width", metavar="WIDTH", help="Width of the figure, e.g. 85mm."),
    click.option("--font", default="", metavar="FAMILY", help="Typeface, e.g. serif or STIXGeneral."),
    click.option("--mono", is_flag=True, help="Draw all lines in black, distinguished by dashes."),
)  # fmt: skip


def figure_options(
    what: str, moving: Sequence[str] = ()
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return the options of a figure of something, given to the command as `figure`, None without one.

    Parameters
    ----------
    moving : endings of files in which it is animated
    """
    also = f"; animated: {' or '.join(moving)}" if moving else ""
    options = (
        click.option(
            "--figure", type=click.Path(path_type=Path), metavar="F.png",
            help=f"Write a picture of {what} (.png, .svg or .pdf{also}).",
        ),
        *_LOOK,
    )  # fmt: skip

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def drawing(
            *, figure: Path | None, dark: bool, no_title: bool, width: str | None, font: str,
            mono: bool, **more: Any,
        ) -> Any:  # fmt: skip
            if figure is None:
                refuse_without_figure({
                    "--dark": dark, "--no-title": no_title, "--width": width, "--font": font,
                    "--mono": mono,
                })  # fmt: skip
                return command(figure=None, **more)
            check_file("--figure", figure, (*PICTURES, *moving))
            look = look_of("--", dark=dark, headed=not no_title, width=width, font=font, mono=mono)
            return command(figure=FigureFile(figure, look), **more)

        return _with(options, drawing)

    return decorated


def _with(options: Sequence[Callable[..., Any]], command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command with options, which its help lists in this order."""
    for option in reversed(options):
        command = option(command)
    return command


def refuse_without_figure(given: Mapping[str, object]) -> None:
    """Refuse options of a figure, which is not drawn, if one of them is given.

    Raises
    ------
    InputError : if one is.
    """
    for option, value in given.items():
        if value:
            raise InputError(f"{option} is for a figure; give --figure F.png, too")


def viewer_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options `--connect`, `--serve` and `--address`."""
    return _with(_OPTIONS, command)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), metavar="DIR")
@_OPTIONS[-1]
def serve(folder: Path, address: str) -> None:
    """Show the recordings in a folder on a web page.

    The page is served until Ctrl-C.
    """
    files = recordings_in(folder)
    # Ctrl-C is the end of this command whenever it comes, also before all names are printed
    with suppress(KeyboardInterrupt), page(True, address, files) as shown:
        for path in files:
            click.echo(f"  {path.relative_to(folder)}", err=True)
        shown.wait()


def recordings_in(folder: Path) -> list[Path]:
    """Return all recordings in a folder and its subfolders.

    Raises
    ------
    InputError : if there is no such folder, or no recording in it.
    """
    if not folder.is_dir():
        raise InputError(f"serve: no folder {folder}")
    files = sorted(folder.rglob("*.rrd"))
    if not files:
        raise InputError(f"serve: no recording (.rrd) in {folder}")
    return files


@contextmanager
def page(wanted: bool, address: str, files: Sequence[Path] = (), viewer: str = "") -> Iterator[Any]:
    """Serve a page that shows recordings, if `wanted`, and print its address.

    Parameters
    ----------
    viewer : address of a running viewer, which cannot be wanted as well
    """
    if wanted and viewer:
        raise InputError("--connect and --serve: give one of them")
    if not wanted:
        if address != _LOOPBACK:
            raise InputError("--address is that of a page; give --serve, too")
        yield None
        return
    before = signal(SIGTERM, default_int_handler)
    try:
        with recording.serving(files, address) as server:
            if not recording.is_loopback(address):
                warn([f"{address} lets other machines see the page"])
            click.echo(f"{server.page}\n(press Ctrl-C to stop)", err=True)
            yield server
    except OSError as error:
        raise RunError(error) from None
    finally:
        signal(SIGTERM, before)


@contextmanager
def until_interrupted(shown: Any) -> Iterator[None]:
    """Serve a page, if there is one, until Ctrl-C, which may come while the block still reports."""
    with suppress(KeyboardInterrupt) if shown else nullcontext():
        yield
        if shown:
            shown.wait()
