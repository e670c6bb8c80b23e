"""Coulomb friction of three points as a minimisation. In a time step, friction opposes the slip at
the end of the step. At rest, the minimum decides whether and how the body starts to move.

The unknowns are the body's velocity u at the combined centre and its angular velocity o after the
step. P and w are the same two velocities without friction, kappa is the time over which friction
acts, L_i = f N_i and a_i = CA_i - mu r. The velocities after the step minimise

    (M + m)|u - P|^2/2 + I (o - w)^2/2 + kappa sum L_i |u + o k x a_i|.

This is implicit in the direction of friction, and in whether a support slips. The value is convex,
but not smooth where a support is at rest. If the minimum lies there, either everything rests, or
the body pivots about one support at a rate that is known in closed form. Otherwise Newton's method
finds the minimum. Chernousko 2020, eq. 1, in the manner of Moreau; derived in THEORY.md, section 6.
By Gauss' principle, accelerations from rest minimise the same value with forces for impulses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from plumbob.analytic.systems.three_points.equations import Configuration

MAX_FRICTION_NEWTON_STEPS = 60
# undamped Newton steps that are tried first, from the slip of the previous time step
UNDAMPED_STEPS = 12
ABOVE_ONE = 1.0 + 1e-9  # a number that exceeds 1 by more than rounding
LAST_STEP = 2e-15  # size of the step that ends Newton's method, relative to the velocities
# relative gap between bounds of a load factor; the factor's error is its square
FACTOR_GAP = 1e-9
GAP_PART = 0.9  # part of the gap by which the lower bound of a load factor is raised
SMALLEST_NEWTON_PART = 1e-16  # smallest part of a Newton step
# Largest relative amount by which a force exceeds its friction limit while a support still sticks
EXCESS_ROUNDING = 1e-12

# velocity of the body's point at the combined centre [m/s], and angular velocity [rad/s]
Slip = tuple[complex, float]
ZERO_SLIP: Slip = (0j, 0.0)


class FrictionProblem(NamedTuple):
    """Masses (M + m) [kg] and I [kg m^2], friction impulses kappa L_i [N s] and arms a_i [m].

    `offsets` [m/s] are added to the slips u + o k x a_i; they are too small to matter where a
    support rests. A tuple, because one is made in every time step and a frozen dataclass takes
    three times as long.
    """

    mass: float
    inertia: float
    limits: Sequence[float]
    arms: Sequence[complex]
    offsets: Sequence[complex] = (0j, 0j, 0j)

    def value(self, free: Slip, slip: Slip) -> float:
        """Returns the value that the velocities `slip` minimise [J]; `free` are those without
        friction."""
        (u, o), (p, w) = slip, free
        supports = zip(self.limits, self.arms, self.offsets, strict=True)
        friction = sum(limit * abs(u + 1j * o * arm + v) for limit, arm, v in supports)
        kinetic = 0.5 * self.mass * abs(u - p) ** 2 + 0.5 * self.inertia * (o - w) ** 2
        return kinetic + friction


def after_friction(problem: FrictionProblem, free: Slip, near: Slip) -> Slip:
    """Returns the velocities after a step. They minimise the sum of the kinetic energy relative to
    the velocities `free`, which the step would have without friction, and the work of friction. The
    velocities `near`, from the previous step, are the first guess."""
    force, torque = problem.mass * free[0], problem.inertia * free[1]
    if surely_sticks(problem.limits, problem.arms, force, torque):
        return ZERO_SLIP
    slip = _moving_minimum(problem, free, near)
    if slip is not None:
        return slip
    factor, direction = load_factor(problem.limits, problem.arms, force, torque)
    if factor <= 1.0 + EXCESS_ROUNDING:
        return ZERO_SLIP
    # Offsets are left out: they may be larger than a tiny slip.
    begin = _minimum_along(FrictionProblem(*problem[:4]), free, direction)
    return _moving_minimum(problem, free, begin) or begin


def surely_sticks(
    limits: Sequence[float], arms: Sequence[complex], force: complex, torque: float
) -> bool:
    """Returns True if friction surely balances a force and a torque on the three supports. It does
    if friction forces f N_i (X + Y k x b_i) balance them for some vector X and number Y, where b_i
    are the arms from the centre of the limits f N_i and k is the normal. The condition is
    sufficient, not necessary.

    `limits` f N_i [N]; `arms` [m] of the supports from a point; `force` [N] and `torque` [N m]
    about that point.
    """
    total = sum(limits)
    if not total > 0.0:
        return False
    mean = force / total
    if abs(mean) > ABOVE_ONE:  # the mean of the three vectors that are checked below
        return False
    centre = sum(limit * arm for limit, arm in zip(limits, arms, strict=True)) / total
    levers = [arm - centre for arm in arms]
    spread = sum(limit * abs(lever) ** 2 for limit, lever in zip(limits, levers, strict=True))
    if not spread > 0.0:
        return False
    turning = 1j * (torque - total * (centre.conjugate() * mean).imag) / spread
    return all(abs(mean + turning * lever) <= 1.0 for lever in levers)


def _moving_minimum(problem: FrictionProblem, free: Slip, near: Slip) -> Slip | None:
    """Returns the minimum with the body in motion: a slide found from `near`, a pivot, or a slide
    found from a pivot. Returns None if rest has a lower value than the velocities tried, or if a
    slip vanishes during the search; rest need not be the minimum then."""
    scale = abs(free[0]) + abs(free[1]) * max(map(abs, problem.arms))
    if scale == 0.0:
        return None
    sliding = _newton_minimum(problem, free, near, scale, UNDAMPED_STEPS, damped=False)
    if sliding is not None:
        return sliding
    pivots = [_pivot_candidate(problem, free, support) for support in range(3)]
    for pivot in pivots:
        if pivot.turns and pivot.excess <= 0.0:
            return pivot.slip
    best = min(pivots, key=lambda pivot: problem.value(free, pivot.slip))
    if best.turns:  # its support slips: the search starts a little along its impulse
        direction = best.impulse / abs(best.impulse) * best.excess / problem.mass
        part = _damping_factor(problem, free, best.slip, (direction, 0.0), 0.0)
        begin = best.slip[0] + part * direction, best.slip[1]
        minimum = _newton_minimum(
            problem, free, begin, scale, MAX_FRICTION_NEWTON_STEPS, damped=True
        )
        return minimum or begin
    if problem.value(free, near) < problem.value(free, ZERO_SLIP):
        return _newton_minimum(
            problem, free, near, scale, MAX_FRICTION_NEWTON_STEPS, damped=True
        )
    return None


def _energy_gain(problem: FrictionProblem, free: Slip, slip: Slip) -> float:
    """Returns the energy [J] that the momentum of `free` gives to the velocities `slip`."""
    (u, o), (p, w) = slip, free
    return problem.mass * (p.conjugate() * u).real + problem.inertia * w * o


def _minimum_along(problem: FrictionProblem, free: Slip, direction: Slip) -> Slip:
    """Returns the multiple of the velocities `direction` that has the lowest value. The value must
    fall from rest along `direction`."""
    fall = _energy_gain(problem, free, direction) - problem.value(direction, direction)
    part = fall / _energy_gain(problem, direction, direction)
    return part * direction[0], part * direction[1]


def load_factor(
    limits: Sequence[float], arms: Sequence[complex], force: complex, torque: float
) -> tuple[float, Slip]:
    """Returns the load factor of static friction under a wrench, and the velocities, of any size,
    with which the body would start to move. The body sticks if the factor is at most 1.

    The factor is the largest (wrench . q)/sum f N_i |v_i(q)| over velocities q. `limits` f N_i [N]
    and `arms` from G [m], shape (3,); `force` [N] and `torque` [N m] about G. The body moves under
    the wrench divided by any number below the factor. The nearer this number is to the factor, the
    slower the body moves, and the smaller is the error of the factor from its velocities: it is of
    second order in the speed.
    """
    reach = math.sqrt(sum(abs(arm) ** 2 for arm in arms) / 3)
    total = sum(limits)
    size = math.hypot(abs(force), torque / reach)
    if not math.isfinite(size):
        raise OverflowError("a double does not hold the size of the wrench")
    if size == 0.0:
        return 0.0, ZERO_SLIP
    slip: Slip = (complex(force / size), float(torque / size) / reach**2)
    if not total > 0.0:
        return math.inf, slip
    problem = FrictionProblem(1.0, reach**2, [limit / total for limit in limits], arms)
    # Rotations about each support give a first lower bound on the factor.
    factor = lower = 0.0
    for pivot, arm in enumerate(arms):
        moment, largest_moment = _pivot_moments(problem, slip, pivot)
        if moment and not largest_moment:
            return math.inf, (-1j * moment * arm, moment)
        if largest_moment:
            lower = max(lower, 0.5 * abs(moment) / largest_moment)
    # Under the wrench divided by the lower bound the body moves, and its velocities give a larger
    # bound.
    pull = slip
    while factor == 0.0 or factor - lower > FACTOR_GAP * factor:
        lower += GAP_PART * max(factor - lower, 0.0)
        free = pull[0] / lower, pull[1] / lower
        candidate = _minimum_along(problem, free, slip) if factor else free
        candidate = _moving_minimum(problem, free, candidate) or candidate
        if problem.value(free, candidate) >= problem.value(free, ZERO_SLIP):
            break
        slip = candidate
        factor = _energy_gain(problem, pull, slip) / problem.value(slip, slip)
    return size / total * factor, slip


def _pivot_moments(problem: FrictionProblem, free: Slip, pivot: int) -> tuple[float, float]:
    """Returns the moment about support `pivot` that cancels the slip `free`, which the body would
    have without friction; and the largest moment about the pivot that friction on the other
    supports can exert [N m s]."""
    arm = problem.arms[pivot]
    p, w = free
    moment = problem.inertia * w - problem.mass * (p * (1j * arm).conjugate()).real
    supports = zip(problem.limits, problem.arms, strict=True)
    return moment, sum(limit * abs(other_arm - arm) for limit, other_arm in supports)


class PivotCandidate(NamedTuple):
    """Velocities with one support at rest."""

    slip: Slip
    excess: float  # [N s] impulse that keeps the support at rest, less its limit
    impulse: complex  # [N s]

    @property
    def turns(self) -> bool:
        """Whether the body turns about the support."""
        return self.slip[1] != 0.0


def _pivot_candidate(problem: FrictionProblem, free: Slip, pivot: int) -> PivotCandidate:
    """Returns the velocities with the support `pivot` at rest. They are zero if friction on the
    other supports prevents the turn."""
    arm = problem.arms[pivot]
    moment, largest_moment = _pivot_moments(problem, free, pivot)
    if abs(moment) <= largest_moment:
        return PivotCandidate(ZERO_SLIP, math.inf, 0j)
    inertia = problem.inertia + problem.mass * abs(arm) ** 2
    o = (moment - math.copysign(largest_moment, moment)) / inertia
    u = -1j * o * arm
    friction = 0j
    for support, (limit, other_arm) in enumerate(
        zip(problem.limits, problem.arms, strict=True)
    ):
        if support != pivot:
            friction += limit * (other_arm - arm) / abs(other_arm - arm)
    impulse = problem.mass * (free[0] - u) - math.copysign(1.0, o) * 1j * friction
    excess = abs(impulse) - problem.limits[pivot] * (1.0 + EXCESS_ROUNDING)
    return PivotCandidate((u, o), excess, impulse)


def _newton_minimum(
    problem: FrictionProblem,
    free: Slip,
    begin: Slip,
    scale: float,
    max_steps: int,
    *,
    damped: bool,
) -> Slip | None:
    """Returns the slip (u, o) that minimises the value of the module's equation, by at most
    `max_steps` steps of Newton's method from `begin`. u is a velocity [m/s], o an angular velocity
    [rad/s]. Returns None if a slip vanishes during the search, or if undamped steps do not
    converge. `scale` [m/s] is the size of the velocities."""
    u, o = begin
    reach = max(map(abs, problem.arms))
    for _ in range(max_steps):
        newton = _newton_step(problem, free, (u, o), LAST_STEP * scale)
        if newton is None:
            return None
        (du, do), slope = newton
        part = _damping_factor(problem, free, (u, o), (du, do), slope) if damped else 1.0
        u = u + part * du
        o = o + part * do
        if abs(du) + abs(do) * reach <= LAST_STEP * scale:
            return u, o
    return (u, o) if damped else None


def _newton_step(
    problem: FrictionProblem, free: Slip, slip: Slip, smallest_speed: float
) -> tuple[Slip, float] | None:
    """Returns Newton's step for the minimum of `FrictionProblem.value` [J] at the velocities
    `slip`, linear u and angular o, and the slope of that value along the step [J].

    If a support's slip changes by w, its friction changes in proportion to (w - e^2 w*)/2, the part
    of w across the direction e of the slip. Returns None if a support slips by `smallest_speed`
    [m/s] or less, where the value has no derivative, or if the equations of the step are singular.
    """
    # gradient of the value by the linear velocity u and the angular velocity o
    by_u = problem.mass * (slip[0] - free[0])
    by_o = problem.inertia * (slip[1] - free[1])
    # Second derivatives of the value: `stiff` and `twist` by u and u, `bend` by u and o, `spin` by
    # o and o. `_solve_newton` has the equations.
    stiff = 0.0
    twist = 0j
    bend = 0j
    spin = problem.inertia
    for limit, arm, offset in zip(problem.limits, problem.arms, problem.offsets, strict=True):
        v = slip[0] + 1j * slip[1] * arm + offset
        speed = abs(v)
        if speed <= smallest_speed:
            return None
        e = v / speed
        across = limit / speed
        lever = arm.conjugate() * e
        by_u = by_u + limit * e
        by_o = by_o + limit * lever.imag
        stiff = stiff + across
        twist = twist + across * e * e
        bend = bend + across * lever.real * 1j * e
        spin = spin + across * lever.real**2
    step = _solve_newton(problem.mass + 0.5 * stiff, 0.5 * twist, bend, spin, (by_u, by_o))
    if step is None:
        return None
    return step, (by_u.conjugate() * step[0]).real + by_o * step[1]


def _solve_newton(
    stiff: float, twist: complex, bend: complex, spin: float, gradient: Slip
) -> Slip | None:
    """Returns the velocities (u, o) that solve stiff u - twist u* + bend o = -gradient[0] and
    Re(bend* u) + spin o = -gradient[1], or None if the equations are singular."""
    determinant = stiff**2 - abs(twist) ** 2
    if not determinant > 0.0:
        return None
    # solutions u of the first equation for the right-hand sides gradient[0] and bend
    from_gradient = (stiff * gradient[0] + twist * gradient[0].conjugate()) / determinant
    from_bend = (stiff * bend + twist * bend.conjugate()) / determinant
    spin -= (bend.conjugate() * from_bend).real
    if not spin > 0.0:
        return None
    o = ((bend.conjugate() * from_gradient).real - gradient[1]) / spin
    return -from_gradient - o * from_bend, o


def _damping_factor(
    problem: FrictionProblem, free: Slip, slip: Slip, step: Slip, slope: float
) -> float:
    """Returns the part of the Newton step `step` after which the value has fallen enough (Armijo's
    condition with the `slope` along the step)."""
    level = problem.value(free, slip)
    part = 1.0
    while part > SMALLEST_NEWTON_PART:
        trial = (slip[0] + part * step[0], slip[1] + part * step[1])
        if problem.value(free, trial) <= level + 1e-4 * part * slope:
            break
        part *= 0.5
    return part


def onset_acceleration(
    mass: float, terms: Configuration, force: complex, torque: float
) -> Slip:
    """Returns the accelerations with which a body at rest starts to move under a `force` [N] and a
    `torque` [N m] about G, the common centre of mass of body and slider: the linear acceleration of
    the body's point at G (complex [m/s^2], body axes) and the angular one [rad/s^2]. Both are 0 if
    the body sticks. `mass` is the sum of both masses [kg]."""
    limits = terms.limits[0].tolist()
    arms = terms.arms[0].tolist()
    inertia = float(terms.inertia[0])
    factor, _ = load_factor(limits, arms, force, torque)
    if factor <= 1.0 + EXCESS_ROUNDING:
        return ZERO_SLIP
    without_friction = (force / mass, torque / inertia)
    problem = FrictionProblem(mass, inertia, limits, arms)
    # The accelerations without friction are also the first guess of the search.
    return after_friction(problem, without_friction, without_friction)


def slip_acceleration(
    mass: float, terms: Configuration, support: int, needed: complex
) -> complex:
    """Returns the acceleration [m/s^2] with which a `support` that was at rest starts to slip while
    the rest of the body moves. The force `needed` [N] to keep it at rest exceeds its limit f N."""
    arm = complex(terms.arms[0, support])
    inertia = float(terms.inertia[0])
    lever = 1j * arm
    limit = float(terms.limits[0, support])
    free = -needed / mass - lever * (lever.conjugate() * needed).real / inertia
    # The other supports slide already and their forces are part of `needed`, so their limits are 0
    # here and their arms are arbitrary.
    problem = FrictionProblem(mass, inertia, (limit, 0.0, 0.0), (arm, arm + 1.0, arm + 1j))
    linear, angular = after_friction(problem, (free, 0.0), (free, 0.0))
    return linear + angular * lever
