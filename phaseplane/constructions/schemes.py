"""A notation for schemes: stage by stage, points and lines by their letters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from phaseplane.constructions.primitives import Arc, Mark, Scheme, Stroke

Part = Mark | Stroke | Arc
Stage = tuple[str, *tuple[Iterator[Part], ...]]
"""What is done, and the parts that it adds to the sheet."""


def marks(role: str, letters: str) -> Iterator[Mark]:
    """Return lettered points from text such as `"P1 Q1"`."""
    return (Mark(role, letter, 0, letter) for letter in letters.split())


def strokes(role: str, ends: str) -> Iterator[Stroke]:
    """Return straight lines from text such as `"P1-Q1 A1-A1*"`."""
    lines = (line.split("-") for line in ends.split())
    return (Stroke(role, start, end, 0) for start, end in lines)


def feet(words: str, *numbers: str) -> Stage:
    """Return the stage that marks P and its foot Q in the planes."""
    return (
        words,
        marks("state", _each("P{0}", numbers)),
        marks("foot", _each("Q{0}", numbers)),
        strokes("foot", _each("P{0}-Q{0}", numbers)),
    )


def raised(words: str, *numbers: str) -> Stage:
    """Return the stage that finds A on the auxiliary curve of each plane, and its foot A*."""
    return (
        words,
        marks("construction", _each("A{0}", numbers) + " " + _each("A{0}*", numbers)),
        strokes("construction", _each("P{0}-A{0} A{0}-A{0}*", numbers)),
    )


def _each(template: str, numbers: Sequence[str]) -> str:
    return " ".join(template.format(number) for number in numbers)


def on_both_axes() -> tuple[Stage, Stage]:
    """Return the first stages in two planes: P and Q, then A and A*."""
    return (
        feet("The state points P1, P2 and their feet Q1, Q2 on the y axes.", "1", "2"),
        raised(
            "From P1, P2 parallel to the y axes to the auxiliary curves: A1, A2. Down to the axes: A1*, "
            "A2*.",
            "1", "2",
        ),
    )  # fmt: skip


def turns(*numbers: str) -> Stage:
    """Return the stage that lays off the normals on the common arm of the turn angles of the planes."""
    words = (
        "Its length on the arm of the turn angle: the arc of the step."
        if len(numbers) == 1
        else "Their lengths on the arm of the turn angles: the arcs of the steps."
    )
    return words, (Arc("arc", "W", f"N{n}", f"N{n}'", 0) for n in numbers)


def scheme(*stages: Stage) -> Scheme:
    """Return a scheme from stages, each a description followed by the parts it adds to the sheet."""
    placed = [
        (i, part) for i, (_, *added) in enumerate(stages) for parts in added for part in parts
    ]
    return Scheme(
        tuple(words for words, *_ in stages),
        tuple(Mark(p.role, p.point, i, p.label) for i, p in placed if isinstance(p, Mark)),
        tuple(Stroke(p.role, p.start, p.end, i) for i, p in placed if isinstance(p, Stroke)),
        tuple(Arc(p.role, p.centre, p.start, p.end, i) for i, p in placed if isinstance(p, Arc)),
    )
