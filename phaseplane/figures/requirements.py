"""What the figures of AP57 need of a construction; its first step shows whether it has it."""

from __future__ import annotations

from dataclasses import dataclass

from phaseplane.constructions.primitives import Drawing


@dataclass(frozen=True, slots=True)
class Requirement:
    """What a figure needs.

    Parameters
    ----------
    shows : what it shows, and what a construction without the number of planes, the letters or the
        reading is not or has not
    scene : one whose construction has it
    planes : how many it may have; any number if empty
    letter, without : points that its construction has and has not
    reading : of each step
    rule : the only step rule that it shows
    """

    shows: str = ""
    scene: str = ""
    planes: tuple[int, ...] = ()
    letter: str = ""
    without: str = ""
    reading: str = ""
    rule: str = ""


_ELASTIC, _INERTIAL = "two planes with elastic coupling", "two planes with inertial coupling"

REQUIREMENTS = {
    "figure1": Requirement("a half car with tyres", "half_car_pitch", planes=(4,)),
    "figure2": Requirement("one plane", "ap57_obstacle", planes=(1,)),
    "figure3": Requirement(rule="tangent"),
    "figure4a": Requirement(rule="mean_normal"),
    "figure4b": Requirement(rule="osculating_circle"),
    "figure5": Requirement(
        "the obstacle of constant acceleration", "ap57_obstacle", reading="road_elevation"
    ),
    "figure6": Requirement("a quarter car", "ap57", planes=(2,), letter="A2*", without="H1"),
    "figure7": Requirement(_ELASTIC, "ap57_figure13", letter="B2"),
    "figure8": Requirement("two planes or more", "ap57", planes=(2, 4), rule="tangent"),
    "figure9": Requirement(_ELASTIC, "ap57", letter="B2"),
    "figure10": Requirement(_ELASTIC, "ap57", letter="B2"),
    "figure11": Requirement(
        "a half car on rigid tyres", "half_car_rigid_tyres", planes=(2,), letter="H1"
    ),
    "figure12": Requirement(_INERTIAL, "half_car_rigid_tyres", letter="H1"),
    "figure14": Requirement(
        "displacements of body, wheel, suspension and road", "ap57_figure13",
        reading="suspension_deflection",
    ),
    "figure15": Requirement(
        "velocities of body, wheel and suspension", "ap57_figure13",
        reading="suspension_deflection_rate",
    ),
    "figure16": Requirement(
        "accelerations of body, wheel and suspension", "ap57_figure13",
        reading="suspension_deflection_acceleration",
    ),
}  # fmt: skip
"""The requirement of each figure that not every construction meets, by name."""


def refuse_unsuited(figure: str, drawing: Drawing) -> None:
    """Reject a construction, of which the first step is enough, that does not suit a figure.

    Raises
    ------
    ValueError : the message says what the figure shows, and for which scene.
    """
    need = REQUIREMENTS.get(figure)
    if need is None:
        return
    name = figure.replace("figure", "figure ")
    title = f"'{drawing.title}'"
    letters = {mark.point for scheme in drawing.schemes.values() for mark in scheme.marks}
    suits = (
        (not need.planes or len(drawing.planes) in need.planes)
        and (not need.letter or need.letter in letters)
        and need.without not in letters
    )
    has = not need.reading or need.reading in drawing.frames[0].readings
    if not (suits and has):
        lacks = f"which {title} {'has not' if suits else 'is not'}"
        raise ValueError(f"{name} shows {need.shows}, {lacks}; try the scene {need.scene}")
    if need.rule and need.rule != drawing.rule:
        raise ValueError(f"{name} needs the rule {need.rule}; given: {title}")
