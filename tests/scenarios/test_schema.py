"""Scenes: what they say, what they refuse, and in which words."""

from __future__ import annotations

import re
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import pytest
from command_line import written
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.fields import one_of
from phaseplane.scenarios.scene.layers import KEYS
from phaseplane.scenarios.scene.loading import construction_settings, load_scene
from phaseplane.scenarios.scene.schema import Scene
from phaseplane.scenarios.scene.sections import DETAILS, FIGURES, RULES, Construction
from phaseplane.scenarios.toml_files import read_content

KGF = 9.80665  # N
MINIMAL = 'fmu = "QuarterCar"\nduration = "1 s"\n'


def refusal(reference: str, *overrides: str) -> str:
    with pytest.raises(InputError) as caught:
        load_scene(reference, overrides)
    message = str(caught.value)
    assert message.isprintable()
    return message


# -- what a scene says ---------------------------------------------------------------------------


def test_published_values_reach_the_parameters() -> None:
    """AP57 section 8: kgf, cm, s in the file, SI in the scene, and the paper's own results."""
    p: dict[str, Any] = {**load_scene("ap57").parameters}
    assert p["sprung_mass"] == pytest.approx(0.3 * 100 * KGF, rel=1e-15)
    assert p["spring.rate"] == pytest.approx(15 * 100 * KGF, rel=1e-15)
    assert p["damper.bump_rate"] == pytest.approx(0.5 * 100 * KGF, rel=1e-15)
    load = (p["sprung_mass"] + p["unsprung_mass"]) * KGF
    assert load / p["tyre.stiffness"] == pytest.approx(2.157e-2, abs=5e-6)  # x2st
    omega_2 = (p["tyre.stiffness"] / p["unsprung_mass"]) ** 0.5
    assert omega_2 == pytest.approx(70.7107, abs=5e-5)
    assert p["road.length"] / p["speed"] == pytest.approx(0.05, rel=1e-15)


def test_figure_13_is_ap57_with_the_wheel_on_the_road() -> None:
    base, derived = load_scene("ap57"), load_scene("ap57_figure13")
    assert derived.parameters == {**base.parameters, "lift_off": False}
    assert derived.duration == 0.15
    assert derived.source == base.source
    assert "construction_sheet" in derived.show.figures


def test_defaults_show_the_motion_and_draw_nothing() -> None:
    scene = load_scene(written(MINIMAL))
    assert {"body_displacement", "wheel_acceleration", "contact_force"} <= set(scene.outputs)
    assert "stable_step" not in scene.outputs
    assert (scene.show.figures, scene.show.recording, scene.show.draws) == ((), False, False)
    assert scene.columns == scene.outputs


def test_columns_add_to_the_outputs_what_is_drawn() -> None:
    text = MINIMAL + '[show]\noutputs = ["contact_force"]\n'
    assert load_scene(written(text)).columns == ("contact_force",)
    drawn = load_scene(written(text + 'figures = ["time_histories"]\n'))
    assert {"contact_force", "ground_elevation", "body_velocity"} < set(drawn.columns)


def test_all_outputs() -> None:
    scene = load_scene(written(MINIMAL + '[show]\noutputs = "all"\n'))
    assert set(scene.outputs) == set(scene.fmu.outputs())


def test_nested_and_quoted_keys_are_the_same() -> None:
    for text in ("[parameters.spring]\nrate = 2e4\n", '[parameters]\n"spring.rate" = 2e4\n'):
        assert load_scene(written(MINIMAL + text)).parameters == {"spring.rate": 2e4}
    both = MINIMAL + '[parameters]\n"spring.rate" = 1.0\nspring.rate = 2.0\n'
    assert "'parameters.spring.rate' is given twice" in refusal(written(both))


