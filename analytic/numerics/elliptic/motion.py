"""Motion in V = -a sin^2 - b sin - c cos in closed form, by Weierstrass' function, in every regime.

With w = tan((theta - theta_0)/2) the energy is w'^2 = A0 w^4 + 4 A1 w^3 + 6 A2 w^2 + 4 A3 w + A4,
and the motion is a rational function of P(t) and P'(t) (Biermann 1865; Whittaker and Watson,
A Course of Modern Analysis, 20.6, example 2):

    w = [-w'_0 P' + 2 A3 (P - A2/2) + A1 A4]/[2 (P - A2/2)^2 - A0 A4/2].

P follows from Jacobi's functions of A t, parameter 1 - B^2/A^2 (DLMF 23.6). Sudakov 2015 gives
the integral (16) and says that no special function inverts it; P does. All numbers have 34 digits,
some of which are lost in differences. Close to a separatrix, too many would be lost in A and B. In
this case the energy above the saddle enters the cubic of P as a factor, and the period keeps its
digits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plumbob.analytic.numerics.elliptic.jacobi_functions import half_turn, jacobi
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    crests,
)
from plumbob.analytic.numerics.quad import PI, Quad, choose, choose_lazily, double, quad
from plumbob.analytic.reference import Array

# If the energy above a saddle is less than this fraction of the potential, the cubic is written
# with that energy as a factor: its roots nearly coincide, and would lose their digits.
_NEAR_SADDLE = 1e-10
# A t after which a motion on a separatrix is at rest at the saddle, in double
_REST_PHASE = 20.0
_Quartic = tuple[Quad, Quad, Quad, Quad, Quad]  # A0 ... A4 [1/s^2]
# relative distance by which rounding moves an angle past a turning point
_ANGLE_ROUNDING = 1e-15
# samples for the action: half of them cover 100 time constants of a saddle
ACTION_SAMPLES = 1024
# samples in a period: the motion turns back at most once between two of them
TURNING_SAMPLES = 65


@dataclass(frozen=True)
class _Weierstrass:
    """Weierstrass' function P(t), given by g2, one root e of its cubic 4 e^3 - g2 e - g3 = 0, and
    the numbers A and B of Jacobi's functions (module docstring)."""

    g2: Quad  # [1/s^4]
    e: Quad  # [1/s^2] isolated root of the cubic
    real: Any  # bool: whether the other two roots of the cubic are real
    a: Quad  # A [1/s]
    b: Quad  # B [1/s]

    @classmethod
    def of(cls, shift: Quad, c1: Quad, c0: Quad) -> _Weierstrass:
        """Returns P for the cubic 4 y^3 + 6 p y^2 - c1 y - c0 in y = e - p/2, p the `shift`."""
        y = _isolated_root(shift, c1, c0)
        # product, sum and squared difference of the other two roots
        product = c0 / (4 * y)
        total = -(c1 / 4 + product) / y
        gap = total * total - 4 * product
        real = gap >= 0
        root = np.sqrt(abs(gap))
        upper = (total + root) / 2
        lower = (total - root) / 2
        y_is_largest = y > upper
        # If the other roots are complex, each is at the distance `size` from y, and A^2 = 4 size.
        # B^2 = 2 size + 2 y - total, written without a difference of nearly equal numbers.
        size = np.sqrt(y * y - total * y + product)
        triple = 2 * y - total
        narrow = choose(triple < 0, -gap / (2 * size - triple), 2 * size + triple)
        a_squared = choose(real, choose(y_is_largest, y - lower, upper - y), 4 * size)
        b_squared = choose(real, choose(y_is_largest, y - upper, root), narrow)
        e = choose(real & y_is_largest, lower, y) + shift / 2
        return cls(3 * shift * shift + c1, e, real, np.sqrt(a_squared), np.sqrt(b_squared))

    @property
    def period(self) -> Quad:
        """Real period [s]; infinite for B = 0."""
        return half_turn(self.a, self.b) * choose(self.real, 1.0, 2.0)

    def at(self, times: Quad) -> _Point:
        """Returns Weierstrass' function P and its derivative P' at `times` [s] within half a
        period."""
        sn, cn, dn = jacobi(times, self.a, self.b)
        s = sn / self.a
        r = choose_lazily(self.real, lambda: s * s, lambda: (1 - cn) * (2 / self.a**2))
        h = choose_lazily(self.real, lambda: 1.0, lambda: (1 + cn) / 2)
        p_dot = -2 * dn * choose(self.real, cn, 1.0)
        p = self.e * r + h
        r2 = r * r
        return _Point(
            s=s,
            r=r,
            r2=r2,
            h=h,
            p_dot=p_dot,
            moving=s * p_dot,
            p=p,
            bend=6 * p * p - self.g2 / 2 * r2,
        )


