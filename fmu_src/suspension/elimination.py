"""Gaussian elimination for small symmetric matrices; FMUs do not use numpy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

Matrix = Sequence[Sequence[float]]


def pivot_rows(matrix: Matrix) -> Iterator[list[float]]:
    """Yield each row once the rows above it are eliminated from it; its pivot is on the diagonal.

    Columns beyond the square, such as right-hand sides, are carried along.

    Raises
    ------
    ZeroDivisionError : a row is asked for beyond one whose pivot is 0.
    """
    rows = [list(row) for row in matrix]
    for k, row in enumerate(rows):
        yield row
        for other in rows[k + 1 :]:
            ratio = other[k] / row[k]
            other[:] = [x - ratio * y for x, y in zip(other, row, strict=True)]


def solve(matrix: Matrix, right: Sequence[float]) -> list[float]:
    """Return x with A x = b, where A is symmetric and positive definite."""
    rows = list(pivot_rows([[*row, b] for row, b in zip(matrix, right, strict=True)]))
    x = [0.0] * len(right)
    for i, row in reversed(list(enumerate(rows))):
        x[i] = (row[-1] - sum(row[j] * x[j] for j in range(i + 1, len(x)))) / row[i]
    return x
