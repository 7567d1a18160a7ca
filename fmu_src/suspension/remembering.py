"""Parameters that remember what was made from them, for runs that differ in a few of them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from functools import wraps
from typing import Any, TypeVar, cast

from .variable import Value

Maker = TypeVar("Maker", bound=Callable[..., Any])


class Remembering(dict[str, Value]):
    """Parameters by name, and the parts made from them, each with what it has read."""

    def __init__(self) -> None:
        super().__init__()
        self.whole = self
        self.parts: dict[Hashable, tuple[Mapping[str, Value], Any]] = {}


class _Reading(dict[str, Value]):
    """Those of the parameters that have been read for one part, now or when it was made before."""

    def __init__(self, whole: Remembering, before: Iterable[str]) -> None:
        super().__init__(zip(before, map(whole.__getitem__, before), strict=True))
        self.whole = whole

    def __missing__(self, name: str) -> Value:
        value = self[name] = self.whole[name]
        return value


def remembered(make: Maker) -> Maker:
    """Let a function of parameters return what it made before, as long as all that it read is the same.

    Only from parameters that are `Remembering`. It reads them by `p[name]`, or hands them on. What
    else it is given must be one of a few things, for a part is kept for each of them.
    """

    @wraps(make)
    def made(p: Any, *how: Hashable) -> Any:
        whole: Remembering | None = getattr(p, "whole", None)
        if whole is None:
            return make(p, *how)
        key = (make, how)
        kept = whole.parts.get(key)
        if kept is None or not kept[0].items() <= whole.items():
            reading = _Reading(whole, kept[0] if kept else ())
            kept = whole.parts[key] = (reading, make(reading, *how))
        if p is not whole:
            p.update(kept[0])  # what a part of a part has read, both have
        return kept[1]

    return cast("Maker", made)
