"""Factors L D L' of small symmetric positive definite matrices, stored by rows from an offset."""

from __future__ import annotations


def decompose(m, at, n):
    """Factorise into L D L' in place (unit L below, L' above); return 1 if not positive definite."""
    for k in range(n):
        pivot = m[at + k * n + k]
        if not pivot > 0.0:
            return 1
        for i in range(k + 1, n):
            ratio = m[at + i * n + k] / pivot
            for j in range(k + 1, i + 1):
                m[at + i * n + j] -= ratio * m[at + k * n + j]
            m[at + i * n + k] = ratio
        # up to here the row of the pivot served as the column of multipliers
        for i in range(k + 1, n):
            m[at + k * n + i] = m[at + i * n + k]
            for j in range(k + 1, i + 1):
                m[at + j * n + i] = m[at + i * n + j]
    return 0


def solve(m, at, n, x):
    """Overwrite x with the solution y of (L D L') y = x."""
    for i in range(n):
        for k in range(i):
            x[i] -= m[at + i * n + k] * x[k]
    for i in range(n - 1, -1, -1):
        x[i] /= m[at + i * n + i]
        for k in range(i + 1, n):
            x[i] -= m[at + k * n + i] * x[k]
