"""What of a system its failure needs: parameters are taken away, then rounded, while it still fails."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import judging
from draws import Drawn


def reduced(drawn: Drawn, what: str, tell: Callable[[str], None]) -> Drawn:
    """The system with the fewest parameters in which `what` still fails.

    Parameters
    ----------
    what : the beginning of a failure, up to its first colon (`1e-06`, `mean, 0.0005 s`)
    tell : is told of each step
    """
    smaller = True
    while smaller:
        smaller = False
        for name, other in _simpler(drawn):
            try:
                failures = judging.examine(other, only=what)["failures"]
            except ValueError:
                continue  # no longer a system
            if failures:
                tell(f"{name}: {failures[0]}")
                drawn, smaller = other, True
                break
    return drawn


def _simpler(drawn: Drawn) -> Iterator[tuple[str, Drawn]]:
    p = drawn.parameters
    for name in p:
        yield (
            f"without {name}",
            replace(drawn, parameters={k: x for k, x in p.items() if k != name}),
        )
    for name, x in p.items():
        if isinstance(x, float) and float(f"{x:.1g}") != x:
            yield f"round {name}", replace(drawn, parameters=p | {name: float(f"{x:.1g}")})
    half = float(f"{0.5 * drawn.duration:.2g}")
    if half > 0.02:
        yield f"{half} s", replace(drawn, duration=half)


def as_json(drawn: Drawn) -> str:
    """Model, parameters and duration."""
    whole: dict[str, Any] = {"model": drawn.model, "duration": drawn.duration}
    return json.dumps(whole | {"parameters": drawn.parameters}, indent=1)
