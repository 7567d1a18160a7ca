"""Points and lines in two planes coupled by inertia, in the order of drawing."""

from __future__ import annotations

from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.schemes import marks, on_both_axes, scheme, strokes, turns


def inertial_scheme() -> Scheme:
    """Return the scheme of AP57 figure 12, in the order of drawing."""
    return scheme(
        *on_both_axes(),
        (
            "A1*A2* cuts line I in C1 and line II in C2. Q1 through C1 gives D2, Q2 through C2 gives "
            "D1.",
            marks("projection", "C1 C2 D1 D2"),
            strokes("projection", "A1*-A2* Q1-D2 Q2-D1"),
        ),
        (
            "From D1, D2 against the y axes by xi''/Omega^2 of their roads, averaged over the step: "
            "H1, H2.",
            marks("normal", "H1 H2"),
            strokes("excitation", "D1-H1 D2-H2"),
        ),
        (
            "H1P1 and H2P2 are the normals of the integral curves.",
            strokes("normal", "H1-P1 H2-P2"),
        ),
        turns("1", "2"),
    )
