"""One step of a method as data: the record that adapters hand to error theory."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.tableau import CLASSICAL, Tableau

# the velocity first, then the position with the new velocity
EULER: Final = "semi-implicit-euler"
LEAPFROG: Final = "leapfrog"
RK4: Final = "rk4"  # the classical method
RK4_ADDED_RATES: Final = "rk4, angular velocities of its stages added as vectors"
LINEARLY_IMPLICIT: Final = "linearly implicit euler"  # (1 - h J) k = f, then as EULER
ADAPTIVE: Final = "adaptive"  # controls its local error to a relative tolerance
CLOSED_FORM: Final = "closed-form"  # takes no steps
EXPLICIT = (
    (RK4, CLASSICAL),  # Kutta 1901
)
TABLEAUX: Mapping[str, Tableau] = MappingProxyType(dict(EXPLICIT))
"""Explicit Runge-Kutta methods by their names: all that theory needs of one."""
STEPPED = (EULER, LEAPFROG, *TABLEAUX)  # what smooth motions have a theory of
ORDERS = MappingProxyType(
    {EULER: 1, LINEARLY_IMPLICIT: 1, LEAPFROG: 2, RK4_ADDED_RATES: 2}
    | {name: tableau.order for name, tableau in TABLEAUX.items()}
)
KNOWN = (*ORDERS, ADAPTIVE, CLOSED_FORM)
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
    """A soft constraint that closes a loop: its time constant [s], two steps at least, and its
    impedance d, between 0 and 1 (analytic/numerics.smooth.soft_loop.py)."""

    time_constant: float
    impedance: float
    curved: bool = True  # whether J' q', the change of the constraint's direction, is counted


@dataclass(frozen=True)
class SoftPoint:
    """A point at which bodies touch, regularised as MuJoCo does it; its default contact. Impedances
    are for no depth, and for `width` [m] and more."""

    time_constant: float = 0.02  # [s], two steps at least
    damping_ratio: float = 1.0
    impedance: tuple[float, float] = (0.9, 0.95)
    width: float = 1e-3
    # of friction's impedance; infinite where nothing is left of its softness
    ratio: float = 1.0
    pyramidal: bool = True


@dataclass(frozen=True)
class Scheme:
    """An integrator and its variant. `integrator` is one of KNOWN, or any other name, for which
    there is no theory. Raises ParameterError for a variant that its integrator cannot have.
    """

    integrator: str
    control: Control = "continuous"
    """How a time-dependent forcing is read: at the stages' own times, or held over the step."""
    implicit_damping: float = False  # the part that acts on the velocity after the step (EULER)
    implicit_spring: bool = False  # and a spring on the position after it (EULER)
    position_first: bool = False  # the position moves before the velocity does (EULER)
    tangent_turn: bool = False
    """Whether an attitude q moves along its tangent, by q h w/2, and not along the sphere of
    quaternions (EULER)."""
    joint_closing_rate: float | None = None
    """[1/s] at which a joint solved for velocities closes what it has opened, infinite where it
    closes in one step; None where coordinates keep every joint closed (EULER, position first)."""
    loop: SoftLoop | None = None  # what closes a loop; None where coordinates keep it closed
    # of bodies that touch; None where friction ends slip at once
    contact: SoftPoint | None = None
    jointed_moment: float = 0.0
    """Moment of inertia about its centre of a body held by such a joint, over that about the joint;
    below a quarter."""
    unit: float = 1.0  # in the last place of what a step computes with, in those of a double

    def __post_init__(self) -> None:
        euler = self.integrator == EULER
        rate = self.joint_closing_rate
        part = self.jointed_moment
        damped = self.implicit_damping
        wrong = (
            ("control", self.control, self.control not in _CONTROLS),
            ("implicit_damping", damped, (damped and not euler) or not 0 <= damped <= 1),
            ("implicit_spring", True, self.implicit_spring and damped != 1),
            ("position_first", True, self.position_first and not euler),
            ("position_first", True, self.position_first and damped),
            ("tangent_turn", True, self.tangent_turn and not euler),
            ("joint_closing_rate", rate, rate is not None and not self.position_first),
            ("joint_closing_rate", rate, rate is not None and not rate > 0.0),
            (
                "jointed_moment",
                part,
                not 0.0 <= part < (0.0 if rate is None else 0.25) + 1e-300,
            ),
        )
        for name, value, broken in wrong:
            if broken and self.integrator in KNOWN:
                raise ParameterError(
                    f"scheme, {name}", value, f"something that {self.integrator} can have"
                )

    def __str__(self) -> str:
        words = [self.integrator, _CONTROLS[self.control]]
        words.append("implicit damping" if self.implicit_damping else "")
        words.append("implicit spring" if self.implicit_spring else "")
        words.append("position first" if self.position_first else "")
        if (rate := self.joint_closing_rate) is not None:
            how = "in one step" if math.isinf(rate) else f"at {rate:.3g}/s"
            words.append(f"joints closing {how}")
        return ", ".join(word for word in words if word)

    @property
    def known(self) -> bool:
        """Whether any theory here covers the integrator."""
        return self.integrator in KNOWN

    @property
    def order(self) -> int | None:
        """Order of the global error on a smooth motion; None where there is none, or not known."""
        return ORDERS.get(self.integrator)

    @property
    def position_lead(self) -> float | None:
        """Steps by which a position is ahead of a velocity that is exact at grid times: half of
        one for EULER, half of one behind where the position moves first, none for RK4; None for
        schemes of which that is not known."""
        if self.joint_closing_rate is not None:
            return None
        if self.integrator == RK4:
            return 0.0
        if self.integrator != EULER:
            return None
        return -0.5 if self.position_first else 0.5
