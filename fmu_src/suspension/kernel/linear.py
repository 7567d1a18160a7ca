"""Factors L D U of small positive definite matrices, stored by columns from an offset."""

from __future__ import annotations

from .language import Doubles


def decompose(m: Doubles, at: int, n: int) -> int:
    """Factorise into L D U in place, without exchanging rows (L below, U above, both with ones).

    Return 1 if a pivot is not positive. Those of a matrix with positive definite symmetric part are.
    """
    for k in range(n):
        pivot = m[at + k * n + k]
        if not pivot > 0.0:
            return 1
        for i in range(k + 1, n):
            below, above = m[at + k * n + i] / pivot, m[at + i * n + k] / pivot
            for j in range(k + 1, i):
                m[at + j * n + i] -= below * m[at + j * n + k]
                m[at + i * n + j] -= above * m[at + k * n + j]
            m[at + i * n + i] -= below * m[at + i * n + k]
        # up to here row and column of the pivot served as multipliers
        for i in range(k + 1, n):
            m[at + k * n + i] /= pivot
            m[at + i * n + k] /= pivot
    return 0


def solve(m: Doubles, at: int, n: int, x: Doubles) -> None:
    """Overwrite x with the solution y of (L D U) y = x."""
    for i in range(n):
        for k in range(i):
            x[i] -= m[at + k * n + i] * x[k]
    for i in range(n - 1, -1, -1):
        x[i] /= m[at + i * n + i]
        for k in range(i + 1, n):
            x[i] -= m[at + k * n + i] * x[k]
