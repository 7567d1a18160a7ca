"""A run drawn while it goes on: what arrives, and that nothing can disturb the run."""

from __future__ import annotations

import signal
import socket
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from subprocess import Popen
from urllib.parse import urlsplit
from urllib.request import urlopen

import numpy as np
import pytest
from hosting import HANGS, wait_until
from recorded import Recorded, paper
from rerun.error_utils import RerunWarning

from phaseplane.picture.paper import Reals
from phaseplane.recording import (
    VIEWS,
    Content,
    Live,
    View,
    is_loopback,
    listens,
    record,
    serving,
)
from phaseplane.recording.server import Server, free_port

TIME = np.linspace(0.0, 1.0, 1001)
COLUMNS = {
    "time": TIME,
    "body_displacement": 0.04 * np.sin(20 * TIME),
    "body_velocity": 0.8 * np.cos(20 * TIME),
}
WHOLE = Content("a run", histories=COLUMNS, pairs=(("body_displacement", "body_velocity"),))
BEFORE = replace(WHOLE, histories={name: np.zeros(0) for name in COLUMNS}, live=True)
TRAIL = "/sheet/trail/body_displacement/recent"


def drive(
    live: Live, step: float = 1e-3, at_half: Callable[[], object] = lambda: None
) -> list[tuple[float, ...]]:
    """A run of a thousand steps that tells the drawing of each."""
    rows: list[tuple[float, ...]] = []
    for k, row in enumerate(zip(*COLUMNS.values(), strict=True)):
        rows.append(tuple(map(float, row)))
        live.watch(list(COLUMNS), rows)
        time.sleep(step)
        if k == 600:
            at_half()
    return rows


def listening(port: int | None) -> str:
    """The address at which a port is open, as the kernel writes it: 0100007F is 127.0.0.1."""
    for line in Path("/proc/net/tcp").read_text().splitlines()[1:]:
        address, _, number = line.split()[1].partition(":")
        if int(number, 16) == port and line.split()[3] == "0A":
            return address
    raise AssertionError(f"nothing listens on port {port}")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("views", "late"),
    [(VIEWS, {}), (("histories",), {}), (("energies",), {"kinetic_energy": TIME})],
)
def test_a_file_is_complete_in_the_end(
    views: tuple[View, ...], late: dict[str, Reals], tmp_path: Path
) -> None:
    """Also with columns that are only known after the run."""
    whole = replace(WHOLE, views=views, histories={**COLUMNS, **late})
    with Live(replace(BEFORE, views=views), path=tmp_path / "live.rrd", patience=HANGS) as live:
        drive(live)
        live.complete(whole)
    assert live.problem == ""
    assert list(tmp_path.iterdir()) == [tmp_path / "live.rrd"]
    record(whole, tmp_path / "whole.rrd")
    made, wanted = Recorded(tmp_path / "live.rrd"), Recorded(tmp_path / "whole.rrd")
    assert made.rows.keys() == wanted.rows.keys()
    for path, rows in wanted.rows.items():
        assert len(made.rows[path]) == len(rows)


def test_a_file_alone_is_waited_for_however_busy_the_machine_is(tmp_path: Path) -> None:
    """Twenty seconds are for a viewer, which may never answer."""
    assert Live(BEFORE, path=tmp_path / "live.rrd").patience > HANGS
    assert Live(BEFORE, "rerun+http://127.0.0.1:1/proxy").patience == 20.0


@pytest.mark.slow
def test_what_was_drawn_stays_readable_and_the_old_file_stays(tmp_path: Path) -> None:
    target = tmp_path / "live.rrd"
    target.write_bytes(b"the old recording")
    with Live(BEFORE, path=target, patience=HANGS) as live:
        half = 0

        def some_are_handed_over() -> None:
            nonlocal half
            wait_until("some rows are drawn", lambda: live.rows_drawn > 100)
            half = live.rows_drawn

        drive(live, at_half=some_are_handed_over)
        wait_until(
            "more rows are drawn", lambda: live.rows_drawn > half
        )  # not before all up to there are in the file
        assert live._child is not None
        live._child.send_signal(signal.SIGKILL)
        live.complete(WHOLE)
    assert live.problem
    assert target.read_bytes() == b"the old recording"
    with pytest.warns(RerunWarning, match="no footer"):
        drawn = Recorded(tmp_path / "live.part.rrd")
    rows = drawn.rows[TRAIL]
    assert len(rows) > 100
    ends = np.array([paper(row["LineStrips2D:strips"][0])[1] for row in rows])
    times = np.array([row["t"] for row in rows])
    np.testing.assert_allclose(ends.real, 0.04 * np.sin(20 * times), atol=1e-6)
    np.testing.assert_allclose(ends.imag, 0.8 * np.cos(20 * times), atol=1e-5)
    starts = np.array([paper(row["LineStrips2D:strips"][0])[0] for row in rows])
    np.testing.assert_array_equal(starts[1:], ends[:-1])  # no gap between batches


