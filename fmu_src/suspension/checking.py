"""Checks of a user-defined system or characteristic, which report errors as sentences.

>>> from math import inf
>>> from phaseplane.suspension.characteristics import Characteristic, Piece
>>> from phaseplane.suspension.checking import check_characteristic
>>> torn = Characteristic((Piece(-inf, 0.0, (0.0, 2e4, 0.0, 0.0)),
...                        Piece(0.05, 0.05, (900.0, 5e4, 0.0, 0.0))))
>>> print(*check_characteristic(torn, "spring"), sep="\\n")
spring: the force jumps by -100 N at the corner 0.05; pieces must join
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import inf, isfinite
from operator import mul

from .characteristics import Characteristic, driving_rate
from .elimination import Matrix, pivot_rows
from .engine import Integrator
from .pieces import LEAST_SCALE
from .reasons import why_stopped
from .signals import GAUSS
from .systems import Element, System
from .units import counted

_CLOSE = 1e-5  # relative difference that counts as agreement with a difference quotient


def check_system(system: System) -> list[str]:
    """Return the errors found in a system, one sentence each.

    Checks shapes and names; symmetry and definiteness of the mass matrix; every characteristic (see
    `check_characteristic`); dampers that add energy; kerbs after time 0 that push without limit; the
    stability of rest. If all these hold, checks that the integrator's accelerations agree with the
    elements' forces, and that energy is balanced.

    Parameters
    ----------
    system : any system; it is not changed
    """
    findings = [*_shapes(system), *_mass(system.mass)]
    for element in system.elements:
        findings += _element(element)
    findings = findings or [*system.kerbs_without_limit(0.0), *_tangent_at_rest(system)]
    return findings or [*_motion(system)]


def check_numbers(system: System) -> list[str]:
    """Return the errors that depend on the numbers in a system, not on its form.

    A small part of `check_system`, cheap enough for every set of parameters: shapes and finite numbers,
    the mass matrix, dampers that add energy, and the stability of rest. Kerbs that push without limit are
    for the integrator to refuse, which knows when the run starts.
    """
    findings = [*_shapes(system), *_mass(system.mass)]
    for element in system.elements:
        findings += _adds_energy(element)
    return findings or [*_tangent_at_rest(system)]


def check_characteristic(law: Characteristic, name: str = "characteristic") -> list[str]:
    """Return the errors found in a characteristic, one sentence each.

    Checks that forces are finite, and continuous at the corners; that the tangent agrees with
    differences of the force, and the potential with its work; that no corner is missing from
    `corners`; and that the pieces, which the integrator evaluates, give the same force. It looks at
    both sides of zero, up to twice the farthest corner and at least to 0.2.

    Parameters
    ----------
    law : any object with `force`, `tangent`, `potential`, `corners` and `pieces`
    name : its name in the sentences
    """
    wanted = ("force", "tangent", "potential", "corners", "pieces")
    if missing := [part for part in wanted if not hasattr(law, part)]:
        return [f"{name}: has no {', '.join(missing)}; a characteristic has {', '.join(wanted)}"]
    order = list(_pieces_in_order(law, name))
    if order:
        return order
    corners = tuple(law.corners)
    reach = max([0.1, *map(abs, corners)]) * 2.0
    stretches = list(pairwise((-reach, *corners, reach)))
    points = [a + (b - a) * f for a, b in stretches for f in (0.03, 0.31, 0.5, 0.77, 0.97)]
    values = [law.force(x) for x in points]
    for x, value in zip(points, values, strict=True):
        if not isfinite(value):
            return [f"{name}: the force at {x:g} is {value}; it must be finite"]
    size = max(map(abs, values)) or 1.0
    return [
        *_joints(law, name, size),
        *_same_as_pieces(law, name, points, size),
        *_tangents(law, name, points, stretches, size),
        *_work(law, name, stretches, size),
        *_hidden_corners(law, name, stretches, size),
    ]


def _pieces_in_order(law: Characteristic, name: str) -> Iterator[str]:
    starts = [piece.start for piece in law.pieces]
    if not starts or starts[0] != -inf:
        yield f"{name}: the first piece must start at minus infinity"
    for a, b in pairwise(starts):
        if not a < b:
            yield f"{name}: pieces must ascend, but one from {b:g} follows one from {a:g}"
    for piece in law.pieces:
        if not piece.scale >= LEAST_SCALE:
            yield (
                f"{name}: the scale of the saturating term must be at least {LEAST_SCALE:g}, "
                f"{piece.scale:g} given"
            )
    for piece, end in zip(law.pieces, (*starts[1:], inf), strict=True):
        if piece.power and piece.exponent < 1.0 and piece.start <= piece.origin <= end:
            yield (
                f"{name}: the slope of the power law with exponent {piece.exponent:g} is infinite at "
                f"{piece.origin:g}; leave that to a piece without it"
            )
    if tuple(law.corners) != tuple(starts[1:]):
        yield f"{name}: corners are {law.corners}, but its pieces meet at {tuple(starts[1:])}"


def _joints(law: Characteristic, name: str, size: float) -> Iterator[str]:
    for left, right in pairwise(law.pieces):
        x = right.start
        jump = right.force(x) - left.force(x)
        if abs(jump) > 1e-9 * max(size, abs(left.force(x))):
            yield f"{name}: the force jumps by {jump:g} N at the corner {x:g}; pieces must join"


def _same_as_pieces(
    law: Characteristic, name: str, points: Iterable[float], size: float
) -> Iterator[str]:
    plain = Characteristic(law.pieces)
    for x in points:
        if abs(plain.force(x) - law.force(x)) > 1e-9 * size:
            yield (
                f"{name}: force({x:g}) = {law.force(x):g} N, but its pieces, which the integrator "
                f"evaluates, give {plain.force(x):g} N"
            )
            return


def _tangents(
    law: Characteristic,
    name: str,
    points: Iterable[float],
    stretches: Sequence[tuple[float, float]],
    size: float,
) -> Iterator[str]:
    starts = [a for a, _ in stretches]
    for x in points:
        a, b = stretches[bisect_right(starts, x) - 1]
        room = min(x - a, b - x)
        h = 1e-3 * room  # fourth-order difference, inside the piece
        slope = (
            8.0 * (law.force(x + h) - law.force(x - h))
            - law.force(x + 2 * h)
            + law.force(x - 2 * h)
        ) / (12.0 * h)
        allowed = _CLOSE * abs(slope) + 1e-14 * size / h + _CLOSE * size / room * 1e-3
        if not abs(law.tangent(x) - slope) <= allowed:
            yield (
                f"{name}: tangent({x:g}) = {law.tangent(x):g}, but differences of the force give "
                f"{slope:g}"
            )
            return


def _work(
    law: Characteristic, name: str, stretches: Sequence[tuple[float, float]], size: float
) -> Iterator[str]:
    if abs(law.potential(0.0)) > 1e-9 * size:
        yield f"{name}: potential(0) = {law.potential(0.0):g} J; it must be 0"
    for a, b, panels in _intervals(law, stretches):
        panel = (b - a) / panels
        nodes = [(a + (k + node) * panel, weight) for k in range(panels) for node, weight in GAUSS]
        work = panel * sum(weight * law.force(x) for x, weight in nodes)
        found = law.potential(b) - law.potential(a)
        if not abs(found - work) <= _CLOSE * (abs(work) + 1e-3 * size * (b - a)):
            yield (
                f"{name}: the potential rises by {found:g} J from {a:g} to {b:g}, but the work of "
                f"the force is {work:g} J"
            )
            return


def _intervals(
    law: Characteristic, stretches: Sequence[tuple[float, float]]
) -> Iterator[tuple[float, float, int]]:
    """Yield intervals whose work is found, and the number of panels in each.

    For a cubic, as between the points of a table, one panel is exact.
    """
    for (a, b), piece in zip(stretches, law.pieces, strict=True):
        if type(law) is Characteristic and not (piece.saturation or piece.power or piece.own):
            yield a, b, 1
        else:
            for f in (0.0, 0.25, 0.5, 0.75):
                yield a + (b - a) * f, a + (b - a) * (f + 0.25), 16


def _hidden_corners(
    law: Characteristic, name: str, stretches: Sequence[tuple[float, float]], size: float
) -> Iterator[str]:
    """Report intervals in which the change of slope does not vanish as the interval shrinks.

    Polynomials, as between the points of a table, have none.
    """
    made_of_pieces = type(law) is Characteristic
    for (a, b), piece in zip(stretches, law.pieces, strict=True):
        if made_of_pieces and piece.own is None and not piece.power:
            continue
        width = (b - a) / 256
        low = max((a + (k + 0.25) * width for k in range(255)), key=lambda x: _bend(law, x, width))
        first = _bend(law, low, width)
        while width > 1e-6 * (b - a):
            width *= 0.5
            low = max((low, low + width), key=lambda x: _bend(law, x, width))
        if _bend(law, low, width) > max(0.1 * first, 1e-4 * size / (b - a)):
            yield (
                f"{name}: the slope jumps near {low + 0.5 * width:g}, inside a piece; corners must "
                "be declared, so that steps end on them"
            )


def _bend(law: Characteristic, x: float, width: float) -> float:
    """Return the change of slope over a short interval from x."""
    left, middle, right = (law.force(x + s * width) for s in (0.0, 0.5, 1.0))
    return abs(right - 2.0 * middle + left) / (0.5 * width)


def _shapes(system: System) -> Iterator[str]:
    n = len(system.coordinates)
    if len(system.mass) != n or any(len(row) != n for row in system.mass):
        yield f"mass: must have {n} rows of {n}, one for each coordinate"
    if len(set(system.coordinates)) < n:
        yield "coordinates: two have the same name"
    if len(system.scales) != n or not all(0.0 < scale < inf for scale in system.scales):
        yield f"scales: must be {n} positive displacements, {system.scales} given"
    names = [element.name for element in system.elements]
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        yield f"{name}: two elements have this name"
    for element in system.elements:
        yield from _direction(element.direction, n, element.name)
        if element.road and element.road not in system.signals:
            yield f"{element.name}: its road {element.road!r} is not among the signals"
        if not element.limit > 0.0:
            yield f"{element.name}: limit = {element.limit:g} must be positive (infinite for none)"
    for name, signal in system.signals.items():
        for segment in signal.segments:
            numbers = (segment.origin, *segment.coefficients, segment.amplitude, *segment.phase)
            if not all(abs(x) < inf for x in numbers):
                yield f"signal {name}: from {segment.start:g} s on it is not finite, {segment}"
    for load in system.loads:
        yield from _direction(load.direction, n, f"load {load.signal}")
        if load.signal not in system.signals:
            yield f"load {load.signal}: is not among the signals"
    yield from _readings(system)


def _direction(numbers: Sequence[float], n: int, name: str) -> Iterator[str]:
    if not (len(numbers) == n and any(numbers) and all(abs(x) < inf for x in numbers)):
        yield f"{name}: direction must have {counted(n, 'finite number')}, not all 0"


def _readings(system: System) -> Iterator[str]:
    """Check what further outputs are read from."""
    n, names = len(system.coordinates), [element.name for element in system.elements]
    for k, axle in enumerate(system.axles, 1):
        of = f"axle {axle.prefix.rstrip('_') or k}"
        if axle.road not in system.signals:
            yield f"{of}: its road {axle.road!r} is not among the signals"
        if axle.tyre and axle.tyre not in names:
            yield f"{of}: its tyre {axle.tyre!r} is not among the elements"
        if len(axle.suspension) != n:
            yield f"{of}: suspension must have {n} numbers"
    for motion in system.motions:
        if len(motion.direction) != n:
            yield f"{motion.names[0]}: direction must have {n} numbers"


def _mass(mass: Sequence[Sequence[float]]) -> Iterator[str]:
    n = len(mass)
    if any(len(row) != n for row in mass):
        return
    for i in range(n):
        for j in range(i):
            if mass[i][j] != mass[j][i]:
                yield (
                    f"mass: not symmetric, {mass[i][j]:g} in row {i + 1} and {mass[j][i]:g} in "
                    f"column {i + 1}"
                )
    if not _definite(mass):
        yield "mass: not positive definite; some motion would have no inertia"


def _definite(matrix: Matrix) -> bool:
    """Return whether every pivot of the elimination is positive."""
    return all(0.0 < row[k] < inf for k, row in enumerate(pivot_rows(matrix)))


def _element(element: Element) -> Iterator[str]:
    laws = (("spring", element.spring), ("damper", element.damper))
    for kind, law in (*laws, ("modulation", element.modulation)):
        yield from check_characteristic(law, f"{element.name}.{kind}")
    yield from _adds_energy(element)


def _adds_energy(element: Element) -> Iterator[str]:
    rate = driving_rate(element.damper)
    if rate is not None:
        yield f"{element.name}.damper: adds energy at {rate:g} m/s; it must oppose the motion"
    for d in (-1.0, -0.1, 0.0, 0.1, 1.0, *element.modulation.corners):
        if element.modulation.force(d) < 0.0:
            yield f"{element.name}.modulation: negative at {d:g} m; the damper would add energy"
            break


def _tangent_at_rest(system: System) -> Iterator[str]:
    """Check that K = sum b k b' is not negative in any direction; rest would be unstable."""
    n = len(system.mass)
    tangent = [[0.0] * n for _ in range(n)]
    size = 0.0
    for element in system.elements:
        b, k = element.direction, element.spring.tangent(0.0)
        size += sum(abs(k) * x * x for x in b)
        for i in range(n):
            for j in range(n):
                tangent[i][j] += b[i] * b[j] * k
    for i in range(n):
        tangent[i][i] += 1e-9 * size
    if size > 0.0 and not _definite(tangent):
        yield "the tangent stiffness at rest is negative in some direction: rest is unstable"


