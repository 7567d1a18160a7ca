"""The switches of a session's elements, and what hosts are told of contacts and stops."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import starmap, takewhile
from math import inf
from typing import Any, NamedTuple

from .engine import KINDS, Run
from .kernel.language import Switch
from .kernel.layout import CONTACT
from .reading import Contacts
from .systems import Axle, System

_MOST = 100_000  # stored per run


class Event(NamedTuple):
    """The switch of an element from one of its branches to another.

    Parameters
    ----------
    time : s
    element : its name
    kind : one of `engine.KINDS`
    before, after : numbers of the branches: pieces of a law in ascending order; contact 0 on and 1
        off the road; friction -1 and 1 slipping, 0 sticking
    """

    time: float
    element: str
    kind: str
    before: int
    after: int


def free_of_stops(system: System) -> dict[int, int]:
    """Return the end stops of the axles by their numbers, each with its piece out of contact.

    An end stop given by a table has further pieces, from one of which to the next it is still met.
    """
    free = {}
    for axle in system.axles:
        for name in ("bump_stop", "rebound_stop"):
            number = system.element(f"{axle.prefix}{name}")
            if number is not None:
                last = len(system.elements[number].spring.pieces) - 1
                free[number] = last if name == "bump_stop" else 0
    return free


class Events:
    """The switches so far; those of contacts and end stops are reported when their time has come.

    Parameters
    ----------
    tyres : the axles with a tyre
    run : counts their contacts
    messages : where reports are added
    """

    def __init__(self, tyres: Sequence[Axle], run: Run, messages: list[tuple[str, str]]) -> None:
        self._tyres, self._run, self._messages = tyres, run, messages
        self._places = [axle.prefix.replace("_", " ") for axle in tyres]  # such as "front "
        # an `Event` costs more than the rest, and many hosts read none: `all` makes them
        self._switches: deque[tuple[float, str, str, int, int]] = deque(maxlen=_MOST)
        # end stops met or left that are yet to be reported, and those reported as met
        self._stops: deque[tuple[float, str, bool]] = deque()
        self._met: set[str] = set()
        self.contacts = Contacts(*run.contacts.seen())
        self._next_contact = run.contacts.next  # asked for in every step

    def attach(self, system: System) -> None:
        """Take the names of a system's elements from now on."""
        self._names = [element.name for element in system.elements]
        self._of_tyres = {system.element(axle.tyre) for axle in self._tyres}
        self._free = free_of_stops(system)

    def all(self) -> list[Event]:
        """Return the switches so far; at most the last 100 000 of them."""
        return [*starmap(Event, self._switches)]

    def note(self, log: Iterable[Switch], until: float) -> None:
        """Take switches from the integrator's log; those up to `until` are counted and reported."""
        for time, element, kind, before, after in log:
            name = self._names[element]
            self._switches.append((time, name, KINDS[kind], before, after))
            if kind == CONTACT and element in self._of_tyres:
                self._run.contacts.note(time, element, after != 0)
            elif element in self._free and (free := self._free[element]) in (before, after):
                self._stops.append((time, name, before == free))
            else:
                continue
            if time <= until:
                self.come_to(time)

    def come_to(self, until: float) -> None:
        """Count the contact switches up to a time, and report them and the end stops.

        An end stop that is compressed from the start is not reported until it is met.
        """
        while self._stops and self._stops[0][0] <= until:
            time, name, met = self._stops.popleft()
            self._count_contacts(time)
            if met or name in self._met:
                self._report(f"{name} {'met' if met else 'left'} at {time:.9g} s")
            (self._met.add if met else self._met.discard)(name)
        self._count_contacts(until)

    def _count_contacts(self, until: float) -> None:
        while (c := self._next_contact(until)) >= 0:
            airborne = self.contacts.airborne[c]
            instants = self.contacts.last_lift_off if airborne else self.contacts.last_touchdown
            what = "lift-off" if airborne else "touchdown"
            self._report(f"{self._places[c]}{what} at {instants[c]:.9g} s")

    def report_start(self) -> None:
        """Report the wheels that start in the air."""
        for place, airborne in zip(self._places, self.contacts.airborne, strict=True):
            if airborne:
                self._report(f"{place}wheel in the air at the start")

    def next_after(self, present: float) -> float:
        """Return the time of the next switch that is known; inf if none."""
        coming = inf
        for time, *_ in reversed(self._switches):
            if time <= present:
                break
            coming = time
        return coming

    def forget_after(self, present: float) -> None:
        """Delete the switches after a time to which the integrator has returned."""
        while self._switches and self._switches[-1][0] > present:
            self._switches.pop()

    def forget_waiting(self) -> None:
        """Discard what waits for its time, after a return to the present time."""
        self._run.contacts.forget_waiting()
        self._stops.clear()

    def coming(self, present: float) -> list[Any]:
        """Return the switches after the present time, and what is known of end stops."""
        after = takewhile(lambda switch: switch[0] > present, reversed(self._switches))
        return [[*after][::-1], [*self._stops], sorted(self._met)]

    def resume(self, present: float, coming: list[Any]) -> None:
        """Return to a time, with what was `coming` then."""
        self.forget_after(present)
        switches, stops, met = coming
        self._switches.extend(map(tuple, switches))
        self._stops, self._met = deque(map(tuple, stops)), set(met)

    def _report(self, text: str) -> None:
        self._messages.append(("event", text))
