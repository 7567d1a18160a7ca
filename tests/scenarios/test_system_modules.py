"""Systems of one's own as Python modules, of the same form as the models of the package."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from command_line import phaseplane as phaseplane_command
from command_line import printed, written
from phaseplane.scenarios.commands.build import build_models
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.fmus import find_fmu
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.suspension import models

import phaseplane

MODULE = '''"""Two masses on springs, one above the other."""

from phaseplane.suspension.characteristics import linear
from phaseplane.suspension.declared import SOLVER_PARAMETERS, initial
from phaseplane.suspension.model import Model
from phaseplane.suspension.outputs import SOLVER_OUTPUTS, motion
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variable import parameter

VARIABLES = (
    parameter("rate", 800.0, "rate of both springs", "N/m"),
    *initial({"lower": "the lower mass", "upper": "the upper mass"}),
    *SOLVER_PARAMETERS,
    *motion("lower", "the lower mass"),
    *motion("upper", "the upper mass"),
    *SOLVER_OUTPUTS,
)


def system(p):
    spring, none = linear(p["rate"]), linear(0.0)
    return System(
        coordinates=("lower", "upper"),
        mass=((2.0, 0.0), (0.0, 2.0)),
        elements=(
            Element("first", (1.0, 0.0), spring, none),
            Element("second", (-1.0, 1.0), spring, none),
        ),
        signals={},
        scales=(1e-2, 1e-2),
    )


MODEL = Model(summary="Two masses on springs", variables=VARIABLES, system=system)
SCENE = {"duration": "0.5 s", "parameters": {"initial.upper_displacement": "1 cm"}}
'''


@pytest.fixture(autouse=True)
def _of_two_masses():
    written(MODULE, "two_masses.py")


def test_a_module_is_a_scene_and_a_base_of_scenes():
    run = phaseplane.run("two_masses.py", solver={"tolerance": 1e-10})
    golden = np.sqrt(5.0)
    fast, slow = 20.0 * (golden + 1.0) / 2.0, 20.0 * (golden - 1.0) / 2.0
    # the upper mass moves in both modes, whose shapes are (1, +-golden) ratios
    share = 0.5 * (1.0 + 1.0 / golden)
    exact = 0.01 * (share * np.cos(slow * run.time) + (1.0 - share) * np.cos(fast * run.time))
    np.testing.assert_allclose(run["upper_displacement"], exact, atol=1e-9)
    Path("half.toml").write_text('extends = "two_masses.py"\n[parameters]\nrate = "200 N/m"\n')
    Path("named.toml").write_text(
        'fmu = "two_masses.py"\nduration = 0.5\n[parameters]\nrate = 200\n'
        "initial.upper_displacement = 0.01\n"
    )
    runs = [phaseplane.run(name)["upper_displacement"] for name in ("half.toml", "named.toml")]
    np.testing.assert_array_equal(*runs)


def test_a_model_of_the_package_is_a_module_as_it_stands():
    source = Path(models.__file__).with_name("quarter_car.py").read_text(encoding="utf-8")
    Path("my_car.py").write_text(source)
    given = {"duration": 0.2, "road": {"shape": "bump"}}
    own, theirs = phaseplane.run("my_car.py", **given), phaseplane.run("QuarterCar", **given)
    for name, column in theirs.items():
        np.testing.assert_array_equal(column, own[name])


@pytest.mark.slow
def test_its_fmu_gives_the_same_bits():
    (path, *_) = build_models(["two_masses.py"], Path("fmus"))
    ours, theirs = phaseplane.run("two_masses.py"), phaseplane.run(path, duration=0.5)
    for name, column in ours.items():
        np.testing.assert_array_equal(column, theirs[name])


@pytest.mark.slow
def test_commands_take_it():
    fmu = find_fmu("two_masses.py")
    assert pickle.loads(pickle.dumps(fmu)) == fmu
    Path("sweep.toml").write_text(
        'scene = "two_masses.py"\nmeasures = ["lowest_natural_frequency"]\n[vary]\nrate = [200, 800]\n'
    )
    for line in (
        "sweep sweep.toml --workers 2",
        "portrait two_masses.py",
        "modes two_masses.py",
        "schema two_masses.py",
    ):
        printed(line)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("MODEL =", "OTHER =", "there is no MODEL"),
        ('*motion("upper"', 'motion("upper"', r"is not a variable; write \* before"),
        ("def system(p):", "def system(p:", r"line 20: '\(' was never closed"),
        ("import linear,", "import linaer,", "line 3: ImportError"),
        ("MODEL =", "raise SystemExit(3)\nMODEL =", r"line \d+: SystemExit: 3"),
        ('p["rate"]', 'p["raet"]', "line 21: MODEL.variables has no 'raet'"),
        ("return System(", "return dict(", "MODEL.system returned"),
        ("    *SOLVER_OUTPUTS,\n", "", r"add \*SOLVER_OUTPUTS of phaseplane"),
        ('*motion("upper"', '*motion("middle"', "does not provide the output middle_displacement"),
        (
            '*motion("upper", "the upper mass")',
            'replace(motion("upper", "")[0], reading=None)',
            "the output upper_displacement does not say how it is computed; declare it by motion",
        ),
        ('*motion("upper"', '*motion("lower"', "'lower_displacement' would be the name of two"),
        (
            "    *SOLVER_PARAMETERS,",
            '    *SOLVER_PARAMETERS, parameter("time", 0.0, ""),',
            r"'time' would be the name of two things \(time and parameter\)",
        ),
        ("((2.0, 0.0)", "((2.0, 3.0)", "mass: not symmetric"),
        ('"N/m")', '"N/mm")', "rate has the unit 'N/mm', which is unknown"),
        (
            '"N/m")',
            '"N/m", display="kN")',
            "rate is displayed in 'kN', which is not a display unit of 'N/m'",
        ),
        ('800.0, "rate of both springs", "N/m"', '-1.0, "", "N/m", minimum=0.0', "rate = -1: must"),
        (
            "signals={}",
            'signals={"road": 3}',
            "among the signals is 3: it must be of the class Signal",
        ),
        (
            "signals={}",
            "signals={}, axles=(Axle('', (1.0, 0.0), 'rod'),)",
            "its road 'rod' is not among",
        ),
        ("elements=(", "elements=(None,", "among the elements is None"),
        (
            'linear(p["rate"])',
            "function(lambda x: 1 / x, abs)",
            "line 21: ZeroDivisionError: ",
        ),
        ('SCENE = {"duration": "0.5 s"', 'SCENE = {"duraton": "0.5 s"', "unknown key 'duraton'"),
    ],
)
def test_what_is_wrong_is_said_once_with_the_file_and_the_line(before, after, words):
    module = MODULE.replace("import Element", "import Axle, Element")
    module = module.replace("import linear", "import linear, function")
    module = module.replace("VARIABLES", "from dataclasses import replace; VARIABLES", 1)
    Path("two_masses.py").write_text(module.replace(before, after))
    with pytest.raises(InputError, match=words) as refused:
        load_scene("two_masses.py")
    assert str(refused.value).count("two_masses.py") == 1


def test_a_module_needs_the_name_of_a_model():
    Path("My-Masses.py").write_text(MODULE)
    with pytest.raises(InputError, match=r"in lower case, such as my_car\.py"):
        load_scene("My-Masses.py")
    Path("half_car.py").write_text(MODULE)
    with pytest.raises(InputError, match="HalfCar is a model of this package"):
        load_scene("half_car.py")


@pytest.mark.slow
def test_parameters_that_make_rest_unstable_are_refused_wherever_they_come_from():
    with pytest.raises(InputError, match="rest is unstable"):
        load_scene("two_masses.py", ["rate=-3"])
    Path("sweep.toml").write_text(
        'scene = "two_masses.py"\nmeasures = ["peak.upper_displacement"]\n[vary]\nrate = [-3, 800]\n'
    )
    told = phaseplane_command("sweep sweep.toml")
    assert told.exit_code == 1
    assert "rest is unstable" in told.output