@pytest.mark.parametrize(
    ("override", "read", "expected"),
    [
        ("road.height=8 cm", lambda s: s.parameters["road.height"], 0.08),
        ("parameters.road.height=8 cm", lambda s: s.parameters["road.height"], 0.08),
        ("road.height = 0.08", lambda s: s.parameters["road.height"], 0.08),
        ("lift_off=false", lambda s: s.parameters["lift_off"], False),
        ("damper={bump_rate=5, rebound_rate=6}", lambda s: s.parameters["damper.bump_rate"], 5.0),
        ("road.shape=sine", lambda s: s.parameters["road.shape"], "sine"),
        ("duration=250 ms", lambda s: s.duration, 0.25),
        ("title=a = b", lambda s: s.title, "a = b"),
        ("show.figures=[]", lambda s: s.show.figures, ()),
        ("show.recording=true", lambda s: s.show.recording, "stages"),
        ("construction.plane_scales=[1, 2]", lambda s: s.construction.plane_scales, (1.0, 2.0)),
        ("expect.lift_off_count=7", lambda s: s.expect["lift_off_count"].max, 7.0),
    ],
)
def test_override(override: str, read: object, expected: object) -> None:
    assert read(load_scene("ap57", [override])) == expected  # type: ignore[operator]


def test_a_scene_over_another_expects_what_it_says_itself_where_the_motion_is_another() -> None:
    """A new title or tolerance leaves what the base expects; another motion drops it."""
    for text in ('title = "x"', "parameters.solver.tolerance = 1e-8"):
        over = load_scene(written(f'extends = "ap57"\n{text}\n'))
        assert over.expect.keys() == load_scene("ap57").expect.keys()
    text = 'extends = "ap57"\nparameters.speed = 10\nexpect.lift_off_count = 0\n'
    changed = load_scene(written(text))
    assert list(changed.expect) == ["lift_off_count"]
    assert "first_lift_off" in changed.unchecked


def test_what_is_set_from_outside_leaves_what_is_expected() -> None:
    everything = load_scene("ap57").expect
    assert load_scene("ap57", ["speed=10"]).expect == everything
    changed = load_scene("ap57", ["speed=10", "expect.lift_off_count=0"]).expect
    assert changed.keys() == everything.keys()
    assert changed["lift_off_count"].max == 0.0


def test_what_is_expected_can_be_left_out_but_for_what_is_set() -> None:
    bare = load_scene("ap57", ["speed=10"], expect=False)
    assert bare.expect == {}
    assert set(bare.unchecked) == set(load_scene("ap57").expect)
    own = load_scene("ap57", ["expect.lift_off_count=0"], expect=False)
    assert list(own.expect) == ["lift_off_count"]


def test_an_expectation_that_another_model_cannot_meet_says_how_to_leave_it() -> None:
    file = written(MINIMAL + "expect.lift_off_count = 0\n")
    message = refusal(file, "fmu=OneDof")
    assert "no measure 'lift_off_count'" in message
    assert message.endswith("--no-expect skips the expectations of the scene")
    assert load_scene(file, ["fmu=OneDof"], expect=False).expect == {}


@pytest.mark.parametrize(
    ("text", "overrides", "idle"),
    [
        ('road.shape = "bump"', (), []),
        ('bump_stop.gap = "4 cm"', (), ["bump_stop.gap"]),
        ('bump_stop.gap = "4 cm"\nbump_stop.stiffness = 1e5', (), []),
        ('damper.table = "-1:-1, 0:0, 1:1"\ndamper.bump_rate = 9', (), ["damper.bump_rate"]),
        ('road.shape = "random"\nroad.seed = 2', (), []),
        ("damper = { bump_limit = 0, limit_slope = 0 }", (), []),
        # what is put in another's place from outside is not held against the file
        ('road.height = "4 cm"', ("road.shape=random",), []),
        ("damper.bump_rate = 9", ("damper.table=-1:-1, 0:0, 1:1",), []),
        # but what is set there must act
        ('road.height = "4 cm"', ("road.class=F",), ["road.class"]),
        ('road.height = "4 cm"', ("road.shape=random", "road.height=3"), ["road.height"]),
        ('road.height = "4 cm"', ("road.height=3", "road.shape=random"), ["road.height"]),
    ],
)
def test_what_is_given_but_has_no_effect(
    text: str, overrides: tuple[str, ...], idle: list[str]
) -> None:
    scene = load_scene(written(f"{MINIMAL}\n[parameters]\n{text}\n"), overrides)
    assert [found.name for found in scene.idle] == idle
    given = "\n".join(
        f"{key} = {value if value[0].isdigit() else repr(value)}"
        for key, value in (o.split("=") for o in overrides)
    )
    over = load_scene(written(f'extends = "scene.toml"\n[parameters]\n{given}\n', "over.toml"))
    assert [found.name for found in over.idle] == idle


