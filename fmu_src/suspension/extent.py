"""How far the road of a run reaches: where it fades out, where it ends, and what a short one lacks.

All of it follows from the parameters alone; no road is made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil

from .profiles import LONGEST, fade_length, share_of_variance
from .variable import Value, number

LENGTH = "road.profile_length"
DEFAULT_LENGTH = 200.0  # m, of a random road
_ENOUGH = 0.75  # of the variance of its class, for a random road not to be called short


def length_for(parameters: Mapping[str, Value], duration: float) -> float | None:
    """Length in m of a random road that neither ends nor fades out within a run.

    At least the default one, at most the longest there can be; whole metres.

    Parameters
    ----------
    parameters : all of a model's
    duration : of the run, s

    Returns
    -------
    None where the road is no random one.
    """
    if parameters.get("road.shape") != "random":
        return None
    way = (duration - number(parameters, "road.start")) * number(parameters, "speed")
    whole = max(ceil(way + fade_length(max(way, DEFAULT_LENGTH))), DEFAULT_LENGTH)
    return min(float(whole), LONGEST)


def road_end(parameters: Mapping[str, Value]) -> tuple[float, float] | None:
    """The instants at which the first wheel finds the road fading out, and level for good, s.

    Returns
    -------
    None where the road is endless, or a single obstacle (or several), after which nothing is missing.
    """
    shape = parameters.get("road.shape")
    if shape == "sweep":
        end = number(parameters, "road.start") + number(parameters, "road.duration")
        return end, end
    if shape == "random":
        length = number(parameters, LENGTH)
        fade = fade_length(length)
    elif shape in ("table", "spline"):
        position = str(parameters["road.table"]).rpartition(",")[2].partition(":")[0]
        try:
            length, fade = float(position), 0.0
        except ValueError:  # told where the road is made
            return None
    else:
        return None
    start, speed = number(parameters, "road.start"), number(parameters, "speed")
    return start + (length - fade) / speed, start + length / speed


def remarks(parameters: Mapping[str, Value], duration: float) -> Iterator[str]:
    """What is to be said of the road of a run that lasts so long, s: one line each."""
    found = road_end(parameters)
    if found is not None:
        fading, end = found
        out = f" (fading out from {fading:.4g} s)" if fading < end else ""
        if end < duration * (1.0 - 1e-9):
            yield f"road ends at {end:.4g} s of {duration:g} s{out}; it is level from there on"
        elif fading < duration * (1.0 - 1e-9):
            yield f"road fades out from {fading:.4g} s of {duration:g} s"
    if parameters.get("road.shape") == "random":
        length = number(parameters, LENGTH)
        try:
            share, longest = share_of_variance(length)
        except ValueError:  # told where the road is made
            return
        if share < _ENOUGH:
            yield (
                f"random road of {length:.4g} m has no waves longer than {longest:.3g} m, in which "
                f"a long one of its class has {100.0 * (1.0 - share):.0f} % of its variance"
            )
