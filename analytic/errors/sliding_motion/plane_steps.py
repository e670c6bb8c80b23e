"""Fixed steps of a body on three Coulomb points with a prescribed slider.

The state is the position z of C on the ground, the heading psi, their rates, and the slider's
position r and velocity v in the body. The slider's acceleration w is constant in a step, at the
mean that brings v to its exact value. With p = e^(-i psi) z', the body's point at the combined
centre of mass has the velocity u = p + i omega mu r, and

    u'     = -mu a,                       a = w + 2 i omega v - omega^2 r,     and friction:
    omega' = -mu M (r x a)/(J + mu M r^2),            (Chernousko 2020, eqs. 2-4 and 23)

where rates are in the body's axes at that moment. Semi-implicit Euler takes these rates at the
start of a step, and friction against the slip at its end. RK4 takes the friction of each stage
against the slip half a step later. Friction that may stop a slip within half a step is stable, and
less late than friction within a whole step. Normal forces are static. Derivation: THEORY.md,
section 7.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    Equations,
    StateParts,
    scheme_step,
    states_after,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.equations import mechanics
from plumbob.analytic.systems.three_points.friction import InitialVelocities
from plumbob.analytic.systems.three_points.implicit_friction import (
    FrictionProblem,
    Slip,
    after_friction,
)

FRICTION_LEADS: Mapping[str, float] = MappingProxyType({EULER: 1.0, RK4: 0.5})
"""Time [steps] by which the slip that friction opposes is later than the rates, by integrator."""
COLUMNS = ("x", "y", "heading", "velocity_x", "velocity_y", "heading_rate")


@dataclass(frozen=True, slots=True)
class CapsuleConstants:
    """The constants of a capsule as plain numbers, which are faster to read than arrays."""

    mass: float  # M + m [kg]
    mass_ratio: float
    reduced_mass: float  # [kg]
    inertia: float  # J [kg m^2]
    supports: tuple[complex, ...]  # [m]
    limits: tuple[tuple[float, float, float], ...]
    """Friction limit f N_i of each support with the slider at C [N], and its change along x and y
    [N/m]."""

    @classmethod
    def of(cls, capsule: Capsule) -> CapsuleConstants:
        """Returns the constants of a capsule."""
        equations = mechanics(capsule)
        limits = np.column_stack([equations.centre_limits, *equations.limit_slopes]).tolist()
        return cls(
            mass=equations.mass,
            mass_ratio=equations.mass_ratio,
            reduced_mass=equations.reduced_mass,
            inertia=equations.body_inertia,
            supports=tuple(equations.supports.tolist()),
            limits=tuple(map(tuple, limits)),
        )

    def rates_with_friction(
        self, q: StateParts, rates: StateParts, w: complex, lead: float, near: Slip
    ) -> tuple[StateParts, Slip]:
        """Returns the rates of change of z', omega and v, and the slip that friction opposes.

        That slip is a time `lead` [s] later. The positions `q` are z, psi and r, the `rates` z',
        omega and v; `w` is the slider's acceleration [m/s^2]. The search for the slip starts from
        `near`.
        """
        _, psi, r = q
        speed, omega, v = rates
        turn = exp(1j * psi)
        arm = self.mass_ratio * r
        relative = w + 2j * omega * v - omega * omega * r  # a of the module docstring
        push = -self.mass_ratio * relative
        spin = -self.reduced_mass * (r.conjugate() * relative).imag / self.inertia_with(r)
        velocity = speed / turn + 1j * omega * arm
        free_slip = (velocity + lead * push, omega + lead * spin)
        slip = self.after_friction(r, lead, free_slip, near)
        push = (slip[0] - velocity) / lead
        spin = (slip[1] - omega) / lead
        return ((push - 1j * spin * arm) * turn, spin, w), slip

    def inertia_with(self, r: complex) -> float:
        """Returns the moment of inertia about the combined centre [kg m^2], the slider at r [m]."""
        return self.inertia + self.reduced_mass * abs(r) ** 2

    def after_friction(
        self, r: complex, lead: float, free: Slip, near: Slip, opened: complex = 0j
    ) -> Slip:
        """Returns the slip after friction has acted for a time `lead` [s] on a `free` slip.

        The slip of each support has a further part: `opened` [1/s] times the support's position.
        The search for the slip starts from `near`.
        """
        limits = []
        for central, along_x, along_y in self.limits:
            limit = central + r.real * along_x + r.imag * along_y
            limits.append(lead * max(limit, 0.0))
        if not any(limits):
            return free
        arms = [support - self.mass_ratio * r for support in self.supports]
        offsets = [opened * support for support in self.supports]
        problem = FrictionProblem(self.mass, self.inertia_with(r), limits, arms, offsets)
        return after_friction(problem, free, near)


@lru_cache(maxsize=64)  # all methods of one scheme share the result
def trajectory(
    capsule: Capsule,
    path: SliderPath,
    start: InitialVelocities,
    integrator: str,
    step: float,
    steps: int,
) -> Array:
    """Returns COLUMNS at the start and after each of `steps` steps of `step` [s].

    The result has the shape (steps + 1, 6), in the axes of the ground. `integrator` is EULER or
    RK4.
    """
    body = CapsuleConstants.of(capsule)
    lead = FRICTION_LEADS[integrator] * step
    places, speeds, _ = path.kinematics(np.arange(steps + 1, dtype=np.float64) * step)
    pushes = (np.diff(speeds @ [1.0, 1j]) / step).tolist()
    speed = complex(*start.velocity)
    omega = start.angular_velocity
    near: Slip = (speed, omega)

    def acceleration(time: float, q: StateParts, rates: StateParts) -> StateParts:
        """Returns the accelerations at the start of a step or in one of its stages. The slip there
        is the first guess of the next one."""
        nonlocal near
        push = pushes[round(time / step)]
        accelerations, near = body.rates_with_friction(q, rates, push, lead, near)
        return accelerations

    advance = scheme_step(Scheme(integrator, "start"), Equations(acceleration, 3), step)
    state = (0j, 0.0, complex(*places[0]), speed, omega, complex(*speeds[0]))
    return columns_of_states(states_after(advance, state, step, range(steps + 1)))


def columns_of_states(states: Sequence[StateParts]) -> Array:
    """Returns COLUMNS of n states (z, psi, r, z', omega, v), shape (n, 6)."""
    z, psi, _, speed, omega, _ = np.array(states).T
    columns = [z.real, z.imag, psi.real, speed.real, speed.imag, omega.real]
    return np.ascontiguousarray(np.transpose(columns))
