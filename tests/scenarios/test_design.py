"""Design studies: optima within bounds, trade-offs, and fits to measured signals."""

from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, written
from command_line import phaseplane as phaseplane_command
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.scenarios.design.job import _scene
from phaseplane.scenarios.design.optimum import read_problem, solve, undominated
from phaseplane.scenarios.design.space import Space, journaled
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.folder import read_summary
from phaseplane.scenarios.results.signals import read_signals
from phaseplane.scenarios.scene.loading import load_scene

import phaseplane
from phaseplane import figures

CAR = """
fmu = "QuarterCar"
duration = "0.6 s"
[parameters]
road.height = "2 cm"
"""
SEARCH = "[search]\npopulation = 4\ngenerations = 6\ntrade_offs = 4\n"


BOTH_RATES = (
    "damper = { rebound_rate = { from = 300, to = 6000 }, bump_rate = { from = 300, to = 6000 } }\n"
)


@pytest.fixture(autouse=True)
def _car():
    written(CAR, "car.toml")


def study(text):
    return written(f'scene = "car.toml"\n{text}', "study.toml")


SHORT = (
    'minimise = "rms.body_displacement"\n[vary]\nspeed = { from = 5, to = 10 }\n'
    "[search]\npopulation = 1\ngenerations = 0\n"
)


@pytest.mark.parametrize(
    ("part", "told", "left"),
    [
        ("phaseplane.figures.save", "study: study.png was not drawn: no ink", True),
        (
            "phaseplane.scenarios.design.job.write_table",
            "cannot write out/studies/study: no ink",
            False,
        ),
    ],
)
def test_a_picture_that_fails_costs_itself_alone_and_a_table_everything(
    part, told, left, monkeypatch
):
    def fail(*_, **__):
        raise OSError("no ink")

    with monkeypatch.context() as patch:
        patch.setattr(part, fail)
        assert told in phaseplane_command("optimise", study(SHORT)).stderr
    assert Path("out/studies/study/runs.csv").exists() == left
    assert (phaseplane.optimise("study.toml").summary["made"] > 0) == left  # runs are not lost
    assert [path.name for path in Path("out/studies").iterdir()] == ["study"]


@pytest.mark.slow
def test_the_stiffness_of_least_settling_time_is_that_of_a_scan():
    found = phaseplane.optimise(
        study('minimise = "rms.body_displacement"\n[vary]\n'
              "damper.rebound_rate = { from = 100, to = 8000 }\n" + SEARCH)
    )  # fmt: skip
    scan = np.linspace(100, 8000, 80)
    costs = [
        phaseplane.run(
            "car.toml", {"damper.rebound_rate": x}, measures=["rms.body_displacement"]
        ).measures["rms.body_displacement"]
        for x in scan
    ]
    assert found.summary["measures"]["rms.body_displacement"]["found"] <= min(costs) * (1 + 1e-6)
    again = phaseplane.run(found.folder / "scene.toml", measures=["rms.body_displacement"])
    value = found.summary["measures"]["rms.body_displacement"]["found"]
    assert again.measures["rms.body_displacement"] == pytest.approx(value, rel=1e-9)


@pytest.mark.slow
def test_bounds_are_kept_and_the_trade_off_falls():
    found = phaseplane.optimise(study(
        'minimise = "rms.body_acceleration"\nagainst = "dynamic_load_coefficient"\n[vary]\n'
        f"{BOTH_RATES}"
        "[constrain]\nsuspension_travel = { max = '35 mm' }\n" + SEARCH
    ), progress=(seen := []).append)  # fmt: skip
    assert found.summary["feasible"]
    assert seen == sorted(seen)
    assert seen.index(1.0) == len(seen) - 1
    assert found.summary["measures"]["suspension_travel"]["found"] <= 0.035 * (1 + 1e-6)
    pairs = [
        (row["rms.body_acceleration"], row["dynamic_load_coefficient"])
        for row in found.summary["trade_off"]
    ]
    assert len(pairs) >= 2
    assert pairs == sorted(pairs)
    assert [b for _, b in pairs] == sorted((b for _, b in pairs), reverse=True)
    assert {"runs.csv", "scene.toml", "study.png", "summary.json"} == set(found.summary["files"])