def test_a_table_in_a_file_takes_the_place_of_a_rate() -> None:
    written("v,F\n-1,-500\n0,0\n1,900\n", "damper.csv")
    damper = 'damper = { bump_rate = 9, table = { file = "damper.csv", columns = ["v", "F"] } }'
    scene = load_scene(written(f"{MINIMAL}\n[parameters]\n{damper}\n"))
    assert scene.warnings == ["damper.bump_rate has no effect on the motion: damper.table is given"]


def test_bounds_take_units_and_exclude_what_was_not_measured() -> None:
    scene = load_scene("ap57", ['expect={peak={body_displacement={min="-2 cm", max=0.5}}}'])
    bounds = scene.expect["peak.body_displacement"]
    assert (bounds.min, bounds.max) == (-0.02, 0.5)
    assert bounds.hold(-0.02)
    assert not bounds.hold(-0.0201)
    assert not bounds.hold(0.51)
    assert not bounds.hold(None)


def test_the_scene_has_the_keys_that_its_file_may_have() -> None:
    assert set(KEYS) - {"extends"} == {field.name for field in fields(Scene)} - {
        "name", "file", "unchecked", "idle", "during", "reference",
    }  # fmt: skip


def test_choices_are_those_of_the_packages_that_draw() -> None:
    from phaseplane import constructions, figures, recording  # noqa: PLC0415

    assert set(RULES) == set(constructions.RULES)
    assert DETAILS == recording.DETAILS
    assert set(FIGURES) <= set(figures.__all__)


# -- files ---------------------------------------------------------------------------------------


def test_extends_relative_to_its_own_file() -> None:
    Path("sub").mkdir()
    written(MINIMAL + "[parameters]\nspeed = 5\ngravity = 9.0\n", "base.toml")
    path = written('extends = "../base.toml"\n[parameters]\nspeed = 6\n', "sub/derived.toml")
    scene = load_scene(path)
    assert scene.parameters == {"speed": 6.0, "gravity": 9.0}
    assert scene.name == "derived"


def test_ring_of_extends() -> None:
    written('extends = "b.toml"\n', "a.toml")
    written('extends = "./a.toml"\n', "b.toml")
    assert "the scenes extend each other in a circle" in refusal("a.toml")


def test_an_error_names_the_file_that_made_it() -> None:
    written(MINIMAL + "[parameters]\nspeed = -5\ngravity = -9\n", "base.toml")
    derived = written('extends = "base.toml"\n[parameters]\nspeed = 5\n', "top.toml")
    message = refusal(derived)
    assert message.startswith("base.toml")
    assert "gravity = -9: must be at least 0 m/s2" in message
    assert refusal(derived, "gravity=-8").startswith("--set: gravity = -8")


@pytest.mark.parametrize(
    ("reference", "words"),
    [
        ("ap75", ["no scene 'ap75'", "did you mean 'ap57'?", "phaseplane list"]),
        ("nowhere/x.toml", ["no scene file nowhere/x.toml"]),
        ("", ["is a folder"]),
        ("a\0b", ["no scene"]),
    ],
)
def test_no_such_scene(reference: str, words: list[str]) -> None:
    message = refusal(reference)
    assert all(word in message for word in words)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"fmu = QuarterCar", "not TOML"),
        (b"\xff\xfe", "not UTF-8 text (byte 0); save it as UTF-8"),
        (b"x = " + b"[" * 5000, "nested too deeply"),
        (b"x = " + b"9" * 5000, "not TOML"),
        (b"", "'fmu' is missing; a scene needs fmu and duration, or extends another"),
        (b'fmu = "QuarterCar"', "'duration' is missing"),
    ],
)
def test_unreadable_file(content: bytes, words: str) -> None:
    Path("bad.toml").write_bytes(content)
    message = refusal("bad.toml")
    assert "bad.toml" in message
    assert words in message


def test_a_file_in_utf_8_may_begin_with_a_mark() -> None:
    """As editors on Windows write it; so may the file of a system, and of a sweep."""
    system = (
        '[system]\nname = "Ball"\n[system.coordinates]\nheight = { mass = 2 }\n'
        "[system.elements.spring]\ndirection = { height = 1 }\nspring = { rate = 100 }\n"
    )
    files = {"ball": f'duration = "1 s"\n{system}', "sweep": 'scene = "ball.toml"\n'}
    for name, text in files.items():
        Path(f"{name}.toml").write_text(text, encoding="utf-8-sig")
    assert load_scene("ball.toml").duration == 1.0
    assert read_content(Path("sweep.toml")) == {"scene": "ball.toml"}