@pytest.mark.slow
def test_a_fast_run_is_thinned(tmp_path: Path) -> None:
    with Live(BEFORE, path=tmp_path / "live.rrd", patience=HANGS) as live:
        rows: list[tuple[float, ...]] = []
        live.watch(list(COLUMNS), rows)
        rows.extend([(float(k), 0.0, 0.0) for k in range(100_000)])
        wait_until("a row is drawn", lambda: live.rows_drawn)
    assert live._taken == len(rows)
    assert live.rows_drawn <= 250


@pytest.mark.slow
@pytest.mark.parametrize(
    ("address", "family"), [("::1", socket.AF_INET6), ("localhost", socket.AF_INET)]
)
def test_a_page_can_be_served_at_an_address_of_ipv6_and_at_a_name(
    address: str, family: socket.AddressFamily
) -> None:
    try:
        socket.create_server((address, 0), family=family).close()
    except OSError:
        pytest.skip("this machine has no IPv6")
    with serving(address=address) as server, urlopen(server.page) as page:
        assert b"Rerun Viewer" in page.read()
        assert listens(server.url)


@pytest.mark.parametrize("address", ["no..name", "192.0.2.1"])  # no name; of no machine
def test_an_address_at_which_nothing_can_listen(address: str) -> None:
    with pytest.raises(OSError, match=f"cannot listen at {address}: "), serving(address=address):
        pass


@pytest.mark.slow
def test_ports_that_another_process_takes_first_are_left_to_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What answers there is not the own server."""

    def ports(server: Server) -> set[int | None]:
        return {urlsplit(server.url).port, urlsplit(server.page).port}

    with serving() as first:
        taken = [*ports(first)]
        monkeypatch.setattr(
            "phaseplane.recording.server.free_port",
            lambda *wanted: taken.pop() if taken else free_port(*wanted),
        )
        with serving() as second:
            assert ports(first).isdisjoint(ports(second))
            assert second.process.poll() is None


def test_a_viewer_that_is_not_there() -> None:
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        url = f"rerun+http://127.0.0.1:{held.getsockname()[1]}/proxy"
        with Live(BEFORE, url) as live:
            assert len(drive(live, step=0.0)) == 1001
            live.complete(WHOLE)
        assert live.problem == f"no viewer listens at {url}"


@pytest.mark.slow
def test_a_server_is_seen_from_this_machine_alone_and_ends_with_its_block() -> None:
    with serving() as server:
        with urlopen(server.page) as page:
            assert b"Rerun Viewer" in page.read()
        assert listens(server.url)
        assert {listening(urlsplit(at).port) for at in (server.url, server.page)} == {"0100007F"}
        assert server.process.poll() is None
    assert server.process.poll() is not None


@pytest.mark.slow
def test_a_viewer_that_is_killed() -> None:
    with serving() as server, Live(BEFORE, server.url) as live:
        drive(live, at_half=lambda: server.process.send_signal(signal.SIGKILL))
        live.complete(WHOLE)
        assert live.problem


@pytest.mark.slow
def test_a_viewer_that_is_gone_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """It was given the patience of a slow one: a run began 20 s late, without a viewer."""
    silent = [sys.executable, "-c", "import sys; sys.stdin.buffer.read()"]  # as rerun in its place
    monkeypatch.setattr(
        "phaseplane.recording.live.subprocess.Popen", lambda _, **more: Popen(silent, **more)
    )
    with socket.create_server(("127.0.0.1", 0)) as viewer:
        url = f"rerun+http://127.0.0.1:{viewer.getsockname()[1]}/proxy"
        live = Live(BEFORE, url, patience=5.0)
    with live:
        assert live.problem == f"the viewer at {url} no longer answers"


@pytest.mark.slow
def test_a_viewer_that_stands_still() -> None:
    with serving() as server:
        with Live(BEFORE, server.url, patience=HANGS) as live:
            drive(live, at_half=lambda: server.process.send_signal(signal.SIGSTOP))
            assert not live.problem  # the run went on to its end while the viewer was waited for
            live.patience = 1.0
            live.complete(WHOLE)
        server.process.send_signal(signal.SIGCONT)
        assert live.problem


@pytest.mark.parametrize("url", [
    "http://127.0.0.1:1/proxy", "rerun+http://here/proxy", "viewer", "rerun+http://[::1:1/proxy"
])  # fmt: skip
def test_what_is_no_address(url: str) -> None:
    with pytest.raises(ValueError, match=r"write it as rerun\+http://127"):
        Live(BEFORE, url)
    assert not listens("rerun+http://no..name:1/proxy")


@pytest.mark.parametrize(
    ("address", "only_here"),
    [("127.0.0.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False), ("car", False)],
)
def test_which_addresses_are_of_this_machine_alone(address: str, only_here: bool) -> None:
    assert is_loopback(address) == only_here
