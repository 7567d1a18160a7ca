"""Sweeps that are stopped, killed and begun again, and their processes, here and in a cluster."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from command_line import complaint, phaseplane, reported
from hosting import HANGS, PROGRAM, children, is_running, started, wait_until
from phaseplane.scenarios.errors import InputError, RunError
from phaseplane.scenarios.simulate import runner
from phaseplane.scenarios.sweeps import running
from phaseplane.scenarios.sweeps.journal import open_journal
from phaseplane.scenarios.sweeps.plan import Plan, load_plan
from phaseplane.scenarios.sweeps.running import Row, journal_key, sweep
from small_sweep import GRID, HEAD, SCENE, rows, sweep_file

pytestmark = pytest.mark.usefixtures("scene_of_a_sweep")


def test_what_is_in_the_journal_is_not_done_again(tmp_path: Path) -> None:
    plan = load_plan(sweep_file())
    journal = tmp_path / "journal"
    made_up = (123.0, 45)
    row = json.dumps([2, list(made_up), ""])
    key = json.dumps({"journal": journal_key(plan, "process")})
    journal.write_text(f"{key}\n{row}\n[3, [1")
    found, told = sweep(plan, journal, workers=1)
    assert told["made"] == 5
    assert found[2] == Row(2, made_up)
    assert found[3].values != made_up
    _, told = sweep(plan, journal, workers=1)
    assert told["made"] == 0  # what followed the incomplete line is there, too
    journal.write_text(f'{{"journal": "another"}}\n{row}')
    found, told = sweep(plan, journal, workers=1)
    assert told["made"] == 6
    assert found[2].values != made_up


def test_a_journal_that_cannot_be_written_is_named_and_kept(tmp_path: Path) -> None:
    """As on a full disk: the file may grow no further."""
    resource = pytest.importorskip("resource")
    journal = tmp_path / "journal"
    with open_journal(journal, "key") as (_, add):
        add([0, [1.0], ""])
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (journal.stat().st_size + 5, most))
    try:
        with open_journal(journal, "key") as (_, add), pytest.raises(RunError) as caught:
            add([1, [2.0], ""])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    assert str(caught.value) == f"cannot write {journal}: File too large"
    with open_journal(journal, "key") as (found, _):
        assert found == [[0, [1.0], ""]]
    with (
        pytest.raises(InputError, match=f"cannot write {journal}"),
        open_journal(journal / "x", "key"),
    ):
        pass


def test_what_two_of_the_same_write_to_their_journal_is_kept(tmp_path: Path) -> None:
    journal = tmp_path / "journal"
    with open_journal(journal, "key") as (_, add), open_journal(journal, "key") as (_, also):
        for k in range(3):
            add([k, [1.0], ""])
            also([k, [10.0], ""])
    with open_journal(journal, "key") as (found, _):
        assert found == [[k, [x], ""] for k in range(3) for x in (1.0, 10.0)]


def test_a_journal_is_that_of_one_way_to_run_one_version_and_one_content(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows of the process are not passed off as the FMU's, nor old ones as those of new code."""
    plan = load_plan(sweep_file())
    key = journal_key(plan, "process")
    assert key == journal_key(load_plan("sweep.toml"), "process")
    assert key != journal_key(plan, "fmu")
    with monkeypatch.context() as patch:
        patch.setattr("phaseplane.scenarios.sweeps.journal.versions", lambda: {"phaseplane": "99"})
        assert key != journal_key(plan, "process")
    own = tmp_path / "own.fmu"
    own.write_bytes(fmu.read_bytes())
    Path("scene.toml").write_text(SCENE.replace('"QuarterCar"', '"own.fmu"'))
    before = journal_key(load_plan("sweep.toml"), "fmu")
    assert before == journal_key(load_plan("sweep.toml"), "fmu")
    with zipfile.ZipFile(own, "a") as archive:
        archive.writestr("resources/note.txt", "another content")
    assert before != journal_key(load_plan("sweep.toml"), "fmu")


@pytest.mark.slow
def test_an_interrupted_sweep_of_the_process_is_not_that_of_the_fmu(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[str] = []

    def stopping(plan: Plan, runs: Sequence[int], through: str) -> list[Row]:
        made.append(through)
        if len(made) > 1:
            raise KeyboardInterrupt
        return [Row(run, (123.0, 45)) for run in runs]

    command = ("sweep", sweep_file(), "--workers", "1")
    with monkeypatch.context() as patch:
        patch.setattr(running, "run_chunk", stopping)
        assert phaseplane(*command).exit_code == 130
    assert reported(*command, "--through", "fmu")["made"] == 6
    assert "123" not in {row["peak.body_displacement"] for row in rows()}
    assert reported(*command)["made"] == 5


def long_sweep() -> list[str]:
    """The command of a sweep of 6000 runs, which takes minutes: it does not end by itself."""
    Path("scene.toml").write_text(SCENE.replace("0.2", "20.0").replace("5 ms", "1 ms"))
    return ["sweep", sweep_file(GRID.replace("count = 3", "count = 3000")), "--workers", "2"]


def some_are_made() -> bool:
    """Whether there are rows in the journal of the sweep that goes on."""
    journals = Path("out/sweeps").glob(".sweep.*.journal")
    return any(journal.read_text().count("\n") > 1 for journal in journals)


@pytest.mark.slow
def test_an_interrupted_sweep_goes_on_where_it_stopped() -> None:
    command = long_sweep()
    with started([*PROGRAM, *command], {}, stderr=subprocess.PIPE) as process:
        wait_until("some runs are made", some_are_made, process)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=HANGS)
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith("phaseplane: interrupted")
    assert not Path("out/sweeps/sweep").exists()
    (journal,) = Path("out/sweeps").glob(".sweep.*.journal")
    kept = [json.loads(line) for line in journal.read_text().splitlines()[1:]]
    assert kept
    others = sorted({*range(6000)} - {run for run, *_ in kept})
    with journal.open("a") as file:  # as if all but five had been made
        file.writelines(json.dumps([run, [123.0, 45], ""]) + "\n" for run in others[5:])
    assert reported(*command)["made"] == 5
    made = [float(row["peak.body_displacement"]) for row in rows()]
    assert len(made) == 6000
    assert [made[run] for run, *_ in kept] == [values[0] for _, values, _ in kept]
    assert all(made[run] != 123.0 for run in others[:5])
    assert not journal.exists()


