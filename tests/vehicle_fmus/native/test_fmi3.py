"""Native FMUs of FMI 3.0: the bits of FMI 2.0, located events, clocks, looks within steps."""

from __future__ import annotations

import posixpath
import random
import zipfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree
from phaseplane.scenarios.errors import InputError, RunError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate.runner import run
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import variables
from phaseplane.vehicle_fmus.reference import declared_inside, reference_files
from structures import STRUCTURES
from test_same_bits import Pair, not_fixed

Packer = Callable[..., Path]
SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
SWITCHING = ("QuarterCar", "with stops, friction and a sampled road", "Elastoplastic")
CLOCKS = ("lift_off_event", "touchdown_event")


def same_as_fmi2(
    what: str, seeds: range, events: bool, pack: Packer, slave: Any, work: Path
) -> int:
    """Compare in drawn runs; return the number of events at which steps ended."""
    structure, found = STRUCTURES[what], 0
    fmus = [pack(structure.model, *structure.settings.items(), text=structure.text, fmi=fmi)
            for fmi in (2, 3)]  # fmt: skip
    model, free = structure.loaded, not_fixed(fmus[0])
    for seed in seeds:
        with ExitStack() as stack:
            pair = [stack.enter_context(slave(fmus[0], work / f"{seed}-2")),
                    stack.enter_context(slave(fmus[1], work / f"{seed}-3", events))]  # fmt: skip
            Pair(pair, model, free, random.Random(f"{what} {seed}")).run()
            found += len(pair[1].instants)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("events", [False, True], ids=["plain", "events"])
