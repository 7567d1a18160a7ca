"""The extent of a road: where it fades out, where it ends, and the waves that a short road lacks.

Everything is computed from the parameters; no road is made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil

from ..variable import Value, number
from .profiles import LONGEST, fade_length, share_of_variance

LENGTH = "road.profile_length"
DEFAULT_LENGTH = 200.0  # m, of a random road
_ENOUGH = 0.75  # share of the variance of its class below which a random road is called short


def length_for(parameters: Mapping[str, Value], duration: float) -> float | None:
    """Return the length in m of a random road that neither ends nor fades out within a run.

    In whole metres, at least the default and at most the greatest possible length.

    Parameters
    ----------
    parameters : all parameters of a model
    duration : of the run, s

    Returns
    -------
    The length, or None if the road is not random.
    """
    if parameters.get("road.shape") != "random":
        return None
    way = (duration - number(parameters, "road.start")) * number(parameters, "speed")
    length = max(way + fade_length(max(way, DEFAULT_LENGTH)), DEFAULT_LENGTH)
    return min(float(ceil(min(length, LONGEST))), LONGEST)


def road_end(parameters: Mapping[str, Value]) -> tuple[float, float] | None:
    """Return the times at which the road under the first wheel begins to fade out, and ends, s.

    Returns
    -------
    None if the road is endless, or consists of single obstacles, after which nothing is missing.
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
        except ValueError:  # reported where the road is made
            return None
    else:
        return None
    start, speed = number(parameters, "road.start"), number(parameters, "speed")
    return start + (length - fade) / speed, start + length / speed


def remarks(parameters: Mapping[str, Value], duration: float) -> Iterator[str]:
    """Yield remarks on the road of a run of this duration (s), one line each."""
    found = road_end(parameters)
    if found is not None:
        fading, end = found
        out = f" (fading out from {fading:.4g} s)" if fading < end else ""
        if end < duration * (1.0 - 1e-9):
            yield f"road ends at {end:.4g} s of {duration:g} s{out}; it is level afterwards"
        elif fading < duration * (1.0 - 1e-9):
            yield f"road fades out from {fading:.4g} s of {duration:g} s"
    if parameters.get("road.shape") == "random":
        length = number(parameters, LENGTH)
        try:
            share, longest = share_of_variance(length)
        except ValueError:  # reported where the road is made
            return
        if share < _ENOUGH:
            yield (
                f"a random road of {length:.4g} m contains no wavelengths above {longest:.3g} m, which "
                f"carry {100.0 * (1.0 - share):.0f} % of the variance of its class"
            )
