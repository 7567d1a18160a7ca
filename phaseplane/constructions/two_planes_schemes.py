"""How the points in the two planes of an axle are joined, in the order of drawing."""

from __future__ import annotations

from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.schemes import marks, on_both_axes, scheme, strokes, turns

_NORMALS = "are the normals of the integral curves."


def axle_scheme(*, flies: bool, linear_tyre: bool = True, sticks: bool = False) -> Scheme:
    """Return figure 7 (contact) or figure 10 (flight) of AP57, for a linear or a nonlinear tyre.

    Parameters
    ----------
    sticks : whether dry friction holds the strut: D1 = Q1, and A1* is found from it
    """
    states, raised = on_both_axes()
    end = "B0" if flies else "B2" if linear_tyre else "A2*"
    foot = "D2" if linear_tyre else "H2"
    held = (
        "Dry friction holds the strut: D1 = Q1. From P2 parallel to the y2 axis to the auxiliary line: "
        "A2. Down to the axis: A2*.",
        marks("normal", "D1"),
        marks("construction", "A2 A2*"),
        strokes("construction", "P2-A2 A2-A2*"),
    )
    road = (
        "From A2* along the y2 axis by the road's mean h2/c2 over the step: B2."
        + (" The wheel touches down (V) where B2 meets B0." if flies else ""),
        marks("excitation", "B2"),
        strokes("excitation", "A2*-B2"),
    )
    replaced = "B2" if linear_tyre else "A2*"
    free = f", which replaces {replaced}. From A1* along the y1 axis by a M g/c1: D1."
    weight = (
        "From Q2 against the y2 axis by b x2st: B0" + ("." if sticks else free),
        marks("excitation", "B0"),
        marks("normal", "" if sticks else "D1"),
        strokes("excitation", "Q2-B0" if sticks else "Q2-B0 A1*-D1"),
    )
    found = (
        "From D1 against the y1 axis by a M g/c1: A1*. "
        if flies
        else f"Q2D1 cuts line II in C2, and {end}C2 the y1 axis in A1*: between both branches of the "
        "auxiliary curve. "
    )
    through_c1 = f"A1*{end} cuts line I in C1. Q1 through C1 gives D2."
    projected = (
        f"{through_c1} Line II is not used."
        if flies
        else f"A1*{end} cuts line I in C1 and line II in C2. Q1 through C1 gives D2, Q2 through C2 "
        "gives D1."
    )
    projection = (
        found + through_c1 if sticks else projected,
        marks("construction", "A1*" if sticks else ""),
        marks("projection", "C1" if flies else "C1 C2"),
        marks("normal", "" if flies or sticks else "D1"),
        marks("normal" if linear_tyre else "projection", "D2"),
        strokes("projection", f"A1*-{end} Q1-D2" + ("" if flies else " Q2-D1")),
    )
    shift = (
        "From D2 against the y2 axis by the road's mean xi''/Omega2^2 over the step: H2.",
        marks("normal", "H2"),
        strokes("excitation", "D2-H2"),
    )
    return scheme(
        states,
        held if sticks else raised,
        *((road,) if linear_tyre else ()),
        *((weight,) if flies else ()),
        projection,
        *(() if linear_tyre else (shift,)),
        (
            f"{foot}P2 is the normal in plane 2. P1 stays where it is.",
            strokes("normal", f"{foot}-P2"),
        )
        if sticks
        else (f"D1P1 and {foot}P2 {_NORMALS}", strokes("normal", f"D1-P1 {foot}-P2")),
        turns("1", "2"),
    )
