"""Records that describe one step of a method, which adapters hand to error theory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.tableau import CLASSICAL, Tableau

EULER: Final = "semi-implicit-euler"
"""The velocity is stepped first, then the position with the new velocity."""
LEAPFROG: Final = "leapfrog"
RK4: Final = "rk4"
"""The classical Runge-Kutta method."""
RK4_ADDED_RATES: Final = "rk4, angular velocities of its stages added as vectors"
LINEARLY_IMPLICIT: Final = "linearly implicit euler"
"""The slope k solves (1 - h J) k = f; then the step is EULER's."""
ADAPTIVE: Final = "adaptive"
"""A solver that controls its local error to a relative tolerance."""
CLOSED_FORM: Final = "closed-form"
"""A method that takes no steps."""
EXPLICIT_TABLEAUX = (
    (RK4, CLASSICAL),  # Kutta 1901
)
TABLEAUX: Mapping[str, Tableau] = MappingProxyType(dict(EXPLICIT_TABLEAUX))
"""Explicit Runge-Kutta methods by name."""
STEPPED_SCHEMES = (EULER, LEAPFROG, *TABLEAUX)
"""Integrators with an error theory on smooth motions."""
SCHEME_ORDERS = MappingProxyType(
    {EULER: 1, LINEARLY_IMPLICIT: 1, LEAPFROG: 2, RK4_ADDED_RATES: 2}
    | {name: tableau.order for name, tableau in TABLEAUX.items()}
)
"""Order of the global error on smooth motions, by integrator."""
KNOWN_SCHEMES = (*SCHEME_ORDERS, ADAPTIVE, CLOSED_FORM)
"""Integrators with a theory."""
Control = Literal["continuous", "start", "midpoint", "mean"]
_CONTROLS = MappingProxyType(
    {
        "continuous": "",
        "start": "control held from the start of a step",
        "midpoint": "control held at its value in the middle of a step",
        "mean": "control held at its mean over a step",
    }
)


@dataclass(frozen=True)
class SoftLoop:
    """A soft constraint that closes a loop (analytic/numerics/smooth/soft_loop.py)."""

    time_constant: float  # [s] at least two steps
    impedance: float  # d, between 0 and 1
    curved: bool = True  # whether J' q', the change of the constraint's direction, is included


@dataclass(frozen=True)
class SoftPoint:
    """A point contact regularised as in MuJoCo, whose defaults these are."""

    time_constant: float = 0.02  # [s] at least two steps
    damping_ratio: float = 1.0
    impedance: tuple[float, float] = (0.9, 0.95)  # at zero depth, and at the depth `width`
    width: float = 1e-3  # [m] depth from which on the impedance is constant
    # Ratio of the softness of the normal force to the softness of friction; infinite: friction is
    # hard
    ratio: float = 1.0
    pyramidal: bool = True  # whether the friction cone is a pyramid
    # Ratio of the depth to `width` at which the impedance's two curves meet
    midpoint: float = 0.5
    power: float = 2.0  # power of both curves
    # Stiffness [1/s^2] and damping [1/s] in place of time constant and damping ratio
    direct: tuple[float, float] | None = None


@dataclass(frozen=True)
class Scheme:
    """An integrator and its variant.

    `integrator` is one of KNOWN_SCHEMES, or any other name, for which there is no theory. Raises
    ParameterError for a variant that the integrator cannot have.
    """

    integrator: str
    control: Control = "continuous"
    """Time at which a forcing is read: the stages' own times, or one time for the whole step."""
    implicit_damping: float = False  # fraction of damping on the velocity after a step (EULER)
    implicit_spring: bool = False  # whether a spring acts on the position after a step (EULER)
    position_first: bool = False  # whether the position moves before the velocity (EULER)
    tangent_turn: bool = False
    """Whether an attitude q moves along its tangent, by q h w/2, and not along the sphere of
    quaternions (EULER)."""
    joint_closing_rate: float | None = None
    """Rate [1/s] at which a joint that is solved for velocities closes its opening; infinite if it
    closes in one step; None if coordinates keep every joint closed (EULER, position first)."""
    loop: SoftLoop | None = None  # constraint of a loop; None if coordinates keep it closed
    contact: SoftPoint | None = None  # soft contact; None if friction ends slip at once
    jointed_moment: float = 0.0
    """Ratio of a jointed body's moment of inertia about its centre to its moment about the joint;
    below a quarter."""
    unit: float = 1.0  # ratio of the rounding of a step's arithmetic to the rounding of doubles

    def __post_init__(self) -> None:
        euler = self.integrator == EULER
        rate = self.joint_closing_rate
        moment = self.jointed_moment
        largest_moment = 0.0 if rate is None else 0.25
        damping = self.implicit_damping
        checks = (
            ("control", self.control, self.control not in _CONTROLS),
            ("implicit_damping", damping, (damping and not euler) or not 0 <= damping <= 1),
            ("implicit_spring", True, self.implicit_spring and damping != 1),
            ("position_first", True, self.position_first and not euler),
            ("position_first", True, self.position_first and damping),
            ("tangent_turn", True, self.tangent_turn and not euler),
            ("joint_closing_rate", rate, rate is not None and not self.position_first),
            ("joint_closing_rate", rate, rate is not None and not rate > 0.0),
            ("jointed_moment", moment, not 0.0 <= moment < largest_moment + 1e-300),
        )
        for name, value, wrong in checks:
            if wrong and self.integrator in KNOWN_SCHEMES:
                requirement = f"something that {self.integrator} can have"
                raise ParameterError(f"scheme, {name}", value, requirement)

    def __str__(self) -> str:
        words = [self.integrator, _CONTROLS[self.control]]
        words.append("implicit damping" if self.implicit_damping else "")
        words.append("implicit spring" if self.implicit_spring else "")
        words.append("position first" if self.position_first else "")
        rate = self.joint_closing_rate
        if rate is not None:
            speed = "in one step" if math.isinf(rate) else f"at {rate:.3g}/s"
            words.append(f"joints closing {speed}")
        return ", ".join(word for word in words if word)

    @property
    def known(self) -> bool:
        """Whether any theory covers the integrator."""
        return self.integrator in KNOWN_SCHEMES

    @property
    def order(self) -> int | None:
        """Order of the global error on a smooth motion; None if there is none, or it is unknown."""
        return SCHEME_ORDERS.get(self.integrator)

    @property
    def position_lead(self) -> float | None:
        """Time [steps] by which a position is ahead of a velocity that is exact at grid times.

        It is 1/2 for EULER, -1/2 if the position moves first, and 0 for RK4. For schemes without
        theory it is None.
        """
        if self.joint_closing_rate is not None:
            return None
        if self.integrator == RK4:
            return 0.0
        if self.integrator != EULER:
            return None
        return -0.5 if self.position_first else 0.5
