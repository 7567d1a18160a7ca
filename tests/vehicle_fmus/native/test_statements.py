"""Recorded calculations in C: the same bits, and a loop where operations repeat."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Sequence
from math import sin
from pathlib import Path
from typing import Any

import pytest
from hosting import library
from phaseplane.suspension.roads.profiles import spline, table
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.trace import Node, Tape
from phaseplane.vehicle_fmus.native.compilers import FLAGS
from phaseplane.vehicle_fmus.native.model import model_in_c
from phaseplane.vehicle_fmus.native.statements import Statement, Written, written

POINTS = [(0.1 * k + 0.01 * sin(k), 0.05 * sin(0.7 * k)) for k in range(200)]


def numbers_of(signal: Signal) -> list[Any]:
    return [x for s in signal.segments[1:] for x in (s.start, s.origin, *s.coefficients)]


def recorded(road: Any, *given: float) -> tuple[Tape, list[Node]]:
    tape = Tape()
    traced = [tape.given(f"p[{k}]", value, f"number {k}") for k, value in enumerate(given)]
    return tape, [tape.node(x) for x in numbers_of(road(POINTS, *traced))]


def in_c(tape: Tape, nodes: Sequence[Node]) -> Written:
    return written(
        tape.nodes.values(),
        [Statement(node, "out[{at}] = {value};", k) for k, node in enumerate(nodes)],
    )


def computed(found: Written, count: int, given: Sequence[float], folder: Path) -> list[float]:
    """What the statements give, compiled."""
    code = "\n".join([
        "#include <math.h>", *found.tables, "void run(const double *p, double *out) {",
        f"struct {{ {' '.join(found.arrays)} int none; }} here, *work = &here; (void) work;",
        *found.lines, "}",
    ])  # fmt: skip
    flags = [flag for flag in FLAGS if flag != "-fvisibility=hidden"]
    out = (ctypes.c_double * count)()
    library(code, folder, *flags).run((ctypes.c_double * len(given))(*given), out)
    return list(out)


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("ends", ["natural", "level"])
def test_a_spline_has_the_same_bits_and_is_written_as_loops(ends: Any, tmp_path: Path) -> None:
    """Its elimination uses the iteration before, and its solution runs backwards."""

    def road(points: Any, speed: Any, start: Any) -> Signal:
        return spline(points, speed, start, ends)

    tape, nodes = recorded(road, 20.0, 0.0)
    found = in_c(tape, nodes)
    loops = [line for line in found.lines if line.startswith("for")]
    assert 5 <= len(loops) <= 8
    assert len(found.lines) < 90  # for 1200 numbers
    for given in ([20.0, 0.0], [13.7, 0.3]):
        folder = tmp_path / f"{given[0]}"
        folder.mkdir()
        wanted = numbers_of(road(POINTS, *given))
        assert computed(found, len(nodes), given, folder) == wanted


def test_a_table_of_straight_lines_is_one_loop_over_its_points() -> None:
    tape, nodes = recorded(table, 20.0, 0.0)
    found = in_c(tape, nodes)
    assert sum(line.startswith("for") for line in found.lines) <= 3
    assert len(found.lines) < 30


def test_what_is_used_twice_is_computed_once() -> None:
    tape = Tape()
    a, b = tape.given("a", 1.0), tape.given("b", 2.0)
    total = a + b
    found = in_c(tape, [(total * total).node, (a + b).node])
    assert found.lines == ["const double t0 = a + b;", "out[0] = t0 * t0;", "out[1] = t0;"]


def test_a_long_chain_of_operations_is_cut_into_statements() -> None:
    """An expression in C, like Python's stack, has its limits."""
    tape = Tape()
    total = tape.given("p[0]", 1.0)
    for _ in range(3000):
        total = 1.0 - total * 0.5
    found = in_c(tape, [total.node])
    assert max(map(len, found.lines)) < 300
    assert len(found.lines) < 40


@pytest.mark.slow
def test_a_random_road_is_set_up_by_loops() -> None:
    """Its spline of 960 points gives ten thousand numbers, and comparisons that need one message."""
    text = model_in_c("QuarterCar", {"road.shape": "random", "road.profile_length": 30.0}).text
    body = text[
        text.index("static int set_up_what_stays(") : text.index("static void enter_fields(")
    ]
    assert body.count("\n") < 250
    guards = text[text.index("guards[] = {") : text.index("row_as_packed[")]
    assert guards.count("road.start, speed: ") == 1


@pytest.mark.slow
def test_what_follows_parameters_in_a_run_is_set_up_apart_from_the_road() -> None:
    text = model_in_c("QuarterCar", {"road.shape": "random", "road.profile_length": 30.0}).text
    change = text[text.index("static int set_up_what_changes(") : text.index("enter_fields(")]
    assert "p[V_SPRING_RATE]" in change
    assert "p[V_SPEED]" not in change
    assert "for (" not in change


@pytest.mark.slow
def test_what_is_noted_before_steps_is_short_on_a_long_road() -> None:
    text = model_in_c("QuarterCar", {"road.shape": "random", "road.profile_length": 30.0}).text
    snapshot = text[text.index("typedef struct Snapshot {") : text.index("} Snapshot;")]
    assert sum(map(int, re.findall(r"\[(\d+)\]", snapshot))) < 300
    (signals,) = re.findall(r"^struct Signals \{.*?^\};", text, re.M | re.S)
    assert " segment[" in signals