class _Point(NamedTuple):
    """P = p/r and P' = s p_dot/r^2 with h = s^2/r at a time t. For small t, s is about t and r
    about t^2, so that all numbers stay finite at t = 0."""

    s: Quad
    r: Quad
    r2: Quad  # r^2
    h: Quad
    p_dot: Quad
    moving: Quad  # s p_dot
    p: Quad
    bend: Quad  # P'' r^2


def _isolated_root(shift: Quad, c1: Quad, c0: Quad) -> Quad:
    """Returns the root of 4 y^3 + 6 shift y^2 - c1 y - c0 that is farthest from the other two, by
    Newton's method from a place beyond all roots; 1 if all roots are zero."""
    g2 = double(3 * shift * shift + c1)
    g3 = double(c0 - shift * c1 / 2 - shift**3)
    bound = np.maximum(np.sqrt(np.maximum(g2, 0.0) / 2), np.cbrt(np.abs(g3) / 2))
    y = quad(choose(g3 < 0, -bound, bound) * (1 + 1e-12)) - shift / 2
    for _ in range(100):
        value = ((4 * y + 6 * shift) * y - c1) * y - c0
        slope = (12 * y + 12 * shift) * y - c1
        step = value / choose(slope == 0, quad(1.0), slope)
        y = y - step
        if np.all(abs(step) <= 1e-22 * abs(y)):  # convergence is quadratic
            break
    return choose(y == 0, quad(1.0), y)  # all roots are 0 at rest without forces


