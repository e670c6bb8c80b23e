"""Coulomb friction of three points as a minimum: in a step it opposes the slip at the step's end,
and at rest it decides how motion starts.

With u the body's velocity at the combined centre and o its rate after the step, P and w those
without friction, kappa the time over which friction acts, L_i = f N_i, a_i = CA_i - mu r,

    (M + m)|u - P|^2/2 + I (o - w)^2/2 + kappa sum L_i |u + o k x a_i|  is least.

That is implicit in the direction of friction, and in whether a support slips. The value is convex,
and not smooth where a support is at rest. If the minimum is there, either everything rests, or the
body pivots about one support at a rate that is known in closed form; else Newton's method finds it.
Chernousko 2020, eq. 1, in the manner of Moreau. Derived in THEORY.md, section 6. By Gauss'
principle accelerations from rest are the same minimum, with forces in place of impulses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from plumbob.analytic.systems.three_points.equations import Configuration

NEWTON_STEPS = 60
QUICK = 12  # undamped steps, from the slip of the time step before
SURELY = 1.0 + 1e-9  # above 1 whatever the rounding
LAST = 2e-15  # of the velocities: a step this small ends Newton's method
NEARLY = 1e-9  # relative: a load factor is known to the square of this
NEARER = 0.9  # of what is left of a load factor
LEAST = 1e-16  # part of a step
STICKS = 1e-12  # relative: a support sticks with a force that is so little above its limit

Slip = tuple[complex, float]  # velocity of the body's point at the combined centre, and rate
REST: Slip = (0j, 0.0)


class FrictionProblem(NamedTuple):
    """Masses (M + m) [kg] and I [kg m^2], friction kappa L_i [N s] and arms a_i [m]; `offsets`
    [m/s] are added to the slips u + o k x a_i, too small to matter where a support rests. Every
    step makes one: a tuple takes a third of the time of a frozen dataclass."""

    mass: float
    inertia: float
    limits: Sequence[float]
    arms: Sequence[complex]
    offsets: Sequence[complex] = (0j, 0j, 0j)

    def value(self, free: Slip, slip: Slip) -> float:
        """The function to be minimised [J]."""
        (u, o), (p, w) = slip, free
        supports = zip(self.limits, self.arms, self.offsets, strict=True)
        drag = sum(c * abs(u + 1j * o * a + g) for c, a, g in supports)
        return 0.5 * self.mass * abs(u - p) ** 2 + 0.5 * self.inertia * (o - w) ** 2 + drag


def after_friction(problem: FrictionProblem, free: Slip, near: Slip) -> Slip:
    """Velocities after a step that would end with `free` without friction; `near`, those after the
    step before, are the first guess."""
    pull = problem.mass * free[0], problem.inertia * free[1]
    if simply_held(problem.limits, problem.arms, *pull):
        return REST
    if (slip := _moving(problem, free, near)) is not None:
        return slip
    factor, way = load_factor(problem.limits, problem.arms, *pull)
    if factor <= 1.0 + STICKS:
        return REST
    begin = _lowest(FrictionProblem(*problem[:4]), free, way)  # offsets may exceed a tiny way
    return _moving(problem, free, begin) or begin


def simply_held(
    limits: Sequence[float], arms: Sequence[complex], force: complex, torque: float
) -> bool:
    """Whether friction f N_i (X + Y k x b_i), with b_i the arms from the centre of the `limits` f
    N_i [N], balances a `force` [N] and a `torque` [N m] about the point that the `arms` [m] are
    from: a sufficient condition."""
    total = sum(limits)
    if not total > 0.0:
        return False
    along = force / total
    if abs(along) > SURELY:  # the mean of the three sums below, each of which is 1 at most
        return False
    centre = sum(limit * arm for limit, arm in zip(limits, arms, strict=True)) / total
    around = [arm - centre for arm in arms]
    spread = sum(limit * abs(arm) ** 2 for limit, arm in zip(limits, around, strict=True))
    if not spread > 0.0:
        return False
    push = 1j * (torque - total * (centre.conjugate() * along).imag) / spread
    return all(abs(along + push * arm) <= 1.0 for arm in around)


def _moving(problem: FrictionProblem, free: Slip, near: Slip) -> Slip | None:
    """The minimum, found from `near` or from a pivot; None where rest is lower than these, or a
    slip vanishes on the way, whether or not rest is the minimum."""
    scale = abs(free[0]) + abs(free[1]) * max(map(abs, problem.arms))
    if scale == 0.0:
        return None
    if (sliding := _sliding(problem, free, near, scale, QUICK, damped=False)) is not None:
        return sliding
    pivots = [_pivoting(problem, free, i) for i in range(3)]
    for slip, excess, _ in pivots:
        if slip[1] != 0.0 and excess <= 0.0:
            return slip
    begin, excess, push = min(pivots, key=lambda pivot: problem.value(free, pivot[0]))
    if begin[1] != 0.0:
        way = push / abs(push) * excess / problem.mass
        begin = begin[0] + _damping(problem, free, begin, (way, 0.0), 0.0) * way, begin[1]
        return _sliding(problem, free, begin, scale, NEWTON_STEPS, damped=True) or begin
    if problem.value(free, near) < problem.value(free, REST):
        return _sliding(problem, free, near, scale, NEWTON_STEPS, damped=True)
    return None


def _gained(problem: FrictionProblem, free: Slip, slip: Slip) -> float:
    """Energy that the momentum of `free` gives a slip [J]."""
    (u, o), (p, w) = slip, free
    return problem.mass * (p.conjugate() * u).real + problem.inertia * w * o


def _lowest(problem: FrictionProblem, free: Slip, way: Slip) -> Slip:
    """Of all slips along a `way` on which the value falls from rest the one with the lowest."""
    part = _gained(problem, free, way) - problem.value(way, way)
    part /= _gained(problem, way, way)
    return part * way[0], part * way[1]


def load_factor(
    limits: Sequence[float], arms: Sequence[complex], force: complex, torque: float
) -> tuple[float, Slip]:
    """Load factor of static friction under a wrench (the body sticks when it is 1 or less), and the
    slip at which the body would start to move, of any size.

    Largest of (wrench . q)/sum f N_i |v_i(q)| over slips q; `limits` f N_i [N] and `arms` from G
    [m], shape (3,); `force` [N] and `torque` [N m] about G. Under a wrench divided by less than
    this the body moves, and where it moves little, it moves in that way: the error of the factor is
    of second order in how little.
    """
    reach = math.sqrt(sum(abs(arm) ** 2 for arm in arms) / 3)
    most = sum(limits)
    size = math.hypot(abs(force), torque / reach)
    if not math.isfinite(size):
        raise OverflowError("a double does not hold the size of the wrench")
    if size == 0.0:
        return 0.0, REST
    slip: Slip = (complex(force / size), float(torque / size) / reach**2)
    if not most > 0.0:
        return math.inf, slip
    problem = FrictionProblem(1.0, reach**2, [limit / most for limit in limits], arms)
    factor = least = 0.0
    for pivot, arm in enumerate(arms):
        turn, drag = _about(problem, slip, pivot)
        if turn and not drag:
            return math.inf, (-1j * turn * arm, turn)
        least = max(least, 0.5 * abs(turn) / drag if drag else 0.0)
    pull = slip
    while factor == 0.0 or factor - least > NEARLY * factor:
        least += NEARER * max(factor - least, 0.0)
        free = pull[0] / least, pull[1] / least
        moved = _lowest(problem, free, slip) if factor else free
        moved = _moving(problem, free, moved) or moved
        if problem.value(free, moved) >= problem.value(free, REST):
            break
        slip = moved
        factor = _gained(problem, pull, slip) / problem.value(slip, slip)
    return size / most * factor, slip


def _about(problem: FrictionProblem, free: Slip, pivot: int) -> tuple[float, float]:
    """Moment about a support that friction has to balance, and the most that it can."""
    arm = problem.arms[pivot]
    (p, w) = free
    turn = problem.inertia * w - problem.mass * (p * (1j * arm).conjugate()).real
    levers = zip(problem.limits, problem.arms, strict=True)
    return turn, sum(limit * abs(other - arm) for limit, other in levers)


def _pivoting(problem: FrictionProblem, free: Slip, pivot: int) -> tuple[Slip, float, complex]:
    """Velocities with support `pivot` at rest, by how much its impulse exceeds its limit, and that
    impulse."""
    arm = problem.arms[pivot]
    supports = zip(problem.limits, problem.arms, strict=True)
    others = [(limit, a - arm) for k, (limit, a) in enumerate(supports) if k != pivot]
    turn, drag = _about(problem, free, pivot)
    if abs(turn) <= drag:
        return (0j, 0.0), math.inf, 0j
    o = (turn - math.copysign(drag, turn)) / (problem.inertia + problem.mass * abs(arm) ** 2)
    u = -1j * o * arm
    resisting = sum(limit * lever / abs(lever) for limit, lever in others)
    push = problem.mass * (free[0] - u) - math.copysign(1.0, o) * 1j * resisting
    return (u, o), abs(push) - problem.limits[pivot] * (1.0 + STICKS), push


def _sliding(
    problem: FrictionProblem, free: Slip, begin: Slip, scale: float, most: int, *, damped: bool
) -> Slip | None:
    """The minimum by Newton's method from `begin`; None where a slip vanishes on the way, or the
    last of `most` steps is not a small one."""
    (u, o) = begin
    reach = max(map(abs, problem.arms))
    for _ in range(most):
        if (newton := _newton_step(problem, free, (u, o), LAST * scale)) is None:
            return None
        (du, do), slope = newton
        part = _damping(problem, free, (u, o), (du, do), slope) if damped else 1.0
        u = u + part * du
        o = o + part * do
        if abs(du) + abs(do) * reach <= LAST * scale:
            return u, o
    return (u, o) if damped else None


def _newton_step(
    problem: FrictionProblem, free: Slip, slip: Slip, least: float
) -> tuple[Slip, float] | None:
    """Newton's step at `slip`, and the slope of the value along it [J]; None where a support slips
    by `least` [m/s] or less: there is no derivative.

    A support's resistance to a change w of its slip is across (w - e^2 w*)/2, e its direction.
    """
    push = problem.mass * (slip[0] - free[0])
    turn = problem.inertia * (slip[1] - free[1])
    stiff = 0.0
    twist = 0j
    bend = 0j
    spin = problem.inertia
    for limit, arm, beside in zip(problem.limits, problem.arms, problem.offsets, strict=True):
        v = slip[0] + 1j * slip[1] * arm + beside
        speed = abs(v)
        if speed <= least:
            return None
        e = v / speed
        across = limit / speed
        lever = arm.conjugate() * e
        push = push + limit * e
        turn = turn + limit * lever.imag
        stiff = stiff + across
        twist = twist + across * e * e
        bend = bend + across * lever.real * 1j * e
        spin = spin + across * lever.real**2
    way = _solved(problem.mass + 0.5 * stiff, 0.5 * twist, bend, spin, (push, turn))
    return way and (way, (push.conjugate() * way[0]).real + turn * way[1])


def _solved(
    stiff: float, twist: complex, bend: complex, spin: float, pull: Slip
) -> Slip | None:
    """The slip (u, o) with stiff u - twist u* + bend o and Re(bend* u) + spin o opposite to those
    of `pull`; None where there is none."""
    size = stiff**2 - abs(twist) ** 2
    if not size > 0.0:
        return None
    pushed = (stiff * pull[0] + twist * pull[0].conjugate()) / size
    bent = (stiff * bend + twist * bend.conjugate()) / size
    spin -= (bend.conjugate() * bent).real
    if not spin > 0.0:
        return None
    o = ((bend.conjugate() * pushed).real - pull[1]) / spin
    return -pushed - o * bent, o


def _damping(
    problem: FrictionProblem, free: Slip, slip: Slip, way: Slip, slope: float
) -> float:
    """Part of a Newton step after which the value has fallen enough (Armijo's condition)."""
    level = problem.value(free, slip)
    part = 1.0
    while part > LEAST:
        there = (slip[0] + part * way[0], slip[1] + part * way[1])
        if problem.value(free, there) <= level + 1e-4 * part * slope:
            break
        part *= 0.5
    return part


def onset(mass: float, at: Configuration, force: complex, torque: float) -> Slip:
    """Linear acceleration of the body's point at G (complex [m/s^2], body axes) and angular
    acceleration [rad/s^2], with which a body of `mass` M + m [kg] at rest starts to move under a
    wrench about G, `force` [N] and `torque` [N m], both 0 where it sticks."""
    limits = at.limits[0].tolist()
    arms = at.arms[0].tolist()
    inertia = float(at.inertia[0])
    if load_factor(limits, arms, force, torque)[0] <= 1.0 + STICKS:
        return REST
    free = (force / mass, torque / inertia)
    return after_friction(FrictionProblem(mass, inertia, limits, arms), free, free)


def slip_onset(mass: float, at: Configuration, support: int, needed: complex) -> complex:
    """Acceleration [m/s^2] at which a `support` at rest slips while the rest of the body moves,
    where the force it needs, `needed` [N], is more than its limit f N."""
    arm = complex(at.arms[0, support])
    inertia = float(at.inertia[0])
    lever = 1j * arm
    limit = float(at.limits[0, support])
    free = -needed / mass - lever * (lever.conjugate() * needed).real / inertia
    # The other supports slide already, with their forces in `needed`: their places do not matter.
    problem = FrictionProblem(mass, inertia, (limit, 0.0, 0.0), (arm, arm + 1.0, arm + 1j))
    linear, angular = after_friction(problem, (free, 0.0), (free, 0.0))
    return linear + angular * lever