def test_a_bound_on_a_peak_is_one_on_its_magnitude():
    problem = read_problem(Path(study(
        'minimise = "suspension_travel"\n[vary]\ndamper.rebound_rate = { from = 300, to = 6000 }\n'
        "[constrain]\npeak.body_acceleration = { min = 2, max = 4 }\n"
    )))  # fmt: skip
    assert problem.measures == ("suspension_travel", "peak.body_acceleration")
    broken = problem.violations(np.array([[0.1, -5.0], [0.1, 3.0], [0.1, 1.0]]))
    np.testing.assert_allclose(broken, [[-1.5, 0.25], [-0.5, -0.25], [0.5, -0.75]])


@pytest.mark.parametrize(("most", "kept"), [(15, False), (40, True)])
def test_the_scene_found_has_the_road_of_the_study(most, kept):
    """A random road depends on its length, which all runs of a study share."""
    written(
        'fmu = "QuarterCar"\nduration = "12 s"\n[parameters]\nroad.shape = "random"\n', "car.toml"
    )
    space = read_problem(Path(study(
        f'minimise = "suspension_travel"\n[vary]\nspeed = {{ from = 10, to = {most} }}\n'
    ))).space  # fmt: skip
    written(_scene(space, {"speed": 12.0}, Path()), "found.toml")
    found = load_scene("found.toml")
    assert ("road.profile_length" in found.parameters) is kept
    assert found.all_parameters["road.profile_length"] == space.plan.road_length


@pytest.mark.slow
def test_a_trade_off_of_peaks_is_one_of_their_magnitudes():
    """Along this one, the largest acceleration changes its direction."""
    found = phaseplane.optimise(study(
        'minimise = "suspension_travel"\nagainst = "peak.body_acceleration"\n[vary]\n'
        f"{BOTH_RATES}"
        + SEARCH.replace("trade_offs = 4", "trade_offs = 7")
    ))  # fmt: skip
    peaks = [row["peak.body_acceleration"] for row in found.summary["trade_off"]]
    assert min(peaks) < 0.0
    sizes = np.abs(peaks)
    assert (np.diff(sizes) < 0.0).all()
    assert np.abs(np.diff(sizes)).max() < 0.4 * np.ptp(sizes)


def test_the_best_run_is_found_wherever_the_search_meets_it(monkeypatch):
    """The second measure is least in a dip of the first that the search for the first has missed."""

    def measured(plan):
        for (speed,) in plan.points:
            yield 0.0 if abs(speed - 18.3) < 0.01 else 1.0 + (speed - 8.0) ** 2, (speed - 18.3) ** 2

    monkeypatch.setattr("phaseplane.scenarios.design.optimum._measures_of", measured)
    problem = read_problem(Path(study(
        "minimise = 'rms.body_acceleration'\nagainst = 'suspension_travel'\n[vary]\n"
        "speed = { from = 5, to = 20 }\n[search]\npopulation = 1\ngenerations = 0\n"
    )))  # fmt: skip
    found = solve(problem, Path("journal"))
    assert found.numbers[0] == found.front[1][0, 0] == 0.0


@pytest.mark.slow
def test_no_run_lies_beyond_the_trade_off_that_is_drawn(monkeypatch):
    drawn = {}
    plain = figures.pareto
    monkeypatch.setattr(
        figures, "pareto", lambda *of, **more: drawn.update(more) or plain(*of, **more)
    )
    found = phaseplane.optimise(study(
        'minimise = "rms.body_acceleration"\nagainst = "dynamic_load_coefficient"\n[vary]\n'
        f"{BOTH_RATES}"
        + SEARCH
    ))  # fmt: skip
    runs = phaseplane.read(found.folder / "runs.csv")
    x, y = drawn["front"]
    assert len(x) >= len(found.summary["trade_off"])
    for a, b in zip(runs["rms.body_acceleration"], runs["dynamic_load_coefficient"], strict=True):
        assert not ((a < x - 1e-12) & (b < y - 1e-12)).any()
    assert (np.diff(x) > 0).all()
    assert (np.diff(y) < 0).all()