@dataclass(frozen=True)
class EllipticMotion:
    """The closed form of the motion from one start, or from an array of starts, in 34 digits.

    All fields have the shape of the start; see `solve`.
    """

    potential: TrigonometricPotential  # [J], 34 digits
    inertia: Quad  # [kg m^2]
    theta0: Quad  # [rad]
    kinetic: Quad  # [J] kinetic energy at the start
    forward: Any  # bool: whether theta_dot >= 0 at the start
    rest: Any  # bool: whether the motion is at rest
    # bool: whether the motion rotates; a separatrix over the highest barrier is a rotation with an
    # infinite period
    rotation: Any
    top: Quad  # theta [rad] of the highest barrier
    quartic: _Quartic  # coefficients of w'^2
    function: _Weierstrass  # P(t)

    @property
    def period(self) -> Quad:
        """Time [s] of a full turn, or period of a libration; infinite on a separatrix."""
        return self.function.period

    @property
    def two_pairs(self) -> Any:
        """Whether the motion swings in one well while another well admits its energy, too."""
        return self.function.real & np.logical_not(self.rotation)

    @property
    def sense(self) -> Any:
        """Sense of the motion at the start: -1.0 backward, 1.0 forward or at rest."""
        return choose(self.forward, 1.0, -1.0)

    def state(self, times: Array) -> tuple[Array, Array]:
        """Returns theta [rad] and theta_dot [rad/s] at `times` [s] after the start; `times`
        broadcast with the shape of the starts."""
        with np.errstate(all="ignore"):  # infinite periods, and branches that are not chosen
            times = quad(np.asarray(times, dtype=float))
            finite = np.isfinite(double(self.period))
            cycle = choose(finite, self.period, quad(1.0))
            turns = choose(finite, np.rint(double(times / cycle)), 0.0)
            time_in_period = times - turns * cycle
            if not np.all(finite):
                longest = choose(finite, quad(np.inf), _REST_PHASE / self.function.a)
                time_in_period = np.minimum(np.maximum(time_in_period, -longest), longest)
            half_angle, rate = self._half_angle_and_rate(time_in_period)
            sense = self.sense * np.sign(double(time_in_period))
            change = 2 * self._with_whole_turns(half_angle, turns, sense)
            zeros = np.zeros(np.shape(time_in_period))
            theta = self.theta0 + choose(self.rest, zeros, change)
            return double(theta), double(choose(self.rest, zeros, rate))

    def _with_whole_turns(self, half: Quad, turns: Any, sense: Any) -> Quad:
        """Returns half the angle from the start, whole turns included.

        `half` is this half angle modulo pi. `turns` is the number of periods that are over; after
        them the motion goes forward (`sense` 1) or backward (-1).
        """

        def around() -> Quad:
            """Returns half the angle of a rotation: each period adds half a turn."""
            past_half_turn = choose(sense > 0, half < 0, (half > 0) & (sense < 0))
            return half + PI * (choose(past_half_turn, sense, 0.0) + self.sense * turns)

        def within() -> Quad:
            """Returns half the angle of a libration: it stays between two passages of the highest
            barrier."""
            turn = (self.top - self.theta0) / (2 * PI)
            to_barrier = PI * (turn - np.floor(turn))  # half the angle, forward from the start
            return half - PI * (np.floor((half - to_barrier) / PI) + 1)

        return choose_lazily(self.rotation, around, within)

    def _half_angle_and_rate(self, times: Quad) -> tuple[Quad, Quad]:
        """Returns half the angle from the start, modulo pi, and theta_dot [rad/s], at `times` [s]
        within half a period of the start."""
        a1, a2, a3, a4 = self.quartic[1:]
        # Numerator and denominator of w (module docstring) are multiplied by r^2, so that both are
        # finite at t = 0: x = even - odd and y.
        t = self.function.at(times)
        speed = self._start_speed
        centred = t.p - a2 / 2 * t.r
        lift = 2 * a3 * t.moving
        push = 2 * a3 * centred + a1 * a4 * t.r
        odd = speed * t.moving
        even = t.r * push
        bend = speed * t.bend
        y = 2 * centred * centred - self.quartic[0] * a4 / 2 * t.r2
        # w is x/y, and also u/v. If w is infinite at the time -t, both x and y vanish at t, and
        # u/v has to be used. The last numbers are y x' - x y' and v u' - u v'.
        u = t.r * (2 * (a3**2 - a2 * a4) * t.r - 2 * a4 * t.p)
        v = even + odd
        return _from_larger(
            (
                even - odd,
                y,
                y * (lift - bend)
                - 4 * centred * t.p_dot * (t.s * push - speed * t.p_dot * t.h),
            ),
            (u, v, -2 * a4 * t.moving * v - u * (lift + bend)),
        )

    @property
    def _start_speed(self) -> Quad:
        """Derivative of w at the start [1/s]: the root of A4, or zero if rounding has made A4
        negative."""
        a4 = self.quartic[4]
        return self.sense * np.sqrt(choose(a4 > 0, a4, 0 * a4))

    @property
    def action(self) -> Any:
        """Action [J s]: (1/2 pi) times the integral of p dtheta over one period.

        The integral is the inertia times the mean of theta_dot^2 times the period. The trapezoidal
        rule for the mean converges geometrically.
        """
        period = double(self.period)
        rates = self.state(
            np.multiply.outer(np.arange(ACTION_SAMPLES) / ACTION_SAMPLES, period)
        )[1]
        return double(self.inertia) * np.mean(rates**2, axis=0) * period / (2 * np.pi)

    def time_at(self, theta: Array) -> Array:
        """Returns the times [s] after the start at which a single motion first reaches `theta`
        [rad], shape (n,); NaN if it never does.

        Each time is sought between two neighbouring turning points.
        """
        period = float(double(self.period))
        periodic = math.isfinite(period)
        last = period if periodic else float(double(_REST_PHASE / self.function.a))
        turns = 0.0 * theta
        if self.rotation and periodic:
            turns = np.floor((theta - double(self.theta0)) * self.sense / (2 * np.pi))
            turns = np.maximum(turns, 0.0)
        target = theta - turns * self.sense * 2 * np.pi
        edges = np.array([0.0, *self._turning_points(last), last])
        edge_angles = self.state(edges)[0]
        tolerance = _ANGLE_ROUNDING * (1 + np.abs(theta))
        lowest = np.minimum(edge_angles[:-1], edge_angles[1:])
        highest = np.maximum(edge_angles[:-1], edge_angles[1:])
        above = lowest <= (target + tolerance)[:, None]
        below = highest >= (target - tolerance)[:, None]
        reached = above & below
        interval = reached.argmax(axis=1)
        target = np.clip(target, lowest[interval], highest[interval])
        times = self._crossing_times(0, target, edges[interval], edges[interval + 1])
        times = times + turns * (last if periodic else 0.0)
        times = np.where(reached.any(axis=1), times, np.nan)
        return np.where(theta == double(self.theta0), 0.0, times)

    def _turning_points(self, last: float) -> Array:
        """Returns the times up to `last` [s] at which the motion turns back, shape (n,)."""
        samples = np.linspace(0.0, last, TURNING_SAMPLES)
        before = np.flatnonzero(np.diff(np.sign(self.state(samples)[1])))
        zeros = np.zeros(len(before))
        return self._crossing_times(1, zeros, samples[before], samples[before + 1])

    def _crossing_times(self, part: int, value: Array, low: Array, high: Array) -> Array:
        """Returns the times [s] at which theta (`part` 0) or theta_dot (`part` 1) has a `value`.

        Each time is between `low` and `high` [s]; theta or theta_dot is monotonic between them. All
        shapes are (n,).
        """
        from scipy.optimize.elementwise import find_root

        def difference(times: Array, values: Array) -> Array:
            return self.state(times)[part] - values

        return find_root(difference, (low, high), args=(value,)).x