# -- what a scene refuses: key, value, what is allowed, nearest name -----------------------------


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("sprung_mass=-3", ["sprung_mass = -3", "greater than 0 kg"]),
        ("gravity=nan", ["gravity = nan", "at least 0 m/s2"]),
        ("spring.rate=5 cm", ["spring.rate = '5 cm'", "'cm' does not fit", "N/mm"]),
        ("spring.rate=stiff", ["spring.rate = 'stiff'", "1.5 N/m"]),
        ("sping.rate=5", ["QuarterCar", "'sping.rate'", "did you mean 'spring.rate'?"]),
        ("spring.rate=" + "9" * 400, ["spring.rate", "too large"]),
        ("spring.table=0:0", ["spring.table", "at least two points"]),
        ("lift_off=1", ["lift_off = 1", "true or false"]),
        ("road.shape=bmp", ["road.shape = 'bmp'", "flat, bump", "did you mean 'bump'?"]),
        ("road.shape=input", ["road.shape = 'input'", "road.table"]),
        ("duration=1 N", ["duration = '1 N'", "'N' does not fit", "ms"]),
        ("duration=0", ["duration = 0: must be greater than 0 s"]),
        ("duration=inf", ["duration = inf: must be finite and greater than 0 s"]),
        ("speed=inf", ["speed = inf: must be finite and greater than 0 m/s"]),
        ("duration=true", ["duration = True", "a number in s"]),
        ("fmu=Quartercar", ["fmu = 'Quartercar'", "did you mean 'QuarterCar'?"]),
        ("fmu=gone.fmu", ["fmu = 'gone.fmu'", "no such file"]),
        ("title=3", ["title = 3", "must be a string"]),
        ("show=3", ["show = 3", "table"]),
        ("parameters=3", ["parameters = 3", "table"]),
        ("show.figure=[]", ["'show.figure'", "did you mean 'figures'?", "recording"]),
        ("show.figures=['phase_plane']", ["'phase_plane'", "did you mean 'phase_planes'?"]),
        ("show.recording=maybe", ["show.recording = 'maybe'", "trail, steps, stages"]),
        ("show.outputs=['body_displacment']", ["did you mean 'body_displacement'?"]),
        ("show.outputs=body", ["show.outputs = 'body'", '"all"']),
        ("show.planes='a,b'", ['a list of pairs of outputs, such as ["suspension_deflection, ']),
        ("show.planes=['a']", ['must be two outputs, such as "suspension_deflection, ']),
        ("show.output_interval=2", ["show.output_interval = 2 s is longer than the duration, 1 s"]),
        ("show.output_interval=1e-9", ["show.output_interval = 1e-09", "rows", "at least"]),
        ("construction.step=1e-7", ["construction.step = 1e-07", "steps"]),
        ("construction.rule=detla", ["'detla'", "osculating_circle", "did you mean 'delta'?"]),
        ("construction.plane_scales=[1]", ["plane_scales = [1]", "two numbers"]),
        ("construction.starts=[[1, 1" + "0" * 400 + "]]", ["starts", "must be a finite number"]),
        ("expect.lift_of_count=1", ["'lift_of_count'", "did you mean 'lift_off_count'?"]),
        ("expect.airborne_time=1", ["expect.airborne_time = 1", "min and/or max in s"]),
        ("expect.airborne_time={min='1 N'}", ["expect.airborne_time", "'N' does not fit"]),
        ("expect.airborne_time={most=3}", ["'most' is unknown; must be min and/or max"]),
        ("expect.lift_off_count={min=3, max=1}", ["min is above max"]),
        ("extends=ap57", ["extends", "only a scene's file"]),
        ("expect={}", ["expect={}", "an empty table sets nothing", "--no-expect"]),
        ("show={}", ["show={}", "give at least one key"]),
        ("speed", ["'speed'", "key=value"]),
    ],
)
def test_refused_override(override: str, words: list[str]) -> None:
    message = refusal("ap57", override)
    assert message.startswith("--set")
    assert all(word in message for word in words), message


