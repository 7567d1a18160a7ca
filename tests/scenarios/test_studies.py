"""What optima and fits have in common: ranges, settings, files, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, written
from command_line import phaseplane as phaseplane_command
from phaseplane.scenarios.design.space import Space, journaled
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.loading import load_scene
from studied_car import CAR, SEARCH, SHORT, study

import phaseplane

pytestmark = pytest.mark.usefixtures("studied_car")


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
def test_a_study_does_not_replace_the_scene_that_it_starts_from():
    scene = phaseplane.optimise(study(SHORT)).folder / "scene.toml"
    text = scene.read_text()
    with pytest.raises(InputError, match=r"scene\.toml: is within out"):
        phaseplane.optimise(written(f'scene = "{scene}"\n{SHORT}', "study.toml"))
    assert scene.read_text() == text


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
    ("command", "wanted"),
    [("optimise", 'minimise = "rms.body_acceleration"'), ("fit", '[measured]\nfile = "rig.csv"')],
)
def test_a_parameter_that_a_table_replaces_is_not_sought(command, wanted):
    written(CAR + 'damper.table = "-1:-1400, 0:0, 1:2100"\n', "car.toml")
    sought = "[vary]\ndamper.rebound_rate = { from = 300, to = 6000 }\n"
    reason = "vary.damper.rebound_rate has no effect on the motion: damper.table is given"
    assert reason in complaint(command, study(f"{wanted}\n{sought}"))
