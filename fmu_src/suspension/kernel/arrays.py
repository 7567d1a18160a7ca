"""The arrays that all numbers of the kernel stand in; memory is had once, at the start."""

from __future__ import annotations

from array import array


def doubles(values):
    return array("d", values)


def integers(values):
    return array("i", values)


def vectors(count, size):
    return [doubles([0.0] * size) for _ in range(count)]
