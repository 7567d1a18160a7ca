"""The body of a half car as masses over its two axles."""

from __future__ import annotations

from dataclasses import dataclass

from phaseplane.constructions.laws import check

AXLES = ("front", "rear")


@dataclass(frozen=True)
class BodyMasses:
    """The body as masses over its two axles (AP57 eq. 1).

    Parameters
    ----------
    front_mass, rear_mass, coupling_mass : M1, M2 and M3, kg

    Raises
    ------
    ValueError : if masses are not positive, or M1 M2 is not above M3^2.
    """

    front_mass: float
    rear_mass: float
    coupling_mass: float

    def __post_init__(self) -> None:
        check(self, positive=("front_mass", "rear_mass"))
        if not self.determinant > 0.0:
            raise ValueError(
                f"coupling_mass = {self.coupling_mass:g} kg: its square must be below front_mass times "
                f"rear_mass, {self.front_mass * self.rear_mass:g} kg2"
            )

    @property
    def determinant(self) -> float:
        """Delta = M1 M2 - M3^2, kg^2."""
        return self.front_mass * self.rear_mass - self.coupling_mass**2

    @property
    def compliances(self) -> tuple[float, float]:
        """M2 / Delta and M1 / Delta, 1/kg: acceleration over an axle per force over the same axle."""
        return self.rear_mass / self.determinant, self.front_mass / self.determinant

    @property
    def cross_compliance(self) -> float:
        """M3 / Delta, 1/kg: acceleration over an axle per force over the other axle."""
        return self.coupling_mass / self.determinant

    def accelerations(self, front_force: float, rear_force: float) -> tuple[float, float]:
        """Return x1'' and x2'' under the forces S1 and S2 of the struts, m/s^2 (AP57 eq. 34)."""
        own, cross = self.compliances, self.cross_compliance
        return cross * rear_force - own[0] * front_force, cross * front_force - own[1] * rear_force
