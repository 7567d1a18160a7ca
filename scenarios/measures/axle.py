"""The measures of one axle: contact with the road, tyre load, travel, stops, damper."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from operator import mul, pos

from phaseplane.suspension.variables import Variable

from .motion import first_instant, instants, last, smallest, square
from .reading import COUNT, Measure, Reading, Run, late

_OF_AXLE = "suspension_deflection"  # behind the prefix of an axle
_MITSCHKE = "M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, Springer 2004"


def of_axles(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield the measures of every axle of the model; their names begin with its prefix."""
    for deflection in outputs:
        if deflection.endswith(_OF_AXLE):
            of_axle = _of_axle(deflection.removesuffix(_OF_AXLE))
            yield from (one for one in of_axle if outputs.keys() >= {*one.needs})


def _of_axle(prefix: str) -> Iterator[Measure]:
    def measure(
        name: str,
        unit: str,
        needs: tuple[str, ...],
        take: Callable[..., Reading],
        about: str,
        source: str = "",
        details: str = "",
    ) -> Measure:
        needs = tuple(f"{prefix}{need}" for need in needs)
        return Measure(
            f"{prefix}{name}", unit, needs, partial(take, *needs), about, source, take is last,
            counted=take is instants, details=details,
        )  # fmt: skip

    yield measure("lift_off_count", COUNT, ("lift_off_count",), last,
                  "number of lift-offs of the wheel, counted by the model")  # fmt: skip
    yield measure("airborne_time", "s", ("airborne_time",), last,
                  "time the wheel spent off the road, from located events")  # fmt: skip
    for what, words in (("lift_off", "lift-off"), ("touchdown", "touchdown")):
        yield measure(f"first_{what}", "s", (f"last_{what}",), first_instant,
                      f"time of the first {words}, as located", details="switches")  # fmt: skip
        yield measure(f"{what}s", "s", (f"last_{what}",), instants,
                      f"time of each {words}, as located", details="switches")  # fmt: skip
    yield measure("smallest_contact_force", "N", ("contact_force",), smallest,
                  "smallest force of the road on the tyre", details="least")  # fmt: skip
    yield measure("dynamic_load_coefficient", "1", ("contact_force", "tyre_force"), _load_coefficient,
                  "root mean square of the dynamic tyre load (the deviation from the static load), over "
                  "the static tyre load; for long runs the standard deviation of the load over its mean",
                  _MITSCHKE, "mean")  # fmt: skip
    yield measure("suspension_travel", "m", ("suspension_deflection",), _range,
                  "largest minus smallest suspension deflection", details="range")  # fmt: skip
    for stop in ("bump_stop", "rebound_stop"):
        yield measure(f"{stop}_hits", COUNT, (f"{stop}_force",), _hits,
                      f"number of hits of the {stop.replace('_', ' ')}", details="switches")  # fmt: skip
    yield measure("mean_height_shift", "m", ("suspension_deflection",), _shift,
                  "mean of the suspension deflection over the second half of the run; a damper softer "
                  "in bump than in rebound lowers the body", details="late mean")  # fmt: skip
    yield measure("damper_power", "W", ("damper_force", "suspension_deflection_rate"), _power,
                  "mean power dissipated by the damper, force times rate",
                  details="mean")  # fmt: skip


def _load_coefficient(contact: str, dynamic: str, run: Run) -> Reading:
    # contact force = static load - tyre force
    static = float(run.columns[contact][0] + run.columns[dynamic][0])
    return Reading(run.mean(square, dynamic) ** 0.5 / static if static > 0.0 else None)


def _range(name: str, run: Run) -> Reading:
    _, values = run.closely(name)
    return Reading(float(values.max() - values.min()))


def _hits(force: str, run: Run) -> Reading:
    met = run.closely(force)[1] != 0.0
    return Reading(int(met[0]) + int((met[1:] & ~met[:-1]).sum()))


def _shift(deflection: str, run: Run) -> Reading:
    return Reading(run.mean(pos, deflection, since=late(run.time)))


def _power(force: str, rate: str, run: Run) -> Reading:
    return Reading(run.mean(mul, force, rate))
