"""Laws and signals as text expressions whose numbers are in a vector p."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from phaseplane.suspension.characteristics import Piece
from phaseplane.suspension.signals import Segment


@dataclass(frozen=True, slots=True)
class Law:
    """The place in p of the current piece of a characteristic; `at` < 0 if there is one piece only.

    Parameters
    ----------
    degrees : the powers of s = x - origin that occur in any piece
    saturates : whether any piece has a tanh
    """

    pieces: tuple[Piece, ...]
    degrees: tuple[int, ...]
    saturates: bool
    at: int = -1

    def numbers(self, piece: Piece) -> list[float]:
        """Return origin, coefficients, and height and steepness of the tanh, as in p."""
        tanh = [piece.saturation, 1.0 / piece.scale] if self.saturates else []
        return [piece.origin, *(piece.coefficients[k] for k in self.degrees), *tanh]

    def text(self, x: str) -> str:
        """Return the force at x, by the piece in p or by the only piece."""
        if self.at < 0:
            return piece_text(self.pieces[0], x)
        names = [f"p[{self.at + k}]" for k in range(len(self.numbers(self.pieces[0])))]
        s = f"({x} - {names[0]})"
        text = _horner(dict(zip(self.degrees, names[1:], strict=False)), s)
        return f"{text} + {names[-2]} * tanh({s} * {names[-1]})" if self.saturates else text

    def choosing_text(self, x: str) -> str:
        """Return the force at x, by the piece that contains x."""
        text = piece_text(self.pieces[-1], x)
        for piece, above in zip(self.pieces[-2::-1], self.pieces[:0:-1], strict=True):
            text = f"({piece_text(piece, x)} if {x} < {above.start!r} else {text})"
        return text


def piece_text(piece: Piece, x: str) -> str:
    """Return one piece as an expression."""
    terms = {k: repr(c) for k, c in enumerate(piece.coefficients) if c != 0.0}
    s = f"({x} - {piece.origin!r})" if piece.origin else x
    text = _horner(terms, s)
    if piece.saturation:
        text += f" + {piece.saturation!r} * tanh({s} * {1.0 / piece.scale!r})"
    return text


def _horner(terms: dict[int, str], s: str) -> str:
    """Return sum terms[k] s^k."""
    if not terms:
        return "0.0"
    text = ""
    for k in range(max(terms), -1, -1):
        if text:
            text = f"{s} * ({text})" if k + 1 < max(terms) else f"{s} * {text}"
        if k in terms:
            text = f"{terms[k]} + {text}" if text else terms[k]
    return text if text else "0.0"


def sum_of(terms: Iterable[tuple[float, str]]) -> str:
    """Return sum factor * name, without zero terms."""
    text = "".join(
        f" {'-' if factor < 0.0 else '+'} "
        + (name if abs(factor) == 1.0 else f"{abs(factor)!r} * {name}")
        for factor, name in terms
        if factor
    )
    return text.removeprefix(" + ").replace(" - ", "-", 1 if text.startswith(" - ") else 0) or "0.0"


def degrees_of(all_coefficients: Iterable[Sequence[float]]) -> tuple[int, ...]:
    """Return the powers, 0 to 3, whose coefficient is not zero in at least one of several cubics."""
    rows = list(all_coefficients)
    return tuple(k for k in range(4) if any(row[k] != 0.0 for row in rows))


@dataclass(frozen=True, slots=True)
class Course:
    """The place in p of the current segment of a signal; `at` < 0 if there is one segment only.

    Parameters
    ----------
    degrees : the powers of s = t - origin that occur in any segment
    waves : whether any segment has a cosine
    """

    segments: tuple[Segment, ...]
    degrees: tuple[int, ...]
    waves: bool
    at: int = -1

    @property
    def is_zero(self) -> bool:
        """Whether the signal is zero at all times."""
        return not self.degrees and not self.waves

    def numbers(self, segment: Segment) -> list[float]:
        """Return origin, coefficients, and amplitude and phase of the cosine, as in p."""
        wave = [segment.amplitude, *segment.phase] if self.waves else []
        return [segment.origin, *(segment.coefficients[k] for k in self.degrees), *wave]

    def lines(self, k: int) -> Iterable[str]:
        """Yield value u, rate du and second derivative ddu of signal number k at t."""
        numbers = self.numbers(self.segments[0])
        names = [f"p[{self.at + i}]" if self.at >= 0 else repr(x) for i, x in enumerate(numbers)]
        s = f"s{k}"
        yield f"{s} = t - {names[0]}"
        c = dict(zip(self.degrees, names[1:], strict=False))
        value = _horner(c, s)
        rate = _horner({k - 1: f"{k}.0 * {c[k]}" for k in c if k > 0}, s)
        second = _horner({k - 2: f"{k * (k - 1)}.0 * {c[k]}" for k in c if k > 1}, s)
        if self.waves:
            a, p0, p1, p2 = names[1 + len(self.degrees) :]
            yield f"angle{k} = {p0} + {s} * ({p1} + {s} * {p2})"
            yield f"turn{k} = {p1} + 2.0 * {p2} * {s}"
            cosine, sine = f"{a} * cos(angle{k})", f"{a} * sin(angle{k})"
            value += f" + {cosine}"
            rate += f" - {sine} * turn{k}"
            second += f" - {cosine} * turn{k} * turn{k} - 2.0 * {p2} * {sine}"
        yield f"u{k} = {value}"
        yield f"du{k} = {rate}"
        yield f"ddu{k} = {second}"
