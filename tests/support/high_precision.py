"""The pendulum's period, action and state by adaptive quadrature with 60 digits, 40 of them
reliable: an independent method, with no formula of the closed form, and twice its digits.

gmpy2's MPFR numbers and not mpmath's, which take six times as long.
"""

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from typing import Any

import gmpy2
import numpy as np
from gmpy2 import mpfr

gmpy2.get_context().precision = 200  # bits: differences of energies lose 20 digits
Number = Any  # an mpfr
PI = gmpy2.const_pi()
TURN = 2 * PI
ZERO = mpfr(0)
_ONE = mpfr(1)


@dataclass(frozen=True)
class Orbit:
    """I theta'^2 / 2 + V(theta) = H with V = -a sin^2 - b sin - c cos - d sin 2 theta, all mpfr
    numbers."""

    a: Number
    b: Number
    c: Number
    inertia: Number
    theta: Number
    theta_dot: Number
    d: Number = ZERO  # I_yz w^2 / 2 of a product of inertia
    agreement: float = 1e-12  # of a Gauss rule and its two halves, whose error is 1e-17 then

    def potential(self, theta):
        """V(theta)."""
        sine, cosine = gmpy2.sin_cos(theta)
        even = -(self.a * sine + self.b) * sine - self.c * cosine
        return even - 2 * self.d * sine * cosine

    def slope(self, theta):
        """dV/dtheta."""
        sine, cosine = gmpy2.sin_cos(theta)
        even = self.c * sine - (2 * self.a * sine + self.b) * cosine
        return even - 2 * self.d * (cosine - sine) * (cosine + sine)

    def curvature(self, theta):
        """d^2V/dtheta^2."""
        sine, cosine = gmpy2.sin_cos(theta)
        even = (2 * self.a * sine + self.b) * sine + (self.c - 2 * self.a * cosine) * cosine
        return even + 8 * self.d * sine * cosine

    @cached_property
    def energy(self):
        """H."""
        return self.inertia * self.theta_dot**2 / 2 + self.potential(self.theta)

    def speed(self, theta):
        """|theta'| at an angle that the motion reaches."""
        return gmpy2.sqrt(2 * abs(self.energy - self.potential(theta)) / self.inertia)

    @cached_property
    def critical(self):
        """Angles in one turn, ascending, at which dV/dtheta changes its sign."""
        count = 2880
        grid = 0.123 + 2 * math.pi * np.arange(count + 1) / count
        a, b, c, d = (float(x) for x in (self.a, self.b, self.c, self.d))
        sine = np.sin(grid)
        cosine = np.cos(grid)
        slopes = c * sine - (2 * a * sine + b) * cosine - 2 * d * np.cos(2 * grid)
        places = np.flatnonzero(slopes[:-1] * slopes[1:] < 0)
        ends = ((float(grid[i]), float(grid[i + 1])) for i in places)
        return tuple(_root(self.slope, self.curvature, *pair) for pair in ends)

    @cached_property
    def crest(self):
        """Angle of the highest maximum of V, of two the one nearest to the start."""
        angles = self.critical or (ZERO,)
        highest = max(self.potential(x) for x in angles)
        level = highest - abs(highest) * mpfr("1e-50")
        crests = [x for x in angles if self.potential(x) >= level]
        nearest = (x + TURN * gmpy2.rint((self.theta - x) / TURN) for x in crests)
        return min(nearest, key=lambda x: abs(x - self.theta))

    @cached_property
    def turning(self):
        """The nearest zeros of H - V on either side of the start, or None when it rotates."""
        edges = [self._edge(sense) for sense in (-1, 1)]
        return None if edges[0] is None or edges[1] is None else (edges[0], edges[1])

    def _edge(self, sense):
        if self.theta_dot == 0 and sense * self.slope(self.theta) > 0:
            return self.theta
        least = mpfr("1e-50") * (abs(self.a) + abs(self.b) + abs(self.c))
        last = self.theta
        for distance in sorted(_within_turn(sense * (x - self.theta)) for x in self.critical):
            here = self.theta + sense * distance  # V is monotonic between these
            if self.potential(here) - self.energy > least:
                return _root(lambda x: self.potential(x) - self.energy, self.slope, last, here)
            last = here
        return None

    @property
    def sense(self):
        """-1 when the start moves backward, else 1."""
        return -1 if self.theta_dot < 0 else 1

    @cached_property
    def _swing(self):
        """Middle of a libration, its sine and cosine, and sine of half the amplitude."""
        if self.turning is None:
            return None
        low, high = self.turning
        middle = (low + high) / 2
        return middle, *gmpy2.sin_cos(middle), gmpy2.sin((high - low) / 4)

    def chart(self, u):
        """theta and |dtheta/du| of a parameter that grows with time by 2 pi a period and in which
        dt/du is smooth: sin((theta - middle) / 2) = sin(amplitude / 2) sin u removes the square
        roots of a libration."""
        if self._swing is None:
            return self.theta + self.sense * u, mpfr(1)
        middle, _, _, most = self._swing
        sine, cosine = gmpy2.sin_cos(u)
        half = most * sine
        width = 2 * most * abs(cosine) / gmpy2.sqrt(1 - half * half)
        return middle + 2 * gmpy2.asin(half), width

    def _along(self, sine, cosine):
        """|dtheta/du| and the speed of the u with this sine and cosine; in a rotation of a u from
        theta = 0 on, forward."""
        if self._swing is None:
            width = _ONE
        else:
            _, sine_middle, cosine_middle, most = self._swing
            half = most * sine
            square = half * half
            other = gmpy2.sqrt(1 - square)
            width = 2 * most * abs(cosine) / other
            sine = 2 * half * other
            cosine = 1 - 2 * square
            sine, cosine = (
                sine_middle * cosine + cosine_middle * sine,
                cosine_middle * cosine - sine_middle * sine,
            )
        height = (self.a * sine + self.b) * sine + self.c * cosine
        if self.d != 0:
            height += 2 * self.d * sine * cosine
        return width, gmpy2.sqrt(abs(self.energy + height) * self._per_energy)

    @cached_property
    def _per_energy(self):
        """2 / I."""
        return 2 / self.inertia

    def parameter(self, theta, theta_dot):
        """The u of a state, as a first guess of Newton's method."""
        if self._swing is None:
            return self.sense * (mpfr(theta) - self.theta)
        middle, _, _, most = self._swing
        u = gmpy2.asin(max(-1, min(1, gmpy2.sin((mpfr(theta) - middle) / 2) / most)))
        return u if theta_dot >= 0 else PI - u

    def over(self, low, high):
        """Time, and integral of |p| dtheta, from one u to another."""
        count = max(1, math.ceil(abs(high - low) / 2))
        reach = (high - low) / (2 * count)
        middles = [low + (2 * i + 1) * reach for i in range(count)]
        parts = [self._halved(middle, reach, self._gauss(middle, reach)) for middle in middles]
        return sum(t for t, _ in parts), sum(area for _, area in parts)

    def _halved(self, middle, reach, whole):
        reach = reach / 2
        left = self._gauss(middle - reach, reach)
        right = self._gauss(middle + reach, reach)
        total = left[0] + right[0], left[1] + right[1]
        if all(
            abs(x - y) <= self.agreement * abs(x) for x, y in zip(total, whole, strict=True)
        ):
            return total
        left = self._halved(middle - reach, reach, left)
        right = self._halved(middle + reach, reach, right)
        return left[0] + right[0], left[1] + right[1]

    def _gauss(self, middle, reach):
        """Time, and integral of |p| dtheta, over u from middle - reach to middle + reach."""
        here = middle if self._swing is not None else self.theta + self.sense * middle
        sine, cosine = gmpy2.sin_cos(here)
        time = area = ZERO
        for weight, sine_off, cosine_off in _offsets(reach):
            x = sine * cosine_off
            y = cosine * sine_off
            z = cosine * cosine_off
            w = sine * sine_off
            width, speed = self._along(x + y, z - w)
            other_width, other_speed = self._along(x - y, z + w)
            time += weight * (width / speed + other_width / other_speed)
            area += weight * (width * speed + other_width * other_speed)
        return reach * time, reach * area * self.inertia

    def follow(self, times=(), guesses=()):
        """Period, (1/2 pi) closed integral of p dtheta, and theta and theta' at `times`, each by
        Newton's method on the time of u, from a first guess of the state."""
        start = ZERO if self.turning is None else self.parameter(self.theta, self.theta_dot)
        starts = [_within_turn(self.parameter(*guess) - start) for guess in guesses]
        spent = area = last = ZERO
        reached = {}
        for u in sorted({*starts, TURN}):
            step, more = self.over(start + last, start + u)
            spent = spent + step
            area = area + more
            last = u
            reached[u] = spent
        states = [
            self._newton(mpfr(time), start + u, reached[u], spent)
            for time, u in zip(times, starts, strict=True)
        ]
        return spent, area / TURN, states

    def _newton(self, time, u, spent, period):
        whole = gmpy2.rint((time - spent) / period)
        missing = time - whole * period - spent
        for _ in range(12):
            theta, width = self.chart(u)
            step = missing * self.speed(theta) / width
            missing = missing - self._gauss(u + step / 2, step / 2)[0]
            u = u + step
            if abs(step) < 1e-20:
                theta, _ = self.chart(u)
                sign = self.sense if self.turning is None else gmpy2.sign(gmpy2.cos(u))
                turns = self.sense * whole * TURN if self.turning is None else 0
                return theta + turns, sign * self.speed(theta)
        raise ArithmeticError("no state near the guess is reached at this time")


