"""Public variables: units, ranges and names are checked where a value enters."""

from __future__ import annotations

from collections import Counter
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension.models import build
from phaseplane.suspension.units import UNITS, UnitError, to_si
from phaseplane.suspension.variables import MODELS, ParameterError, checked_parameters, variables
from scipy import constants as si


@pytest.mark.parametrize(
    ("quantity", "unit", "value"),
    [
        ("5 cm", "m", 0.05),
        ("72 km/h", "m/s", 20.0),
        ("15 N/mm", "N/m", 15000.0),
        ("15 kgf/cm", "N/m", 14709.975),
        ("0.3 kgf.s2/cm", "kg", 294.1995),
        ("1 kgf·s/cm", "N.s/m", 980.665),
        ("2 N*s/mm", "N.s/m", 2000.0),
        ("3 kN s / m", "N.s/m", 3000.0),
        ("-2.5e1 mm", "m", -0.025),
        ("7", "m", 7.0),
        (".5ms", "s", 0.0005),
        ("9.81 m/s²", "m/s2", 9.81),
    ],
)
def test_quantities(quantity: str, unit: str, value: float) -> None:
    assert to_si(quantity, unit) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(("quantity", "unit"), [("5 kg", "m"), ("5 parsec", "m"), ("m", "m")])
def test_a_wrong_unit_names_what_is_allowed(quantity: str, unit: str) -> None:
    with pytest.raises(UnitError, match=r"cm|number with a unit"):
        to_si(quantity, unit)


NEWTON = {"kg": 1, "m": 1, "s": -2}
SYMBOLS: dict[str, tuple[float, dict[str, int]]] = {
    "1": (1.0, {}), "%": (0.01, {}), "rad": (1.0, {"rad": 1}), "mrad": (si.milli, {"rad": 1}),
    "deg": (si.degree, {"rad": 1}), "m": (1.0, {"m": 1}), "mm": (si.milli, {"m": 1}),
    "cm": (si.centi, {"m": 1}), "km": (si.kilo, {"m": 1}), "in": (si.inch, {"m": 1}),
    "s": (1.0, {"s": 1}), "ms": (si.milli, {"s": 1}), "us": (si.micro, {"s": 1}),
    "min": (si.minute, {"s": 1}), "h": (si.hour, {"s": 1}), "Hz": (1.0, {"s": -1}),
    "kHz": (si.kilo, {"s": -1}), "kg": (1.0, {"kg": 1}), "g": (si.gram, {"kg": 1}),
    "t": (si.metric_ton, {"kg": 1}), "N": (1.0, NEWTON), "kN": (si.kilo, NEWTON),
    "kgf": (si.kgf, NEWTON), "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "kJ": (si.kilo, {"kg": 1, "m": 2, "s": -2}), "ft": (si.foot, {"m": 1}),
    "mph": (si.mph, {"m": 1, "s": -1}), "lbf": (si.lbf, NEWTON),
    "lb": (si.pound, {"kg": 1}),
}  # fmt: skip

OF_ACCELERATION = {  # g is the gram elsewhere
    ("m/s2", name): (size * si.g, {"m": 1, "s": -2})
    for name, size in (("g", 1.0), ("mg", si.milli))
}


def worked_out(unit: str) -> tuple[float, dict[str, int]]:
    """Size of a unit in SI and powers of the base units, from its name."""
    size, powers = 1.0, Counter[str]()
    above, *below = unit.split("/")
    for sign, product in ((1, above), *((-1, part) for part in below)):
        for factor in product.split("."):
            symbol = factor if factor == "1" else factor.rstrip("23")
            power = sign * int(factor[len(symbol) :] or 1)
            size *= SYMBOLS[symbol][0] ** power
            powers.update({base: power * n for base, n in SYMBOLS[symbol][1].items()})
    return size, {base: n for base, n in powers.items() if n}


@given(st.floats(-1e9, 1e9), st.sampled_from(sorted(UNITS)))
def test_every_unit_is_what_its_name_says(x: float, unit: str) -> None:
    assert worked_out(unit) == (1.0, UNITS[unit].exponents)
    for name in UNITS[unit].display:
        size, powers = OF_ACCELERATION.get((unit, name)) or worked_out(name)
        assert powers == UNITS[unit].exponents
        assert to_si(f"{x!r} {name}", unit) == pytest.approx(x * size, rel=1e-14)


