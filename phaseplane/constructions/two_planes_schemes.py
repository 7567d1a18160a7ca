"""How the points in the two planes of the quarter car are joined, in the order of drawing."""

from __future__ import annotations

from phaseplane.constructions.primitives import Arc, Mark, Scheme, Stroke

_STATE_MARKS = (
    Mark("state", "P1", 0, "P1"),
    Mark("state", "P2", 0, "P2"),
    Mark("foot", "Q1", 0, "Q1"),
    Mark("foot", "Q2", 0, "Q2"),
)
_STATE_STROKES = (Stroke("foot", "P1", "Q1", 0), Stroke("foot", "P2", "Q2", 0))
_STATES = "The state points P1, P2 and their feet Q1, Q2 on the y axes."
_NORMALS = "D1P1 and D2P2 are the normals of the integral curves."
_TURN = "Their lengths on the common arm of the turn angles: the arcs are the ways to go."
_TURN_ARCS = (Arc("arc", "W", "N1", "N1'", 5), Arc("arc", "W", "N2", "N2'", 5))
_NORMAL_STROKES = (Stroke("normal", "D1", "P1", 4), Stroke("normal", "D2", "P2", 4))

CONTACT_SCHEME = Scheme(
    (
        _STATES,
        "From P1, P2 parallel to the y axes to the auxiliary curves: A1, A2. "
        "Down to the axes: A1*, A2*.",
        "From A2* along the y2 axis by h2/c2 of the road, its mean over the step: B2.",
        "A1*B2 cuts line I in C1 and line II in C2. "
        "Q1 through C1 gives D2, Q2 through C2 gives D1.",
        _NORMALS,
        _TURN,
    ),
    (
        *_STATE_MARKS,
        Mark("construction", "A1", 1, "A1"),
        Mark("construction", "A2", 1, "A2"),
        Mark("construction", "A1*", 1, "A1*"),
        Mark("construction", "A2*", 1, "A2*"),
        Mark("excitation", "B2", 2, "B2"),
        Mark("projection", "C1", 3, "C1"),
        Mark("projection", "C2", 3, "C2"),
        Mark("normal", "D1", 3, "D1"),
        Mark("normal", "D2", 3, "D2"),
    ),
    (
        *_STATE_STROKES,
        Stroke("construction", "P1", "A1", 1),
        Stroke("construction", "A1", "A1*", 1),
        Stroke("construction", "P2", "A2", 1),
        Stroke("construction", "A2", "A2*", 1),
        Stroke("excitation", "A2*", "B2", 2),
        Stroke("projection", "A1*", "B2", 3),
        Stroke("projection", "Q1", "D2", 3),
        Stroke("projection", "Q2", "D1", 3),
        *_NORMAL_STROKES,
    ),
    _TURN_ARCS,
)
"""In contact (AP57 figure 7)."""

FLIGHT_SCHEME = Scheme(
    (
        _STATES,
        "From P1 parallel to the y1 axis to the auxiliary curve: A1. Down to the axis: A1*. "
        "A2, A2* and B2 as in contact: where B2 meets B0, the wheel is back (V).",
        "B0 lies b x2st from Q2 against the y2 axis and takes the place of B2. "
        "D1 lies a M g/c1 from A1* along the y1 axis.",
        "A1*B0 cuts line I in C1. Q1 through C1 gives D2. Line II is idle.",
        _NORMALS,
        _TURN,
    ),
    (
        *_STATE_MARKS,
        Mark("construction", "A1", 1, "A1"),
        Mark("construction", "A1*", 1, "A1*"),
        Mark("excitation", "B2", 1, "B2"),
        Mark("excitation", "B0", 2, "B0"),
        Mark("normal", "D1", 2, "D1"),
        Mark("projection", "C1", 3, "C1"),
        Mark("normal", "D2", 3, "D2"),
    ),
    (
        *_STATE_STROKES,
        Stroke("construction", "P1", "A1", 1),
        Stroke("construction", "A1", "A1*", 1),
        Stroke("construction", "P2", "A2", 1),
        Stroke("construction", "A2", "A2*", 1),
        Stroke("excitation", "A2*", "B2", 1),
        Stroke("excitation", "Q2", "B0", 2),
        Stroke("excitation", "A1*", "D1", 2),
        Stroke("projection", "A1*", "B0", 3),
        Stroke("projection", "Q1", "D2", 3),
        *_NORMAL_STROKES,
    ),
    _TURN_ARCS,
)
"""In flight (AP57 figure 10)."""
