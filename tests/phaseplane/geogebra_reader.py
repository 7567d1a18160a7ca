"""GeoGebra files read back and evaluated as GeoGebra would, to check them without it."""

from __future__ import annotations

import ast
import math
import re
from cmath import exp
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

from phaseplane.constructions.geometry import meet
from phaseplane.exercises import Command

COMMANDS: Mapping[str, Callable[..., Any]] = {
    "": complex,
    "Line": lambda a, b: (a, b),
    "Midpoint": lambda a, b: 0.5 * (a + b),
    "Rotate": lambda point, angle, centre: centre + (point - centre) * exp(1j * angle),
    "Dilate": lambda point, factor, centre: centre + factor * (point - centre),
    "ClosestPoint": lambda line, z: line[0] + along(line) * ((z - line[0]) / along(line)).real,
    "Intersect": lambda one, other: meet(*one, *other),
}
FUNCTIONS: Mapping[str, Any] = {
    "pi": math.pi, "xAxis": (0j, 1 + 0j), "x": lambda z: z.real, "y": lambda z: z.imag,
    "Distance": lambda a, b: abs(a - b), "sgn": lambda u: (u > 0) - (u < 0), "ln": math.log,
    "abs": abs, "max": max, "min": min, "complex": complex, "__builtins__": {},
    **{name: getattr(math, name) for name in (
        "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp",
    )},
}  # fmt: skip


def along(line: tuple[complex, complex]) -> complex:
    """The unit vector of a line."""
    return (line[1] - line[0]) / abs(line[1] - line[0])


def read_geogebra(path: Path) -> list[Command]:
    """The commands and expressions of a file; polylines are left out."""
    with ZipFile(path) as archive:
        construction = ElementTree.fromstring(archive.read("geogebra.xml")).find("construction")
    assert construction is not None
    found = []
    for element in construction:
        if element.tag == "expression":
            found.append(Command(element.get("label", ""), "", (element.get("exp", ""),)))
        elif element.tag == "command" and element.get("name") != "Polyline":
            given, made = element.find("input"), element.find("output")
            assert given is not None
            assert made is not None
            values = tuple(given.attrib[f"a{i}"] for i in range(len(given.attrib)))
            found.append(Command(made.get("a0", ""), element.get("name", ""), values))
    # GeoGebra refuses to open files with other labels, and reads e as Euler's number
    assert all(re.fullmatch(r"[A-Za-z]'?_\{\d+\*?\}", command.label) for command in found)
    assert not any(re.search(r"\de", element.get("exp", "")) for element in construction)
    return found


def evaluated(made: Sequence[Command]) -> dict[str, complex]:
    """The points that commands make: x + i x-bar by label."""
    known: dict[str, Any] = {}
    for command in made:
        arguments = [value(argument, known) for argument in command.arguments]
        known[command.label] = COMMANDS[command.name](*arguments)
    return {label: point for label, point in known.items() if isinstance(point, complex)}


def value(text: str, known: Mapping[str, Any]) -> Any:
    """An argument: numbers, labels, points, + - * / ^, a blank for times, functions."""
    names: dict[str, Any] = {}
    for label in sorted(known, key=len, reverse=True):
        if label in text:
            name = f"g{len(names)}_"
            text = text.replace(label, name)
            names[name] = known[label]
    text = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text).replace("^", "**")
    tree = ast.fix_missing_locations(Points().visit(ast.parse(text, mode="eval")))
    return eval(compile(tree, "<argument>", "eval"), {**FUNCTIONS, **names})


class Points(ast.NodeTransformer):
    """Makes complex numbers of pairs."""

    def visit_Tuple(self, node: ast.Tuple) -> ast.Call:
        self.generic_visit(node)
        return ast.Call(ast.Name("complex", ast.Load()), node.elts, [])
