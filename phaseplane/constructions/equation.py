"""The construction of any equation of second order, x'' + f(x', x, t) = 0.

With x' = Omega x-bar the normal goes through D = (-delta, 0), x + delta = f / Omega^2. The auxiliary
curves x = -epsilon(x-bar; x_i), epsilon = f(Omega x-bar, x_i, 0) / Omega^2 - x_i, hold at t = 0. The
change of f since then shifts D from A*.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from phaseplane.constructions.construction import CONTACT, Window
from phaseplane.constructions.control import Before, moved
from phaseplane.constructions.laws import check
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.one_plane import one_plane_scheme
from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.sheet import plane_at
from phaseplane.constructions.steps import States
from phaseplane.constructions.switched import SwitchedPlane, schemes_with_switches
from phaseplane.equations.switching import Mode, Switching, smooth

Function = Callable[[float, float, float], float]
"""f(x', x, t) of x'' + f = 0."""


@dataclass(frozen=True)
class EquationPlane(SwitchedPlane):
    """The phase plane of x'' + f(x', x, t) = 0.

    Parameters
    ----------
    function : f(x', x, t), or an equation with its switches
    autonomous : whether f is independent of t
    angular_frequency : Omega, rad/s, sets the scale of the x-bar axis; choose about that of the
        motion
    scale : of the sheet, m of paper per unit of x
    initial_displacement, initial_velocity : x and x' at time 0
    auxiliary_levels : x_i of the auxiliary curves, between which A is interpolated; empty: A is on
        the curve through P's x
    words : the equation as text, for the title
    unit : of x

    Raises
    ------
    ValueError : if frequency or scale are not positive, or an initial value or f at the start is not
        finite.
    """

    function: Function | Switching
    autonomous: bool = False
    angular_frequency: float = 1.0
    scale: float = 0.02
    initial_displacement: float = 0.0
    initial_velocity: float = 0.0
    auxiliary_levels: tuple[float, ...] = ()
    words: str = "x'' + f(x', x, t) = 0"
    unit: str = ""

    def __post_init__(self) -> None:
        check(
            self,
            positive=("angular_frequency", "scale"),
            finite=("initial_displacement", "initial_velocity", "initial_force"),
        )

    @property
    def title(self) -> str:
        """The equation and the kind of drawing."""
        return f"{self.words} in its phase plane"

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """How the points are joined; along switches and at rest, too, if there are switches."""
        plain = one_plane_scheme(
            "f does not change with time: D is A*."
            if self.switching.autonomous
            else "From A* along the x axis by the change of f since the start, averaged over the "
            "step: D.",
            "x",
        )
        return schemes_with_switches(plain) if self.switching.guards else {CONTACT: plain}

    @cached_property
    def switching(self) -> Switching:
        """The equation, with its switches."""
        given = self.function
        return given if isinstance(given, Switching) else smooth(given, self.autonomous)

    @property
    def initial_force(self) -> float:
        """The value of f at time 0."""
        return self.switching.value(self.initial_velocity, self.initial_displacement, 0.0)

    @cached_property
    def lienard(self) -> Lienard:
        """The plane with its auxiliary curves."""
        omega, value = self.angular_frequency, self.switching.value
        return Lienard(
            plane_at("displacement", "", omega, 0j, 1.0, self.scale, label="x", unit=self.unit),
            lambda x_bar, x: value(omega * x_bar, x, 0.0) / omega**2 - x,
            levels=self.auxiliary_levels,
            guards=self.guards,
        )

    def epsilon_in(self, mode: Mode) -> Callable[[float, float], float]:
        """Return the branch of the auxiliary curves that belongs to a mode without sliding."""
        if not mode:
            return self.lienard.epsilon
        omega, function = self.angular_frequency, self.switching.function
        return lambda x_bar, x: function(omega * x_bar, x, 0.0, mode) / omega**2 - x

    @cached_property
    def initial(self) -> States:
        """The state point at time 0."""
        return (self.lienard.state(self.initial_displacement, self.initial_velocity),)

    @cached_property
    def protractor(self) -> complex:
        """The vertex of the turn angle on the sheet."""
        return self.scale * (-3.0 - 4.0j)

    def shift_in(self, mode: Mode, states: States, window: Window) -> float:
        """Return -1/Omega^2 times the change of f since t = 0, averaged over the window.

        Along a switch A is where the acceleration of the time puts it, so that there is nothing to add.
        """
        if self.switching.autonomous or 0 in mode:
            return 0.0
        x, velocity = self.lienard.values(states[0])
        function = self.switching.function
        mean = window.mean(lambda t: function(velocity, x, t, mode))
        return (function(velocity, x, 0.0, mode) - mean) / self.angular_frequency**2

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return displacement, velocity, acceleration read off the sheet (as in AP57 eq. 11)."""
        return moved("", self.lienard.motion(self.points(mode, states, Window(time))))