def test_a_method_that_cannot_integrate_the_system() -> None:
    """The run was begun, failed with two lines, and `accuracy` reported a failed call into the FMU."""
    message = refusal("ap57", "solver.method=exact", "spring.cubic=1e5")
    assert message == (
        "--set: solver.method = exact cannot integrate this system: the spring of 'spring' is curved; "
        "use extrapolated"
    )
    assert load_scene("ap57", ["solver.method=exact"]).parameters["solver.method"] == "exact"


@pytest.mark.parametrize("line", ["expect.lift_off_count", "parameters.spring", "show.look"])
def test_an_empty_table_within_a_table(line: str) -> None:
    assert f"{line} = {{}}: an empty table sets nothing" in refusal(
        written(f"{MINIMAL}{line} = {{}}")
    )


@pytest.mark.parametrize(
    ("line", "words"),
    [("[shwo]", "unknown key 'shwo'.* did you mean 'show'"), ("source = {}", "must be a string")],
)
def test_an_empty_table_that_is_no_section(line: str, words: str) -> None:
    assert re.search(words, refusal(written(f"{MINIMAL}{line}\n")))


@pytest.mark.parametrize(
    ("table", "meant"),
    [("[shwo]\ndark = true", "show"), ("[expected]\nlift_off_count = 1", "expect"),
     ("[paramters]\nspeed = 9.0", "parameters")],
)  # fmt: skip
def test_a_misspelt_section_is_compared_without_its_keys(table: str, meant: str) -> None:
    assert refusal(written(f"{MINIMAL}{table}\n")).endswith(f"; did you mean '{meant}'?")


def test_an_empty_table_at_the_top_is_a_heading_without_keys() -> None:
    loaded = load_scene(written(MINIMAL + "[expect]\n[parameters]\n"))
    assert not loaded.expect


def test_unknown_key_at_the_top() -> None:
    path = written(MINIMAL + 'durration = "1 s"\n')
    message = refusal(path)
    assert all(word in message for word in (path, "'durration'", "did you mean 'duration'?"))


@pytest.mark.parametrize("line", ["sprung_mass = 300", "road.height = 1", 'equation = "x"'])
def test_a_parameter_at_the_top_is_recognised(line: str) -> None:
    message = refusal(written(MINIMAL + f"{line}\n"))
    assert message.endswith("; parameters belong in the table [parameters]")


def test_settings_of_a_construction_again() -> None:
    kept = asdict(Construction())
    assert construction_settings(kept, ["construction.rule=tangent"])["rule"] == "tangent"
    for text, words in (
        ("spring.rate=3", r"only construction\.\*"),
        ("construction.x=1", r"unknown key .construction\.x"),
    ):
        with pytest.raises(InputError, match=f"--set.*{words}"):
            construction_settings(kept, [text])


# -- anything at all -----------------------------------------------------------------------------


@settings(max_examples=150)
@given(
    key=st.sampled_from([
        "duration", "fmu", "title", "source", "speed", "spring.rate", "spring.table", "lift_off",
        "road.table", "show.figures", "show.outputs", "show.recording", "show.output_interval",
        "construction.rule", "construction.step", "construction.plane_scales", "expect",
        "expect.lift_off_count", "expect.peak.body_displacement", "parameters", "show", "",
    ]),
    value=st.one_of(
        st.text(max_size=12),
        st.integers().map(str),
        st.floats().map(str),
        st.lists(st.integers() | st.text(max_size=3), max_size=3).map(str),
        st.sampled_from(["{}", "{min=1}", "{a.b.c=1}", "9" * 400, "{min=" + "9" * 400 + "}"]),
    ),
)  # fmt: skip
def test_any_override_is_taken_or_refused_in_one_line(key: str, value: str) -> None:
    said = ""
    try:
        load_scene("ap57", [f"{key}={value}"])
    except InputError as error:
        said = str(error)
    assert said.isprintable()


@pytest.mark.parametrize("value", [[], {}, 3, None])
def test_what_is_no_text_is_none_of_the_choices(value: object) -> None:
    kind = one_of({"delta": "by Jacobsen's delta", "tangent": "by tangents"})
    with pytest.raises(ValueError, match="must be one of delta, tangent"):
        kind.read(value)