@pytest.mark.slow
def test_a_peak_is_drawn_with_its_magnitude(monkeypatch):
    drawn, name = {}, "peak.suspension_deflection"
    plain = figures.sweep
    monkeypatch.setattr(
        figures, "sweep", lambda *of, **more: drawn.update(of[1]) or plain(*of, **more)
    )
    found = phaseplane.optimise(study(SHORT.replace("rms.body_displacement", name)))
    peaks = phaseplane.read(found.folder / "runs.csv")[name]
    assert (peaks < 0.0).all()
    unit, values = drawn[f"magnitude of {name}"]
    assert (unit, values) == ("mm", (-1e3 * peaks).tolist())


@pytest.mark.slow
def test_a_study_does_not_replace_the_scene_that_it_starts_from():
    scene = phaseplane.optimise(study(SHORT)).folder / "scene.toml"
    text = scene.read_text()
    with pytest.raises(InputError, match=r"scene\.toml: is within out"):
        phaseplane.optimise(written(f'scene = "{scene}"\n{SHORT}', "study.toml"))
    assert scene.read_text() == text


@pytest.mark.parametrize(
    ("bounds", "least"), [("", 0), ("[constrain]\nsuspension_travel = { max = '1 cm' }\n", 2)]
)
def test_a_run_that_lacks_a_measure_is_not_the_best(bounds, least):
    """Least accelerated is the car that does not lift off, which has no time at which it does.

    It alone keeps the bound; the others violate it the less, the less they travel.
    """
    problem = read_problem(Path(study(
        "minimise = 'rms.body_acceleration'\nagainst = 'first_lift_off'\n[vary]\n"
        f"road.height = {{ from = 0.01, to = 0.06 }}\n{bounds}"
        "[search]\npopulation = 5\ngenerations = 1\ntrade_offs = 0\n"
    )))  # fmt: skip
    found = solve(problem, Path("journal"))
    assert np.isfinite(found.numbers).all()
    lacking = np.isnan(found.measured).any(axis=1)
    assert lacking.any()
    assert found.numbers[least] == found.measured[~lacking, least].min()


@pytest.mark.slow
def test_what_cannot_be_met_is_said():
    name = study('minimise = "rms.body_acceleration"\n[vary]\n'
                 "damper.rebound_rate = { from = 300, to = 6000 }\n"
                 "[constrain]\nsuspension_travel = { max = '1 mm' }\n" + SEARCH)  # fmt: skip
    told = phaseplane_command("optimise", name)
    assert told.exit_code == 1
    assert "no point satisfies all bounds" in told.output


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=30))
def test_the_front_is_what_nothing_beats(pairs):
    costs = np.array(pairs, float)
    front = {tuple(costs[k]) for k in undominated(costs)}
    beaten = {
        tuple(a) for a in costs
        if any((b <= a).all() and (b < a).any() for b in costs)
    }  # fmt: skip
    assert front == {tuple(a) for a in costs} - beaten


def test_a_study_that_is_interrupted_repeats_no_run():
    content = {"scene": "car.toml", "vary": {"speed": {"from": 5, "to": 20}}}
    space = Space.read(
        Path("study.toml"), content, load_scene("car.toml"), {"step_count": "measure"}
    )
    made = []

    def make(plan):
        made.extend(plan.points)
        return [(x,) for (x,) in plan.points]

    def interrupted():
        with journaled(space, make, Path("journal"), "said", [1]) as runs:
            runs.at(np.array([[0.0], [1.0]]))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="after 2 runs; start it again"):
        interrupted()
    with journaled(space, make, Path("journal"), "said", [1]) as runs:
        assert runs.at(np.array([[1.0], [0.5]])).tolist() == [[20.0], [12.5]]
    assert made == [(5.0,), (20.0,), (12.5,)]