def _from_larger(
    first: tuple[Quad, Quad, Quad], second: tuple[Quad, Quad, Quad]
) -> tuple[Quad, Quad]:
    """Returns half an angle and the angle's rate from the larger of two triples x, y, n that
    describe the same angle: the half angle is atan2(x, y), its rate n/(x^2 + y^2)."""
    first_size = first[0] * first[0] + first[1] * first[1]
    second_size = second[0] * second[0] + second[1] * second[1]
    second_is_larger = second_size > first_size
    x, y, numerator = (
        choose(second_is_larger, b, a) for a, b in zip(first, second, strict=True)
    )
    return np.arctan2(x, y), 2 * numerator / np.maximum(first_size, second_size)


def solve(
    potential: TrigonometricPotential,
    inertia: Any,
    theta: Any,
    theta_dot: Any,
    excess: Any = None,
    theta_from_top: Any = None,
) -> EllipticMotion:
    """Returns the solution of I theta'' = -V'(theta) from theta [rad] and theta_dot [rad/s].

    All arguments broadcast. If `excess` [J] is given, it is the energy above the highest barrier,
    and of theta_dot only the sign counts. If `theta_from_top` [rad] is given, it is the initial
    angle from that barrier, on the turn nearest to `theta`. Source: Sudakov 2015, eqs. 15 and 16,
    inverted.
    """
    inputs = (potential.a, potential.b, potential.c, inertia, theta, theta_dot)
    *coefficients, inertia, theta, theta_dot, given_excess, from_top = _broadcast(
        *inputs, excess, theta_from_top
    )
    potential = TrigonometricPotential(*coefficients)
    with np.errstate(all="ignore"):  # infinite periods, and branches that are not chosen
        top, second = _crests(potential)
        barrier_gap = _height(potential, top, second - top)
        if theta_from_top is not None:
            theta = _nearest_top(potential, top, second, barrier_gap, theta) + from_top
        below_top = _height(potential, top, theta - top)
        kinetic = (
            inertia * theta_dot * theta_dot / 2 if excess is None else given_excess + below_top
        )
        above = kinetic - below_top if excess is None else given_excess
        quartic = _quartic(potential, theta, kinetic, inertia)
        return EllipticMotion(
            potential=potential,
            inertia=inertia,
            theta0=theta,
            kinetic=kinetic,
            forward=np.logical_not(theta_dot < 0),
            rest=_is_at_rest(potential, theta, kinetic),
            rotation=above >= 0,
            top=top,
            quartic=quartic,
            function=_weierstrass_function(
                quartic, potential, inertia, (top, second), (above, above + barrier_gap)
            ),
        )


def _is_at_rest(potential: TrigonometricPotential, theta: Quad, kinetic: Quad) -> Any:
    """Returns whether a motion from `theta` [rad] with the `kinetic` energy [J] stays at rest."""
    without_speed = abs(kinetic) <= 1e-60 * potential.scale
    without_force = abs(potential.slope(theta)) <= 1e-30 * potential.scale
    return without_speed & without_force