@pytest.mark.parametrize(
    ("given_", "complaint"),
    [
        ({"sprung_mas": 1.0}, r"'sprung_mas'; did you mean 'sprung_mass'\?"),
        ({"sprung_mass": -3.0}, r"sprung_mass = -3: must be greater than 0 kg"),
        ({"sprung_mass": 0}, r"greater than 0"),
        ({"sprung_mass": float("nan")}, r"sprung_mass = nan"),
        ({"sprung_mass": float("inf")}, r"sprung_mass = inf"),
        ({"sprung_mass": True}, r"must be a number in kg"),
        ({"sprung_mass": "heavy"}, r"not a number with a unit"),
        ({"sprung_mass": "3,5 kg"}, r"'3,5 kg': the decimal sign is a point, not a comma"),
        ({"sprung_mass": "3 m"}, r"unit 'm' does not fit here; allowed: kg, g, t"),
        ({"lift_off": 1}, r"lift_off = 1: must be true or false"),
        ({"road.shape": "bmup"}, r"must be one of .* did you mean 'bump'"),
        ({"road.shape": 3}, r"must be a string in quotes$"),
        ({"solver.beyond_stable": 3}, r"must be a string in quotes$"),
        ({"damper.table": [[0.0, 0.0], [1.0, 9.0]]}, r'in quotes, pairs such as "-0.1:-900, 0:0, '),
        ({"solver.tolerance": 0.5}, r"at least 1e-12 and at most 0.1"),
        ({"spring.rate": "-1 N/mm"}, r"spring.rate = -1000: must be at least 0"),
        ({"spring.table": "0:0, 1"}, r"spring.table = '0:0, 1': must be pairs"),
        ({"spring.table": "0:0, 1:nan"}, "'0:0, 1:nan': must be pairs of finite numbers"),
        ({"damper.table": "0:0, inf:1"}, "'0:0, inf:1': must be pairs of finite numbers"),
        ({"damper.table": "-1:500, 0:0, 1:-500"}, "gives 50000 N at -100 m/s, which adds energy"),
        ({"damper.table": "0:0, 1:500, 2:300"}, "gives -19300 N at 100 m/s, .* extrapolated"),
        ({"damper.table": "0:0, 1:9, 2:-1, 3:9"}, r"damper.table: gives -1 N at 2 m/s"),
        ({"damper.deflection_table": "0:1, 1:nan"}, "must be pairs of finite numbers"),
        ({"spring.table": "0:0, 0:1"}, r"spring.table: table abscissae must ascend"),
        (
            {"road.shape": "table", "road.table": "0:0, 1:-1e200"},
            r"road.table: is 1e\+200 m high; at most 1e\+09 m are allowed",
        ),
        ({"spring.table": "-1:5, 1:20"}, r"must pass through 0:0"),
        ({"road.shape": "table", "road.table": "1:0, 0:0"}, r"road.table: .*ascend"),
        ({"road.shape": "table", "road.table": "x"}, r"road.table = 'x': must be pairs"),
    ],
)
def test_a_wrong_parameter_gives_one_clear_line(given_: dict[str, object], complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint) as error:
        build("QuarterCar", given_)
    assert "\n" not in str(error.value)


def test_an_unknown_model_names_the_nearest() -> None:
    with pytest.raises(ParameterError, match="did you mean 'QuarterCar'"):
        variables("Quartercar")


@pytest.mark.parametrize("model", MODELS)
def test_every_default_is_allowed_and_every_unit_known(model: str) -> None:
    names = [v.name for v in variables(model)]
    assert len(names) == len(set(names))
    for v in variables(model):
        assert v.checked(v.start) == v.start
        assert not v.unit or v.unit in UNITS
        assert not v.display or v.display in UNITS[v.unit].display
        assert v.description
    assert checked_parameters(model, {}) == {
        v.name: v.start for v in variables(model) if v.causality == "parameter"
    }


def test_defaults_are_those_of_the_worked_example() -> None:
    p = checked_parameters("QuarterCar", {})  # AP57 section 8, 1 kgf = 9.80665 N
    assert p["sprung_mass"] == pytest.approx(294.1995)
    assert p["unsprung_mass"] == pytest.approx(29.41995)
    assert p["spring.rate"] == pytest.approx(14709.975)
    assert p["tyre.stiffness"] == pytest.approx(147099.75)
    assert p["tyre.damping"] == pytest.approx(980.665)
    assert p["damper.rebound_rate"] == pytest.approx(1961.33)
    assert p["damper.bump_rate"] == pytest.approx(490.3325)


def test_elements_that_never_act_are_left_out() -> None:
    names = [element.name for element in build("QuarterCar", {}).elements]
    assert names == ["spring", "damper", "tyre"]
    assert build("QuarterCar", {"bump_stop.stiffness": 1e5}).element("bump_stop") is not None


def test_a_whole_number_must_be_one_that_fmi_can_pass() -> None:
    seed = {v.name: v for v in variables("OneDof")}["road.seed"]
    assert seed.checked(2**31 - 1) == 2**31 - 1
    with pytest.raises(ParameterError, match="must be at most 2147483647"):
        seed.checked(10**60)
    refused = {
        10**400: "too large", inf: "= inf: must be at most", nan: "= nan: must be at most",
        0.5: "must be a whole number",
    }  # fmt: skip
    for value, words in refused.items():
        with pytest.raises(ParameterError, match=words):
            seed.checked(value)
    with pytest.raises(ParameterError, match="sprung_mass: the number is too large"):
        build("OneDof", {"sprung_mass": 10**400})