def _within_turn(angle):
    return angle - TURN * gmpy2.floor(angle / TURN)


@cache
def _rule(count=24):
    """Nodes and weights of the Gauss rule, by Newton's method on Legendre's recurrence."""
    rule = []
    for i in range(count):
        x = mpfr(math.cos(math.pi * (i + 0.75) / (count + 0.5)))
        for _ in range(8):
            below = mpfr(1)
            value = x
            for n in range(2, count + 1):
                below, value = value, ((2 * n - 1) * x * value - (n - 1) * below) / n
            slope = count * (x * value - below) / (x * x - 1)
            x = x - value / slope
        rule.append((x, 2 / ((1 - x * x) * slope * slope)))
    return tuple(rule)


@lru_cache(maxsize=64)
def _offsets(reach):
    """Weight of each pair of nodes, and sine and cosine of its distance from the middle."""
    return tuple((weight, *gmpy2.sin_cos(reach * x)) for x, weight in _rule() if x > 0)


def _root(function, slope, low, high):
    """A zero between two points at which the function's signs differ: Newton's method, and a
    bisection where that leaves the bracket or is slow."""
    low = mpfr(low)
    high = mpfr(high)
    rising = function(low) < 0
    x = last = (low + high) / 2
    for _ in range(400):
        value = function(x)
        low, high = (x, high) if (value < 0) == rising else (low, x)
        step = value / (slope(x) or 1)
        if abs(step) < 1e-45:  # what a step of Newton's method leaves is its square
            return x - step
        inside = min(low, high) < x - step < max(low, high) and abs(step) < abs(last) / 2
        last, x = (step, x - step) if inside else (high - low, (low + high) / 2)
        if abs(last) < 1e-56:
            return x
    raise ArithmeticError("no zero found")


def orbit_of(pendulum):
    """The orbit of a pendulum from its own doubles."""
    body = pendulum.body
    rate2 = mpfr(pendulum.platform_rate) ** 2
    arm = mpfr(body.mass) * body.com_distance
    a = (mpfr(body.inertia_y) - body.inertia_z) * rate2 / 2
    b = arm * pendulum.pivot_y * rate2
    c = arm * pendulum.gravity
    inertia = mpfr(body.inertia_x)
    theta = mpfr(pendulum.theta)
    d = mpfr(body.inertia_yz) * rate2 / 2
    orbit = Orbit(a, b, c, inertia, theta, mpfr(pendulum.theta_dot), d)
    return started(orbit, pendulum.excess)


def started(orbit, excess=None, theta_from_top=None):
    """The orbit from an angle from the highest barrier, with an energy above that barrier."""
    if theta_from_top is not None:
        orbit = replace(orbit, theta=orbit.crest + theta_from_top)
    if excess is None:
        return orbit
    energy = orbit.potential(orbit.crest) + excess
    speed = gmpy2.sqrt(2 * abs(energy - orbit.potential(orbit.theta)) / orbit.inertia)
    return replace(orbit, theta_dot=math.copysign(1.0, orbit.theta_dot) * speed)