def _weierstrass_function(
    start: _Quartic,
    potential: TrigonometricPotential,
    inertia: Quad,
    crests: tuple[Quad, Quad],
    above: tuple[Quad, Quad],
) -> _Weierstrass:
    """Returns P from the coefficients A0 ... A4 at the start, or at a crest.

    `above` is the energy above each of the two `crests` [J]. If the energy is close to a crest, the
    coefficients at that crest are used.
    """
    # If there is no other crest, its energy is NaN, and the comparison is false.
    closer = abs(above[1]) < abs(above[0])
    energy = choose(closer, above[1], above[0])
    crest = choose(closer, crests[1], crests[0])
    near = abs(energy) <= _NEAR_SADDLE * potential.scale
    at_crest = _quartic(potential, crest, energy, inertia)
    a0, a1, a2, a3, a4 = (choose(near, *pair) for pair in zip(at_crest, start, strict=True))
    # At a crest a3 = 0, g2 = 3 a2^2 + a0 a4 and g3 = a2 (a0 a4 - a2^2) - a1^2 a4. One root is near
    # a2/2. In the distance from a2/2, the small coefficients of the cubic have a4 as a factor.
    twist = choose(near, 0 * a3, a3)
    product = a0 * a4 - 4 * a1 * twist
    shift = choose(near, a2, 0 * a2)
    c0 = a2 * (a0 * a4 + 2 * a1 * twist - a2**2) - a0 * twist**2 - a1**2 * a4
    c0 = choose(near, a4 * (3 * a0 * a2 / 2 - a1**2), c0)
    return _Weierstrass.of(shift, product + choose(near, 0 * a2, 3 * a2**2), c0)


def _broadcast(*values: Any) -> Sequence[Quad]:
    """Returns the values in 34 digits and of one shape; 0 stands for None."""
    numbers = [quad(0.0 if value is None else value) for value in values]
    return np.broadcast_arrays(*numbers) if any(np.ndim(v) for v in numbers) else numbers


def _quartic(
    potential: TrigonometricPotential, angle: Quad, energy: Quad, inertia: Quad
) -> _Quartic:
    """Returns A0 ... A4 [1/s^2] for w measured from `angle` [rad], at which the kinetic energy is
    `energy` [J]."""
    fourth, third, second, first = _potential_drop(potential, angle)
    return (
        (energy + fourth) / (2 * inertia),
        third / (8 * inertia),
        (2 * energy + second) / (12 * inertia),
        first / (8 * inertia),
        energy / (2 * inertia),
    )


def _potential_drop(
    potential: TrigonometricPotential, angle: Quad
) -> tuple[Quad, Quad, Quad, Quad]:
    """Returns the coefficients of w^4 to w^1 in (1 + w^2)^2 (V(angle) - V(angle + x)), with
    w = tan(x/2)."""
    sine = np.sin(angle)
    cosine = np.cos(angle)
    twist = 4 * potential.a * sine * cosine
    force = 2 * (potential.b * cosine - potential.c * sine)
    level = 2 * (potential.b * sine + potential.c * cosine)
    well = 4 * potential.a * (cosine - sine) * (cosine + sine)
    return -level, force - twist, well - level, force + twist


def _height(potential: TrigonometricPotential, crest: Quad, x: Quad) -> Quad:
    """Returns the height of the potential's crest above its value at crest + x, without a
    difference of two potentials."""
    fourth, third, second, _ = _potential_drop(potential, crest)
    sine = np.sin(x / 2)
    cosine = np.cos(x / 2)
    return sine**2 * (fourth * sine**2 + third * sine * cosine + second * cosine**2)


def _crests(potential: TrigonometricPotential) -> tuple[Quad, Quad]:
    """Returns the angle of the highest maximum of V, 0 for a constant V, and the angle of the other
    maximum, NaN if there is none."""
    coefficients = map(np.ravel, (potential.a, potential.b, potential.c))
    defaults = quad(np.array([0.0, np.nan]))  # angles that stand for missing maxima
    pairs = []
    for a, b, c in zip(*coefficients, strict=True):
        tops = crests(TrigonometricPotential(a, b, c))
        pairs.append(np.append(tops, defaults[len(tops) > 0 :])[:2])
    highest, second = np.array(pairs).T
    shape = np.shape(potential.a)
    return quad(highest.reshape(shape)), quad(second.reshape(shape))


def _nearest_top(
    potential: TrigonometricPotential, top: Quad, second_top: Quad, between: Quad, theta: Quad
) -> Quad:
    """Returns the angle of the highest barrier on the turn nearest to `theta`. If both barriers are
    equally high, which means that their difference `between` [J] is 0, it is the nearer one."""
    equal = abs(between) <= 1e-28 * potential.scale
    gap = _without_turns(top - theta)
    second_gap = _without_turns(second_top - theta)
    return theta + choose(equal & (abs(second_gap) < abs(gap)), second_gap, gap)


def _without_turns(angle: Quad) -> Quad:
    """Returns an angle reduced to -pi ... pi by whole turns."""
    return angle - 2 * PI * quad(np.rint(double(angle) / (2 * np.pi)))
