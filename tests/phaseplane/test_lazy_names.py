"""Packages that give their names lazily: all names are there, and none is imported before it is used."""

from __future__ import annotations

from importlib import import_module
from inspect import isfunction
from pathlib import Path

import pytest
from hosting import in_python

import phaseplane
from phaseplane import figures, scenarios, vehicle_fmus

PACKAGES = [
    "phaseplane", "phaseplane.constructions", "phaseplane.portrait", "phaseplane.figures",
    "phaseplane.equations", "phaseplane.exercises", "phaseplane.recording", "phaseplane.vehicle_fmus",
    "phaseplane.vehicle_fmus.native",
    "phaseplane.scenarios.simulate", "phaseplane.scenarios.draw", "phaseplane.scenarios.results",
    "phaseplane.scenarios.measures",
]  # fmt: skip


@pytest.mark.parametrize("name", PACKAGES)
def test_every_name_is_there(name: str) -> None:
    package = import_module(name)
    assert package.__all__
    assert [each for each in package.__all__ if getattr(package, each) is None] == []


def test_every_package_that_says_its_names_is_tested() -> None:
    found = [
        ".".join([package.__name__, *path.parent.relative_to(root).parts])
        for package in (phaseplane, scenarios, vehicle_fmus)
        for root in [Path(package.__path__[0])]
        for path in root.rglob("*.pyi")
    ]
    assert sorted(PACKAGES) == sorted(set(found))


def test_a_function_stands_before_the_module_of_its_name() -> None:
    for name in ("portrait", "animation"):
        import_module(f"phaseplane.figures.{name}")
        assert isfunction(getattr(figures, name))


def test_importing_the_packages_imports_nothing_else() -> None:
    code = f"import sys, {', '.join(PACKAGES)}\nprint(*sys.modules)"
    loaded = set(in_python(code).split())
    assert {name for name in loaded if name.startswith("phaseplane")} == {
        *PACKAGES, "phaseplane.scenarios",
    }  # fmt: skip
    assert not loaded & {"numpy", "scipy", "matplotlib", "rerun"}
