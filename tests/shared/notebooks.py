"""Notebooks run in this process, cell by cell."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any


def run(path: Path) -> tuple[dict[str, Any], list[Any]]:
    """The names that a notebook leaves, and what it shows below its cells."""
    scope: dict[str, Any] = {}
    shown = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            tree = ast.parse("".join(cell["source"]))
            last = tree.body.pop()
            exec(compile(tree, "cell", "exec"), scope)
            if isinstance(last, ast.Expr):
                shown.append(eval(compile(ast.Expression(last.value), "cell", "eval"), scope))
            else:
                exec(compile(ast.Module([last], []), "cell", "exec"), scope)
    return scope, shown