def interrupted_after(calls):
    """Return a progress that is interrupted at one of its calls."""
    left = iter(range(calls))

    def progress(_):
        if next(left, None) is None:
            raise KeyboardInterrupt

    return progress


@pytest.mark.slow
def test_a_search_that_was_interrupted_ends_where_another_does():
    name = study(
        'minimise = "rms.body_acceleration"\nagainst = "dynamic_load_coefficient"\n[vary]\n'
        "damper.rebound_rate = { from = 300, to = 6000 }\n[constrain]\n"
        "suspension_travel = { max = '40 mm' }\n" + SEARCH
    )
    whole = phaseplane.optimise(name)
    table = (whole.folder / "runs.csv").read_bytes()
    with pytest.raises(KeyboardInterrupt):
        phaseplane.optimise(name, progress=interrupted_after(3))
    again = phaseplane.optimise(name)
    assert again.summary["made"] < whole.summary["made"]
    assert again.values == whole.values
    assert again.summary["trade_off"] == whole.summary["trade_off"]
    assert (again.folder / "runs.csv").read_bytes() == table


TRUE = {"damper.rebound_rate": 1500.0, "damper.bump_rate": 700.0}


def measured(noise):
    shown = ["body_acceleration", "ground_elevation"]
    run = phaseplane.run("car.toml", TRUE, output_interval=2e-3, outputs=shown)
    random = np.random.default_rng(7)
    lines = ["# rig", "t;acc_z;road", "[ms];[g];[m]"]
    for time, a, road in zip(
        run.time, run["body_acceleration"], run["ground_elevation"], strict=True
    ):
        row = (1e3 * time + 20.0, a / 9.80665 + 0.05 + noise * random.normal(), road)
        lines.append(";".join(f"{x:.9g}".replace(".", ",") for x in row))
    written("\n".join(lines), "rig.csv")


FIT = """
[vary]
damper.rebound_rate = { from = 300, to = 5000 }
damper.bump_rate = { from = 300, to = 5000 }
[measured]
file = "rig.csv"
time = "t"
time_shift = "-20 ms"
columns = { body_acceleration = "acc_z" }
offset = { body_acceleration = "-0.05 g" }
delimiter = ";"
decimal = ","
"""


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_fit_finds_the_parameters_within_its_confidence(noise):
    measured(noise)
    found = phaseplane.fit_parameters(study(FIT))
    for key, value in TRUE.items():
        width = found.summary["half_widths"][key]
        assert found.values[key] == pytest.approx(value, abs=max(width, 0.1))
        assert width < (1e-2 if noise == 0.0 else 200.0)
    assert found.summary["residual"]["body_acceleration"] < (1e-6 if noise == 0.0 else 0.5)
    assert read_summary(found.folder)["values"] == found.values
    assert found.summary["samples"] == 301


def test_intervals_are_those_of_each_signals_own_noise():
    """An exact signal that depends on no parameter tells nothing of them."""
    measured(0.02)
    alone = phaseplane.fit_parameters(study(FIT)).summary["half_widths"]
    beside = FIT.replace('"acc_z" }', '"acc_z", ground_elevation = "road" }')
    found = phaseplane.fit_parameters(study(beside)).summary["half_widths"]
    assert found == pytest.approx(alone, rel=5e-3)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ("00000", "body_acceleration: its samples are all 0, or too large"),
        (["1e200"] * 5, "body_acceleration: its samples are all 0, or too large"),
        (
            "12",
            "2 samples within 0 and 0.6 s of the scene; a fit needs more samples than parameters",
        ),
    ],
)
def test_signals_to_which_nothing_can_be_fitted_are_refused(values, words):
    rows = "".join(f"{20 + t};{value}\n" for t, value in enumerate(values))
    Path("rig.csv").write_text(f"t;acc_z\nms;m/s2\n{rows}")
    text = FIT.replace('offset = { body_acceleration = "-0.05 g" }\n', "")
    with pytest.raises(InputError, match=words):
        phaseplane.fit_parameters(study(text))


