"""`phaseplane serve`, and the options that show recordings in a viewer or on a web page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from signal import SIGTERM, default_int_handler, signal
from typing import Any

import click

from ..draw import live
from ..draw.live import recordings_in

_LOOPBACK = "127.0.0.1"
_OPTIONS = (
    click.option(
        "--connect", "viewer", default="", metavar="URL",
        help="Show it in this running viewer, e.g. rerun+http://127.0.0.1:9876/proxy.",
    ),
    click.option("--serve", "served", is_flag=True, help="Show it on a web page, until Ctrl-C."),
    click.option(
        "--address", default=_LOOPBACK, show_default=True, metavar="ADDRESS",
        help="Address to serve the page on; any but a loopback address opens it to other machines.",
    ),
)  # fmt: skip


save_option = click.option(
    "--save", type=click.Path(path_type=Path), metavar="F.rrd", help="Write a rerun recording."
)


def viewer_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options `--connect`, `--serve` and `--address`."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), metavar="DIR")
@_OPTIONS[-1]
def serve(folder: Path, address: str) -> None:
    """Show the recordings in a folder on a web page.

    The page is served until Ctrl-C.
    """
    with page(True, address, recordings_in(folder)) as shown:
        until_interrupted(shown)


@contextmanager
def page(wanted: bool, address: str, files: Sequence[Path] = ()) -> Iterator[Any]:
    """Serve a page that shows recordings, if `wanted`, and print its address."""
    if not wanted:
        yield None
        return
    if not live.is_loopback(address):
        click.echo(f"phaseplane: warning: {address} lets other machines see the page", err=True)
    before = signal(SIGTERM, default_int_handler)
    try:
        with live.page(files, address) as server:
            click.echo(f"{server.page}\n(press Ctrl-C to stop)", err=True)
            yield server
    finally:
        signal(SIGTERM, before)


def until_interrupted(shown: Any) -> None:
    """Serve a page until Ctrl-C, if there is one."""
    if shown:
        with suppress(KeyboardInterrupt):
            shown.wait()
