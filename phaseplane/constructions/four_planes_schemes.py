"""Points and lines in the four planes of a half car, in the order of drawing."""

from __future__ import annotations

from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.schemes import marks, scheme, strokes, turns

_AXLES = ("1", "2")


def half_car_scheme(flying: tuple[bool, ...], linear_tyres: tuple[bool, ...]) -> Scheme:
    """Return the scheme: AP57 figures 7 or 10 for each axle, and figure 12 between the struts.

    Parameters
    ----------
    flying, linear_tyres : whether each axle is in flight, and whether its tyre is linear
    """
    axles = list(zip(_AXLES, flying, linear_tyres, strict=True))
    in_contact = [i for i, flies, _ in axles if not flies]
    in_flight = [i for i, flies, _ in axles if flies]
    linear = [i for i, _, is_linear in axles if is_linear]
    others = [i for i, _, is_linear in axles if not is_linear]
    ends = {i: f"B{i}0" if flies else f"B{i}2" if lin else f"A{i}2*" for i, flies, lin in axles}
    feet = {i: "D" if lin else "H" for i, _, lin in axles}

    def each(template: str, of: list[str] | None = None) -> str:
        """Return the template for every axle, with i replaced by its number."""
        return " ".join(template.replace("i", i) for i in (_AXLES if of is None else of))

    states = (
        "The state points P and their feet Q on the y axes.",
        marks("state", each("Pi1 Pi2")),
        marks("foot", each("Qi1 Qi2")),
        strokes("foot", each("Pi1-Qi1 Pi2-Qi2")),
    )
    raised = (
        "From each P parallel to the y axis to the auxiliary curve: A. Down to the axis: A*.",
        marks("construction", each("Ai1 Ai2 Ai1* Ai2*")),
        strokes("construction", each("Pi1-Ai1 Ai1-Ai1* Pi2-Ai2 Ai2-Ai2*")),
    )
    road = (
        "From A12*, A22* along the y axes by the roads' mean h2/c2: B12, B22.",
        marks("excitation", each("Bi2", linear)),
        strokes("excitation", each("Ai2*-Bi2", linear)),
    )
    weight = (
        "From Q of a wheel in flight against its y axis by b x2st: B10 or B20, for B. By the static "
        "load from A* of its strut: D.",
        marks("excitation", each("Bi0", in_flight)),
        marks("projection", each("Di1", in_flight)),
        strokes("excitation", each("Qi2-Bi0 Ai1*-Di1", in_flight)),
    )
    projection = (
        "In each axle the line from A* of the strut to B of the wheel cuts lines I and II in C. Q of "
        "either through C gives D of the other.",
        marks("projection", each("Ci1") + " " + each("Ci2 Di1", in_contact)),
        marks("projection", each("Di2", others)),
        marks("normal", each("Di2", linear)),
        strokes("projection", " ".join(f"A{i}1*-{end} Q{i}1-D{i}2" for i, end in ends.items())),
        strokes("projection", each("Qi2-Di1", in_contact)),
    )
    inertia = (
        "A11*A21* cuts lines III and IV in G11 and G21. Q11 through G11 gives K21, Q21 through G21 "
        "gives K11.",
        marks("projection", "G11 G21 K11 K21"),
        strokes("projection", "A11*-A21* Q11-K21 Q21-K11"),
    )
    shift = (
        "Lay off A*K of each strut from its D: H."
        + (" From D of the wheel against the y axis by xi''/Omega^2: H." if others else ""),
        marks("normal", each("Hi1")),
        marks("normal", each("Hi2", others)),
        strokes("construction", each("Di1-Hi1")),
        strokes("excitation", each("Di2-Hi2", others)),
    )
    normals = " ".join(f"H{i}1-P{i}1 {foot}{i}2-P{i}2" for i, foot in feet.items())
    return scheme(
        states,
        raised,
        *((road,) if linear else ()),
        *((weight,) if in_flight else ()),
        projection,
        inertia,
        shift,
        ("The normals of the integral curves.", strokes("normal", normals)),
        turns("11", "12", "21", "22"),
    )