def test_an_equation_is_not_fitted():
    text = study(
        "[vary]\ndisplacement_start = { from = 0, to = 1 }\n[measured]\nfile = 'rig.csv'\n"
    )
    Path(text).write_text(Path(text).read_text().replace("car.toml", "van_der_pol"))
    with pytest.raises(InputError, match="scene: only models of this package can be fitted"):
        phaseplane.fit_parameters(text)


def test_parameters_that_do_the_same_are_said_to_be_alike():
    measured(0.02)
    text = FIT.replace("damper.bump_rate = { from = 300, to = 5000 }",
                       "damper.scale = { from = 0.5, to = 2.0 }\n"
                       "damper.bump_rate = { from = 300, to = 5000 }")  # fmt: skip
    found = phaseplane.fit_parameters(study(text))
    assert "hardly distinguish" in found.report


def test_a_parameter_that_the_signals_do_not_depend_on_is_said_to_be_unknown():
    """An end stop that is never reached: an interval of zero would say that its gap is exact."""
    measured(0.0)
    text = FIT.replace(
        "damper.bump_rate = {", "bump_stop.gap = { from = 0.2, to = 0.4 }\ndamper.bump_rate = {"
    )
    Path("car.toml").write_text(CAR + "bump_stop = { gap = 0.3, stiffness = 1e5 }\n")
    found = phaseplane.fit_parameters(study(text))
    assert read_summary(found.folder)["half_widths"]["bump_stop.gap"] is None
    (row,) = [line for line in found.report.splitlines() if line.startswith("bump_stop.gap  ")]
    assert row.endswith("  not known")
    assert "bump_stop.gap is not known: the signals do not depend on it" in found.report


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("minimise = 'rms.body'", "minimise: no measure 'rms.body'"),
        ("minimise = 3", "minimise = 3: must be the name of a measure"),
        ("minimize = 'rms.body_velocity'", "did you mean 'minimise'"),
        ("", "give one of minimise and maximise"),
        (
            "minimise = 'suspension_travel'\n[constrain]\nsuspension_travel = { max = '3 kg' }",
            "'kg'",
        ),
        ("minimise = 'suspension_travel'\n[search]\nseeds = 3", "did you mean 'seed'"),
        (
            "minimise = 'suspension_travel'\n[constrain]\npeak.body_velocity = { min = -1 }",
            "constrain.peak.body_velocity: the magnitude of a peak counts",
        ),
        (
            "minimise = 'suspension_travel'\n[constrain]\nsuspension_travel = { mim = 3 }",
            "constrain: suspension_travel: 'mim' is unknown; must be min and/or max",
        ),
        (
            "minimise = 'suspension_travel'\n[constrain]\nsuspension_travel = {}",
            "constrain.suspension_travel: must be min and/or max in m",
        ),
    ],
)
def test_a_study_that_is_not_understood_is_refused(text, words):
    lines = text.split("\n")
    name = study(f"{lines[0]}\n[vary]\nspeed = {{ from = 5, to = 9 }}\n" + "\n".join(lines[1:]))
    with pytest.raises(InputError, match=words):
        phaseplane.optimise(name)


def test_a_measure_is_not_traded_off_against_itself():
    text = "minimise = 'suspension_travel'\nagainst = 'suspension_travel'\n[vary]\nspeed = {from=5, to=9}"
    with pytest.raises(
        InputError, match="against = 'suspension_travel' is the measure to be optimised"
    ):
        phaseplane.optimise(study(text))