def test_an_interrupt_waits_for_the_run_under_way_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of the chunk under way are kept as far as they are made, and no more are begun."""

    def interrupted(_plan: Plan, runs: Sequence[int]) -> Iterator[Row]:
        for k, run in enumerate(runs):
            if k == 2:
                os.kill(os.getpid(), signal.SIGINT)
                assert running._STOPPING.wait(HANGS)
            yield Row(run, (123.0, 45))

    many = sweep_file(GRID.replace("count = 3", "count = 60"))
    with monkeypatch.context() as patch:
        patch.setattr(running, "_in_process", interrupted)
        result = phaseplane("sweep", many, "--workers", "1")
    assert result.exit_code == 130
    said = "phaseplane: interrupted after 3 of 120 runs; start it again to continue\n"
    assert result.stderr.lstrip() == said
    (journal,) = Path("out/sweeps").glob(".sweep.*.journal")
    assert len(journal.read_text().splitlines()) == 1 + 3
    plan = load_plan(many)
    assert len(running.run_chunk(plan, range(2), "process")) == 2  # of a study after it


def test_a_further_interrupt_leaves_later_sweeps_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """While the thread of the runs ends; all later sweeps of the process ended without rows."""

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    executor = running._executor(1, "")
    _, stop = executor.__enter__()
    stop()
    with monkeypatch.context() as patch:
        patch.setattr(ThreadPoolExecutor, "shutdown", interrupted)
        with pytest.raises(KeyboardInterrupt):
            executor.__exit__(None, None, None)
    plan = load_plan(sweep_file())
    assert len(running.run_chunk(plan, range(2), "process")) == 2


def test_a_run_that_an_interrupt_meets_ends_as_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    driven, begun = runner._driven, []

    def interrupted(*given: Any) -> Any:
        begun.append(given)
        if len(begun) == 2:
            os.kill(os.getpid(), signal.SIGINT)
            assert running._STOPPING.wait(HANGS)
        return driven(*given)

    monkeypatch.setattr(runner, "_driven", interrupted)
    many = sweep_file(f"{HEAD}[vary]\nduration = {{ from = 0.1, to = 0.4, count = 60 }}")
    result = phaseplane("sweep", many, "--workers", "1")
    assert result.stderr.lstrip().startswith("phaseplane: interrupted after 2 of 60 runs")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="not on this platform: no signal masks")
def test_a_process_that_only_starts_survives_ctrl_c(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A terminal sends it to all processes; if one ended of it, the others would break, or hang."""
    (tmp_path / "startled.py").write_text("""
import os, signal
from phaseplane.scenarios.sweeps.running import _begin_worker

def begin(receiver):
    os.kill(os.getpid(), signal.SIGINT)
    _begin_worker(receiver)
""")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(running, "_begin_worker", import_module("startled").begin)
    made, _ = sweep(load_plan(sweep_file()), tmp_path / "journal", workers=2)
    assert len(made) == 6


@pytest.mark.parametrize(
    ("error", "options", "words", "why"),
    [
        # as where the memory does not suffice
        (BrokenProcessPool("abruptly"), "--workers 1", "a process of the sweep was killed", ""),
        # as the client of Dask does when the scheduler has gone, and when a worker dies again and again
        (CancelledError(), "--dask a", "the Dask cluster failed", ": the connection was lost"),
        (Exception("4 workers died"), "--dask a", "the Dask cluster failed", ": 4 workers died"),
    ],
)
def test_a_worker_that_is_lost_is_told_in_one_line(
    error: Exception, options: str, words: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is done is kept."""

    class Broken(ThreadPoolExecutor):
        def submit(self, *_: object, **__: object) -> Future[Any]:
            future: Future[Any] = Future()
            future.set_exception(error)
            return future

    @contextmanager
    def broken(_count: int, _dask: str) -> Iterator[tuple[Broken, Callable[[], None]]]:
        yield Broken(1), lambda: None

    monkeypatch.setattr(running, "_executor", broken)
    told = complaint("sweep", sweep_file(), *options.split(), status=1)
    assert told == f"phaseplane: {words} after 0 of 6 runs; start it again to continue{why}\n"


@pytest.mark.slow
def test_processes_of_a_sweep_that_is_killed_end_with_it() -> None:
    command = [*PROGRAM, *long_sweep()]
    with started(command, {}, stderr=subprocess.DEVNULL) as process:
        wait_until("some runs are made", some_are_made, process)
        workers = children(process)
        process.kill()
    assert len(workers) >= 2
    wait_until("its workers have ended", lambda: not any(map(is_running, workers)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of the cluster's own libraries
def test_a_dask_cluster_does_the_same_work(tmp_path: Path) -> None:
    import distributed  # noqa: PLC0415  (its warnings are let pass above)

    plan = load_plan(sweep_file())
    alone, _ = sweep(plan, tmp_path / "a", workers=1)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        together, _ = sweep(plan, tmp_path / "b", dask=cluster.scheduler_address)
    assert together == alone