@pytest.mark.parametrize("what", SWITCHING)
def test_both_versions_give_the_same_bits(
    what: str, events: bool, native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """With events, steps end on switches too, and the host goes on from each of them."""
    found = same_as_fmi2(what, range(4), events, native_fmu, slave, tmp_path)
    assert (found > 0) == events


@pytest.mark.slow
@pytest.mark.parametrize("what", STRUCTURES)
def test_both_versions_give_the_same_bits_in_many_runs(
    what: str, native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    same_as_fmi2(what, range(100, 110), True, native_fmu, slave, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["QuarterCar", "Elastoplastic", "Road"])
def test_what_describes_it_is_valid(model: str, native_fmu: Packer, tmp_path: Path) -> None:
    fmu = native_fmu(model, *STRUCTURES[model].settings.items(), fmi=3)
    assert validate_fmu(str(fmu)) == []
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path)
    for file, schema in (
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons.xsd"),
        ("sources/buildDescription.xml", "fmi3BuildDescription.xsd"),
    ):
        checked = etree.XMLSchema(file=str(SCHEMAS / schema))
        tree = etree.parse(tmp_path / file)
        assert checked.validate(tree), checked.error_log
    names = {v.name for v in read_model_description(str(fmu)).modelVariables}
    terminals = etree.parse(tmp_path / "terminalsAndIcons/terminalsAndIcons.xml")
    members = [m.get("variableName") for m in terminals.iter("TerminalMemberVariable")]
    assert set(members) <= names
    assert ("contact_force" in members) == (model == "QuarterCar")
    assert (tmp_path / "terminalsAndIcons/icon.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "documentation/index.html").read_text("utf-8")
    assert "lift_off_event" in page
    assert "fmi3Error" in page  # of a step that failed, which is not discarded in FMI 3.0


def test_the_reference_result_inside_is_declared() -> None:
    """By FMI-LS-REF: every file that is there, and none that is not."""
    files = reference_files("QuarterCar", {})
    inside = declared_inside(files)
    folder = "extra/org.fmi-standard.fmi-ls-ref"
    root = etree.fromstring(inside[f"{folder}/fmi-ls-manifest.xml"])
    space = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert root.get(f"{space}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    declared = {item.get("source"): item.get("role") for item in root.iter("Related")}
    assert {posixpath.normpath(f"{folder}/{source}") for source in declared} == set(inside) - {
        f"{folder}/fmi-ls-manifest.xml"
    }
    assert declared["QuarterCar_ref.csv"] == "result"
    assert inside[f"{folder}/QuarterCar_ref.csv"] == files["QuarterCar_ref.csv"]


def test_the_library_shows_the_functions_of_fmi_3_alone(
    native_fmu: Packer, functions_shown: Callable[[Path], list[str]], tmp_path: Path
) -> None:
    shown = functions_shown(native_fmu("QuarterCar", fmi=3))
    header = (tmp_path / "sources" / "fmi3Functions.h").read_text("utf-8")
    assert shown == sorted({word for word in header.replace("(", " ").split()
                            if word.startswith("fmi3") and f"FMI3_Export {word}TYPE {word};"
                            in " ".join(header.split())})  # fmt: skip


class Awake:
    """A host with event mode that notes which clocks tick, when, and which instants it is told of."""

    def __init__(self, fmu: Path, work: Path, **options: Any) -> None:
        folder = extract(str(fmu), str(work))
        description = read_model_description(folder)
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.clocks = [name for name in self.reference if name.endswith(CLOCKS)]
        self.one = FMU3Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="one",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.one.instantiate(eventModeUsed=True, **{"earlyReturnAllowed": True, **options})
        self.one.enterInitializationMode()
        self.one.exitInitializationMode()
        self.time, self.ticks, self.events = 0.0, [], []  # type: ignore[var-annotated]
        self.on_tick: dict[str, float] = {}  # force of the actuator from the tick on
        self.update()

    def update(self) -> None:
        active = self.one.getClock([self.reference[name] for name in self.clocks])
        now = [name for name, ticks in zip(self.clocks, active, strict=True) if ticks]
        self.ticks += [(self.time, name) for name in now]
        for name in now:
            if name in self.on_tick:
                self.one.setFloat64([self.reference["actuator_force"]], [self.on_tick[name]])
        again, over, *_, known, corner = self.one.updateDiscreteStates()
        assert not again
        assert not over
        assert not any(self.one.getClock([self.reference[name] for name in self.clocks]))
        self.corner = corner if known else None
        self.one.enterStepMode()

    def step(self, end: float) -> bool:
        """Step once; return whether the end has been reached."""
        event, _, early, self.time = self.one.doStep(self.time, end - self.time)
        if event:
            self.events.append(self.time)
            self.one.enterEventMode()
            self.update()
        return not early

    def run(self, until: float, interval: float) -> None:
        for k in range(1, round(until / interval) + 1):
            while not self.step(k * interval):
                pass

    def value(self, name: str) -> float:
        return float(self.one.getFloat64([self.reference[name]])[0])


def switches_of_contact(session: Session) -> list[tuple[float, str]]:
    return [
        (event.time, f"{event.element.removesuffix('tyre')}{CLOCKS[0 if event.after else 1]}")
        for event in session.events
        if event.kind == "contact"
    ]


@pytest.mark.slow
@pytest.mark.parametrize("interval", [1e-3, 7e-3, 0.07, 0.7])
def test_clocks_tick_at_the_located_instants(
    interval: float, native_fmu: Packer, tmp_path: Path
) -> None:
    session = Session("HalfCar", {})
    session.advance(0.7)
    host = Awake(native_fmu("HalfCar", fmi=3), tmp_path)
    host.run(0.7, interval)
    wanted = switches_of_contact(session)
    assert len(wanted) >= 4
    assert host.ticks == wanted  # equal, not only within 1e-9 s
    assert host.value("rear_last_lift_off") == session.value("rear_last_lift_off")
    count = host.one.getInt32([host.reference["front_lift_off_count"]])
    assert count == [session.value("front_lift_off_count")]


def test_without_early_return_the_clocks_tick_at_the_end_of_the_step(
    native_fmu: Packer, tmp_path: Path
) -> None:
    host = Awake(native_fmu("QuarterCar", fmi=3), tmp_path, earlyReturnAllowed=False)
    host.run(0.7, 0.01)
    session = Session("QuarterCar", {})
    session.advance(0.7)
    wanted = switches_of_contact(session)
    assert [name for _, name in host.ticks] == [name for _, name in wanted]
    for (seen, _), (located, _) in zip(host.ticks, wanted, strict=True):
        assert located <= seen < located + 0.01


def test_a_contact_that_a_parameter_makes_is_an_event_at_once(
    native_fmu: Packer, tmp_path: Path
) -> None:
    """A softer tyre is longer under no load: the wheel, in the air so far, stands on the road."""
    host = Awake(native_fmu("QuarterCar", fmi=3), tmp_path)
    host.run(0.05, 0.05)
    assert host.one.getBoolean([host.reference["airborne"]]) == [True]
    stiffness = host.value("tyre.stiffness")
    host.one.setFloat64([host.reference["tyre.stiffness"]], [0.4 * stiffness])
    assert not host.step(0.06)
    assert host.ticks[-1] == (0.05, "touchdown_event")
    assert host.one.getBoolean([host.reference["airborne"]]) == [False]
    while not host.step(0.06):
        pass
    session = Session("QuarterCar", {})
    session.advance(0.05)
    session.set_parameter("tyre.stiffness", 0.4 * stiffness)
    session.advance(0.06)
    for name in ("body_displacement", "wheel_velocity", "last_touchdown"):
        assert host.value(name) == session.value(name)


def test_parameters_change_between_steps_that_end_early(
    native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """Whether parameters change at successive communication points does not depend on early returns."""
    names = [*(v.name for v in variables("QuarterCar")), "time"]
    time, scale = [names.index("time")], [names.index("damper.scale")]
    found = []
    for events in (False, True):
        with slave(native_fmu("QuarterCar", fmi=3), tmp_path, events=events) as one:
            one.setupExperiment(startTime=0.0)
            one.enterInitializationMode()
            one.exitInitializationMode()
            for end, value in ((0.02, 1.0), (0.08, 1.2), (0.1, 1.4), (0.3, 1.4)):
                one.setReal(scale, [value])
                (now,) = one.getReal(time)
                one.doStep(now, end - now)
            found.append(one.getReal([names.index("body_displacement"), *time]))
    assert found[0] == found[1]


@pytest.mark.slow
def test_stops_and_yielding_are_events(native_fmu: Packer, tmp_path: Path) -> None:
    what = "with stops, friction and a sampled road"
    fmu = native_fmu("QuarterCar", *STRUCTURES[what].settings.items(), fmi=3)
    host = Awake(fmu, tmp_path / "a")
    for k in range(1, 60):
        host.one.setFloat64([host.reference["body_force"]], [-9000.0])
        while not host.step(0.01 * k):
            pass
    assert host.events
    assert not host.ticks
    flows = Awake(native_fmu("Elastoplastic", ("hardening", 500.0), fmi=3), tmp_path / "b")
    for k in range(1, 60):
        flows.one.setFloat64([flows.reference["force"]], [12.0 if k % 20 < 10 else -12.0])
        while not flows.step(0.05 * k):
            pass
    assert len(flows.events) > 2


@pytest.mark.slow
def test_the_next_corner_of_the_road_is_told(native_fmu: Packer, tmp_path: Path) -> None:
    host = Awake(
        native_fmu("Road", ("road.shape", "plank"), ("road.ramp_length", 0.1), fmi=3), tmp_path
    )
    corners = []
    while host.corner is not None:
        corners.append(host.corner)
        while not host.step(host.corner):
            pass
        host.one.enterEventMode()
        host.update()
    assert len(corners) >= 4
    assert corners == sorted(corners)
    h = 1e-7
    rates = []
    host = Awake(
        native_fmu("Road", ("road.shape", "plank"), ("road.ramp_length", 0.1), fmi=3),
        tmp_path / "2",
    )
    for corner in corners:
        sides = []
        for time in (corner - h, corner + h):
            host.step(time)
            sides.append(host.value("front_velocity") + host.value("rear_velocity"))
        rates.append(abs(sides[1] - sides[0]))
    assert min(rates) > 1e-3


def test_a_host_looks_within_steps_and_may_return_there(native_fmu: Packer, tmp_path: Path) -> None:
    """What it sees are the outputs of a run that stops there; looking changes nothing.

    A step cannot be taken from under it by a reset, by the end, or by a state.
    """
    seen: list[tuple[float, float]] = []
    refused: list[bool] = []
    ends: list[float] = []

    def look(
        _: Any, time: float, _set: bool, get: bool, done: bool, can: bool, asked: Any, end: Any
    ) -> None:
        assert (get, done, can) == (True, True, True)
        if not seen:
            for call in (host.one.reset, host.one.terminate, host.one.getFMUState):
                with pytest.raises(Exception, match="status 3"):
                    call()
                refused.append(True)
        seen.append((time, host.value("body_displacement")))
        if ends:
            asked[0], end[0] = True, ends[0]

    fmu = native_fmu("QuarterCar", fmi=3)
    host = Awake(fmu, tmp_path / "looking", intermediateUpdate=look)
    host.run(0.2, 0.05)
    assert len(seen) > 20
    assert len(refused) == 3
    times = [time for time, _ in seen]
    assert times == sorted(times)
    assert {0.05, 0.1, 0.2} <= set(times)
    other = Awake(fmu, tmp_path / "stopping")
    for time, value in seen:
        while other.time < time and not other.step(time):
            pass
        assert other.value("body_displacement") == value
    for wanted in (0.2345, 0.3012):
        ends[:] = [wanted]
        assert not host.step(0.4)
        assert host.time == wanted
    ends.clear()
    while host.time < 0.4:
        host.step(0.4)
    while other.time < 0.4:
        other.step(0.4)
    for name in ("body_velocity", "tyre_force", "airborne_time"):
        assert host.value(name) == other.value(name)


@pytest.mark.slow
@pytest.mark.parametrize("events", [False, True])
@pytest.mark.parametrize("early", [False, True])
def test_fmpy_runs_it_with_and_without_events(
    events: bool, early: bool, native_fmu: Packer
) -> None:
    """At the communication points all four ways give the rows of FMI 2.0."""
    options: dict[str, Any] = {"stop_time": 0.5, "output_interval": 0.01}
    wanted = simulate_fmu(str(native_fmu("QuarterCar")), **options)
    found = simulate_fmu(
        str(native_fmu("QuarterCar", fmi=3)),
        use_event_mode=events,
        early_return_allowed=early,
        **options,
    )
    last = {float(row["time"]): row for row in found}
    assert len(found) > len(wanted) or not (events or early)
    for row in wanted:
        for name in wanted.dtype.names:
            assert last[float(row["time"])][name] == row[name], (row["time"], name)


@pytest.mark.slow
def test_a_scene_drives_it_from_event_to_event(native_fmu: Packer) -> None:
    """Rows, measures and instants are those of the model itself; a run that fails says why."""
    settings = ["duration=0.5 s", "parameters.sprung_mass=350"]
    found = run(load_scene(str(native_fmu("QuarterCar", fmi=3)), settings))
    wanted = run(load_scene(str(native_fmu("QuarterCar")), settings))
    assert found.columns.keys() == wanted.columns.keys()
    for name, column in wanted.columns.items():
        assert np.array_equal(found.columns[name], column), name
    session = Session("QuarterCar", {"sprung_mass": 350.0})
    session.advance(0.5)
    assert found.columns["last_lift_off"][-1] == session.value("last_lift_off")
    settings[1] = "parameters.sprung_mass=-5"
    with pytest.raises((RunError, InputError), match="sprung_mass"):
        run(load_scene(str(native_fmu("QuarterCar", fmi=3)), settings))


@pytest.mark.parametrize("interval", [1e-3, 5e-3, 0.05])
def test_a_controller_woken_by_clocks_is_that_of_a_scene(
    interval: float, native_fmu: Packer, tmp_path: Path
) -> None:
    """An actuator acts from lift-off to touchdown; every contact is counted once."""
    outputs = "show.outputs=['last_lift_off', 'last_touchdown']"
    case = run(load_scene("woken_by_lift_off", [outputs], expect=False))
    host = Awake(native_fmu("QuarterCar", fmi=3), tmp_path)
    host.on_tick = {"lift_off_event": 1500.0, "touchdown_event": 0.0}
    host.run(0.15, interval)
    assert [name for _, name in host.ticks] == list(CLOCKS)
    assert host.one.getInt32([host.reference["lift_off_count"]]) == [1]
    wanted = [case.columns[name][-1] for name in ("last_lift_off", "last_touchdown")]
    for (time, _), located in zip(host.ticks, wanted, strict=True):
        assert abs(time - located) < 1e-9


def test_calls_out_of_place_are_refused(native_fmu: Packer, tmp_path: Path, capfd: Any) -> None:
    host = Awake(native_fmu("QuarterCar", fmi=3), tmp_path)
    with pytest.raises(Exception, match="status 3"):
        host.one.updateDiscreteStates()
    host.one.enterEventMode()
    with pytest.raises(Exception, match="status 3"):
        host.one.doStep(0.0, 0.1)
    with pytest.raises(Exception, match="status 3"):
        host.one.getInt64([0])
    with pytest.raises(Exception, match="status 3"):
        host.one.getClock([0])
    said = capfd.readouterr().out
    assert "fmi3UpdateDiscreteStates cannot be called in step mode" in said
    assert "fmi3DoStep cannot be called in event mode" in said
    host.one.terminate()
    with pytest.raises(Exception, match="status 3"):
        host.one.setString([0], ["gap"])
    assert "fmi3SetString cannot be called" in capfd.readouterr().out


def test_output_derivatives(native_fmu: Packer, tmp_path: Path) -> None:
    host = Awake(native_fmu("QuarterCar", fmi=3), tmp_path)
    host.run(0.1, 0.01)
    names = [
        v.name for v in variables("QuarterCar") if v.name in ("body_displacement", "wheel_velocity")
    ]
    rates = host.one.getOutputDerivatives([host.reference[name] for name in names], [1, 1])
    assert rates[0] == host.value("body_velocity")
    assert np.isclose(rates[1], host.value("wheel_acceleration"), rtol=1e-12)