@pytest.mark.parametrize(
    ("vary", "words"),
    [("speed = 3", "from = ..., to = ..."),
     ("speed = { from = 9, to = 5 }", "from = 9.0 must be below to = 5.0"),
     ("sped = { from = 1, to = 2 }", "did you mean 'speed'"),
     ("duration = { from = 1, to = 2 }", "only parameters"),
     ("road.seed = { from = 1, to = 5 }", "road.seed: takes whole numbers only, .* use a sweep"),
     ("road.shape = { from = 1, to = 2 }", "road.shape")],
)  # fmt: skip
def test_ranges_that_are_none_are_refused(vary, words):
    with pytest.raises(InputError, match=words):
        phaseplane.optimise(study(f'minimise = "suspension_travel"\n[vary]\n{vary}\n'))


def test_every_measure_is_refused_by_the_key_that_names_it():
    vary = "[vary]\nspeed = { from = 1, to = 5 }\n"
    with pytest.raises(InputError, match=r"against: no measure 'rms\.body'"):
        phaseplane.optimise(study(f"minimise = 'suspension_travel'\nagainst = 'rms.body'\n{vary}"))
    with pytest.raises(InputError, match=r"constrain: no measure 'rms\.body'"):
        phaseplane.optimise(
            study(f"minimise = 'suspension_travel'\n{vary}[constrain]\n'rms.body' = {{ max = 1 }}")
        )


@pytest.mark.parametrize(
    ("search", "words"),
    [
        ("search = 3", "search = 3: must be a table"),
        (
            "[search]\ngenerations = -3",
            r"search.generations = -3: must be a whole number greater than or equal to 0",
        ),
        ("[search]\npopulation = 0", "search.population = 0: must be a whole number greater than"),
        ("[search]\ngeneration = 3", "did you mean 'generations'"),
    ],
)
def test_settings_of_a_search_are_refused_with_their_limit(search, words):
    text = 'minimise = "suspension_travel"\n{}\n[vary]\nspeed = {{ from = 1, to = 5 }}\n{}\n'
    table = search.startswith("[")
    with pytest.raises(InputError, match=words):
        phaseplane.optimise(study(text.format(*(("", search) if table else (search, "")))))


@pytest.mark.slow
def test_a_search_without_a_terminal_prints_its_report_alone():
    name = study('minimise = "suspension_travel"\n[vary]\nspeed = { from = 1, to = 5 }\n' + SEARCH)
    told = phaseplane_command("optimise", name)
    assert told.exit_code == 0, told.output
    assert not told.stderr


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({}, "must be the path of a file"),
        ({"file": "no.csv"}, "cannot read"),
        ({"file": "rig.csv", "columns": {"body_acc": "acc_z"}}, "no output 'body_acc'"),
        ({"file": "rig.csv", "sep": ";"}, "unknown key 'sep'"),
        ({"file": "rig.csv", "columns": 3}, "must be a table"),
        ({"file": "rig.csv", "columns": {"a": ["x"]}}, r"columns.a = \['x'\]: must be a string"),
        ({"file": "rig.csv", "units": {"t": 3}}, "units.t = 3: must be a string"),
        (
            {"file": "rig.csv", "columns": {"body_acceleration": "acc_z"}, "time_shift": 10**400},
            "time_shift = 1000.*: must be a finite number in SI",
        ),
        (
            {
                "file": "rig.csv",
                "columns": {"body_acceleration": "acc_z"},
                "offset": {"body_acceleration": True},
            },
            "offset.body_acceleration = True: must be a finite number in SI or a string with a unit",
        ),
        (
            {"file": "rig.csv", "columns": {"body_acceleration": "acc_z"}, "units": {"acc": "g"}},
            r"units.acc: is not among what is read; did you mean 'acc_z'\?",
        ),
        (
            {
                "file": "rig.csv",
                "columns": {"body_acceleration": "acc_z"},
                "offset": {"body_velocity": 1.0},
            },
            "offset.body_velocity: is not among",
        ),
    ],
)
def test_signals_that_are_not_understood_are_refused(said, words):
    measured(0.0)
    with pytest.raises(InputError, match=words):
        read_signals(said, Path(), {"body_acceleration": "m/s2"})


