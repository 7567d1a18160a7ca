"""Print constraints that hold each dependency at its lower bound."""

import tomllib
from pathlib import Path

from packaging.requirements import Requirement

_project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
for _given in (*_project["project"]["dependencies"], *_project["dependency-groups"]["test"]):
    _needed = Requirement(_given)
    _least = next(bound.version for bound in _needed.specifier if bound.operator == ">=")
    print(f"{_needed.name}=={_least}")