def _motion(system: System) -> Iterator[str]:
    """Check the integrator's forces against those of the elements, and its energy balance."""
    integrator = Integrator(system, tolerance=1e-9)
    n = len(system.mass)
    q = [(0.7 - 0.4 * i) * system.scales[i] for i in range(n)]
    v = [(0.5 + 0.3 * i) * system.scales[i] for i in range(n)]
    integrator.set_state(q, v)
    integrator.sample(0.0)
    integrator.sample_forces(0.0)
    a, forces = list(integrator.sample_a), list(integrator.sample_f)
    energy = 0.5 * sum(v[i] * system.mass[i][j] * v[j] for i in range(n) for j in range(n))
    for element, found in zip(system.elements, forces, strict=True):
        road = system.signals[element.road].derivatives(0.0) if element.road else (0.0, 0.0)
        d = sum(map(mul, element.direction, q)) - road[0]
        w = sum(map(mul, element.direction, v)) - road[1]
        energy += abs(element.spring.potential(d))
        own = element.damper.force(w) * element.modulation.force(d) + element.spring.force(d)
        own = element.limit if d > element.opening else min(own, element.limit)
        plain = element.yield_force == element.series == inf and element.friction == 0.0
        if plain and abs(own - found) > 1e-9 * (abs(own) + abs(found)):
            yield f"{element.name}: the integrator has {found:g} N, but its laws give {own:g} N"
    for i in range(n):
        terms = [system.mass[i][j] * a[j] for j in range(n)]
        terms += [e.direction[i] * f for e, f in zip(system.elements, forces, strict=True)]
        terms += [
            -load.direction[i] * system.signals[load.signal].value(0.0) for load in system.loads
        ]
        if abs(sum(terms)) > 1e-9 * sum(map(abs, terms)):
            yield f"{system.coordinates[i]}: its equation of motion is violated by {sum(terms):g} N"
    step = integrator.stable_step()
    status = integrator.advance(10.0 * (step if step > 0.0 else 0.1))
    if status:
        where = f"at {integrator.time:.6g} s"
        yield f"a short run fails: {why_stopped(status, where, integrator, system)}"
        return
    _, _, dissipated, works = integrator.energies()
    residual = integrator.energy_residual()
    if abs(residual) > 1e-4 * (energy + sum(map(abs, (*dissipated, *works)))):
        yield f"a short run loses {residual:g} J that no element accounts for"