def test_signals_of_results_need_no_units():
    run = phaseplane.run("car.toml")
    run.write("out")
    found = read_signals({"file": "out/results.csv", "time_shift": 1.0}, Path(), run.units)
    np.testing.assert_allclose(found["time"], run.time + 1.0)
    np.testing.assert_array_equal(found["body_velocity"], run["body_velocity"])


@pytest.mark.parametrize(
    ("command", "wanted"),
    [("optimise", 'minimise = "rms.body_acceleration"'), ("fit", '[measured]\nfile = "rig.csv"')],
)
def test_a_parameter_that_a_table_replaces_is_not_sought(command, wanted):
    written(CAR + 'damper.table = "-1:-1400, 0:0, 1:2100"\n', "car.toml")
    sought = "[vary]\ndamper.rebound_rate = { from = 300, to = 6000 }\n"
    reason = "vary.damper.rebound_rate has no effect on the motion: damper.table is given"
    assert reason in complaint(command, study(f"{wanted}\n{sought}"))


GAP = "bump_stop.gap = { from = 0.5, to = 0.8 }\n"


def test_an_optimum_that_depends_on_no_parameter_is_refused():
    written(CAR + "bump_stop.stiffness = 1e6\n", "car.toml")
    told = phaseplane_command(
        "optimise", study(f'minimise = "rms.body_acceleration"\n[vary]\n{GAP}')
    )
    assert told.exit_code == 1
    assert "no measure depends on bump_stop.gap" in told.output
    assert not any(Path("out/studies").iterdir())


@pytest.mark.slow
def test_runs_that_lack_a_measure_are_counted():
    """A wheel that stays on the low bump has no first lift-off."""
    found = phaseplane.optimise(study(
        'minimise = "first_lift_off"\n[vary]\nroad.height = { from = "5 mm", to = "8 cm" }\n'
        "[search]\npopulation = 4\ngenerations = 0\n"
    ))  # fmt: skip
    runs = phaseplane.read(found.folder / "runs.csv")["first_lift_off"]
    lacking = int(np.isnan(runs).sum())
    assert 0 < lacking < len(runs)
    assert f"{len(runs)} runs, of which {lacking} failed or lack a measure" in found.report
    (row,) = [line for line in found.report.splitlines() if line.startswith("first_lift_off  ")]
    before = found.summary["measures"]["first_lift_off"]["before"]
    assert (row.split()[1] == "none") == np.isnan(before)
    assert "nan" not in found.report


@pytest.mark.slow
def test_a_measure_that_lists_times_is_their_number():
    found = phaseplane.optimise(study(
        'minimise = "lift_offs"\n[vary]\nroad.height = { from = "2 cm", to = "8 cm" }\n'
        "[constrain]\ntouchdowns = 1\n[search]\npopulation = 1\ngenerations = 0\n"
    ))  # fmt: skip
    (row,) = [line for line in found.report.splitlines() if line.startswith("lift_offs  ")]
    assert row.split()[2:] == ["1", "least"]


@pytest.mark.slow
def test_a_scene_outside_the_range_is_not_taken_for_what_was_before():
    found = phaseplane.optimise(study(
        'minimise = "suspension_travel"\n[vary]\nspring.rate = { from = "20 N/mm", to = "30 N/mm" }\n'
        "[search]\npopulation = 1\ngenerations = 0\n"
    ))  # fmt: skip
    assert "spring.rate of the scene, 14.71 N/mm, is outside its range" in found.report


@pytest.mark.slow
def test_a_parameter_without_effect_on_the_optimum_is_named():
    written(CAR + "bump_stop.stiffness = 1e6\n", "car.toml")
    found = phaseplane.optimise(study(
        f'minimise = "rms.body_acceleration"\n[vary]\n{GAP}spring.rate = {{ from = 1e4, to = 3e4 }}\n'
        "[search]\npopulation = 2\ngenerations = 1\n"
    ))  # fmt: skip
    assert found.summary["without_effect"] == ["bump_stop.gap"]
    assert "bump_stop.gap has no effect on the measures" in found.report
