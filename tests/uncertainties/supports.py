"""A body on three Coulomb points at random, by its equations in gmpy2's numbers (Chernousko 2020,
eqs. 1-4 and 23): sliding, pivoting about a support that has stopped, and rest.

With complex numbers for vectors in body axes, r, v and w of the slider, p the velocity of the
combined centre mu r and F_i = -f N_i v_i/|v_i|, v_i = p - mu (i omega r + v) + i omega A_i,

    p' = sum F_i/(M + m) - i omega p,
    (J + mu M r^2) omega' = sum (A_i - mu r) x F_i - mu M (2 omega r.v + r x w).

Steps that choose themselves come as near as is asked to the time at which a support stops, where
the forces have no derivative.
"""

from dataclasses import dataclass
from functools import cached_property

import gmpy2
import mpmath
import numpy as np
from gmpy2 import mpc, mpfr
from scipy.optimize import least_squares

from plumbob.tests.uncertainties.formulas import body, either, log, place
from plumbob.tests.uncertainties.integrated import AGREED, GROWTH, extrapolated

STILL = mpfr("1e-17")  # of the largest speed: a support that is slower has stopped
ALL_STILL = mpfr("1e-10")  # of the same: all have, if none is faster when the first one stops
BEGUN = mpfr(
    "1e-13"
)  # of a piece of the path: until then velocities grow in proportion to time
SMALLEST = mpfr("1e-30")  # of a piece: no step is shorter
STEPS = 150  # at most, from one time to the next: a light body is stiff as it stops


def turned(angle):
    """A unit vector."""
    sine, cosine = gmpy2.sin_cos(angle)
    return mpc(cosine, sine)


def dot(a, b):
    """The scalar product."""
    return a.real * b.real + a.imag * b.imag


def cross(a, b):
    """The part of the vector product across the plane."""
    return a.real * b.imag - a.imag * b.real


@dataclass(frozen=True)
class Fixed:
    """A slider at rest in the body, to the end."""

    place: object
    duration: object = mpfr("inf")

    def at(self, _):
        """Place, velocity and acceleration in the body."""
        return self.place, mpc(0), mpc(0)


@dataclass(frozen=True)
class Arc:
    """A slider on a circle about C, from an angle and a rate on."""

    radius: object
    angle: object
    rate: object
    push: object
    duration: object

    def at(self, time):
        """Place, velocity and acceleration in the body."""
        rate = self.rate + self.push * time
        angle = self.angle + time * (self.rate + self.push * time / 2)
        r = self.radius * turned(angle)
        return r, mpc(0, 1) * rate * r, mpc(-(rate**2), self.push) * r


class Unknown(Exception):
    """The motion goes on in a way that this oracle does not follow."""


@dataclass(frozen=True)
class Body:
    """The constants of a body, by name, and the equations of its modes.

    A state is [p, omega, place of the combined centre on the ground, heading, time of the piece].
    """

    p: dict

    @cached_property
    def arms(self):
        """The supports."""
        return [mpc(*arm) for arm in self.p["supports"]]

    @cached_property
    def total(self):
        """M + m."""
        return self.p["body_mass"] + self.p["slider_mass"]

    @cached_property
    def ratio(self):
        """mu."""
        return self.p["slider_mass"] / self.total

    def inertia(self, r):
        """J + mu M r^2."""
        return self.p["inertia"] + self.ratio * self.p["body_mass"] * dot(r, r)

    def loads(self, r):
        """Normal forces: areas of the triangles that the combined centre makes with two supports,
        over the whole one."""
        a, b, c = (arm - self.ratio * r for arm in self.arms)
        parts = cross(b, c), cross(c, a), cross(a, b)
        return [self.total * self.p["gravity"] * part / sum(parts) for part in parts]

    def velocities(self, point, omega, r, v):
        """Those of the supports."""
        of_c = point - self.ratio * (mpc(0, 1) * omega * r + v)
        return [of_c + mpc(0, 1) * omega * arm for arm in self.arms]

    def frictions(self, ways, r, without=None):
        """Friction forces against the `ways` of the supports; none at the one `without`."""
        limits = [self.p["friction"] * load for load in self.loads(r)]
        return [
            mpc(0) if i == without else -limit * way / abs(way)
            for i, (way, limit) in enumerate(zip(ways, limits, strict=True))
        ]

    def moments(self, forces, omega, slider):
        """Their moment about the combined centre, and that of the slider's motion."""
        r, v, w = slider
        drive = self.ratio * self.p["body_mass"] * (2 * omega * dot(r, v) + cross(r, w))
        arms = (arm - self.ratio * r for arm in self.arms)
        return sum(cross(arm, f) for arm, f in zip(arms, forces, strict=True)) - drive

    def sliding(self, piece):
        """Rates of a state while all supports slide."""

        def rates(state):
            point, omega, _, heading, time = state
            slider = piece.at(time)
            ways = self.velocities(point, omega, *slider[:2])
            forces = self.frictions(ways, slider[0])
            spin = self.moments(forces, omega, slider) / self.inertia(slider[0])
            push = sum(forces) / self.total - mpc(0, 1) * omega * point
            return [push, spin, point * turned(heading), omega, mpfr(1)]

        return rates

    def pivot(self, piece, support, sense, state):
        """omega', p' and the force that holds `support`, while the body turns about it in a
        `sense`."""
        _, omega, _, _, time = state
        r, v, w = slider = piece.at(time)
        turn = mpc(0, 1)
        arm = self.ratio * r - self.arms[support]
        ways = [sense * turn * (a - self.arms[support]) for a in self.arms]
        forces = self.frictions(ways, r, support)
        point = turn * omega * arm + self.ratio * v
        # what holds the support, without the part in proportion to omega'
        held = self.total * (turn * omega * (self.ratio * v + point) + self.ratio * w)
        held -= sum(forces)
        spin = (self.moments(forces, omega, slider) - cross(arm, held)) / (
            self.inertia(r) + self.total * dot(arm, arm)
        )
        return spin, point, held + self.total * turn * spin * arm

    def pivoting(self, piece, support, sense):
        """Rates of a state while the body turns about a support."""

        def rates(state):
            spin, point, _ = self.pivot(piece, support, sense, state)
            return [mpc(0), spin, point * turned(state[3]), state[1], mpfr(1)]

        return rates

    def holds(self, piece, support, sense, state):
        """Whether friction suffices to hold a support."""
        force = self.pivot(piece, support, sense, state)[2]
        r = piece.at(state[4])[0]
        return abs(force) <= self.p["friction"] * self.loads(r)[support]

    def begins(self, piece):
        """p' and omega' of a body at rest whose slider begins to move: each friction force is
        against its support's acceleration. Newton's method, from the motion without friction."""
        r, _, w = piece.at(mpfr(0))
        drive = self.moments([mpc(0)] * 3, mpfr(0), (r, mpc(0), w)) / self.inertia(r)

        def off(x, y, spin):
            values = mpc(mpfr(str(x)), mpfr(str(y))), mpfr(str(spin))
            ways = self.velocities(*values, r, w)
            forces = self.frictions(ways, r)
            push = values[0] - sum(forces) / self.total
            turn = self.moments(forces, mpfr(0), (r, mpc(0), w)) / self.inertia(r)
            return [mpmath.mpf(str(z)) for z in (push.real, push.imag, values[1] - turn)]

        def near(x):
            return np.array([float(value) for value in off(*map(float, x))])

        # what is left falls without end but where one of the supports would not move
        close = least_squares(near, [0.0, 0.0, float(drive)], xtol=1e-15, x_scale="jac")
        with mpmath.workdps(38):
            try:
                size = abs(complex(w)) ** 2
                found = mpmath.findroot(off, tuple(close.x), tol=1e-50 * size, maxsteps=60)
            except (ValueError, ZeroDivisionError):
                raise Unknown from None
        x, y, spin = (mpfr(mpmath.nstr(value, 38)) for value in found)
        return mpc(x, y), spin


@dataclass(frozen=True)
class Motion:
    """A body, the pieces of its slider's path, p and omega at the start, or rest."""

    body: Body
    pieces: tuple
    point: object = mpc(0)
    omega: object = mpfr(0)

    def observed(self, times):
        """Observables at ascending `times`, by name, up to the last one that is known."""
        rows = []
        try:
            for row in self._rows(iter(times)):
                rows.append(row)
        except Unknown:
            pass
        return {name: [row[name] for row in rows] for name in rows[0]} if rows else {}

    def _rows(self, times):
        """Observables at one time after another."""
        body = self.body
        state = [self.point, self.omega, body.ratio * self.pieces[0].at(mpfr(0))[0], mpfr(0)]
        mode = "slide"
        begun = mpfr(0)
        until = next(times, None)
        for number, piece in enumerate(self.pieces):
            state = [*state[:4], mpfr(0)]
            if number == 0 and not self.omega:
                state = self._begun(piece)
            while until is not None:
                wanted = min(until - begun, piece.duration)
                state, mode = self._moved(piece, state, mode, wanted)
                if begun + piece.duration < until:
                    break
                yield self._observed(piece, state, mode)
                until = next(times, None)
            begun += piece.duration

    def _begun(self, piece):
        """The state shortly after the start from rest."""
        push, spin = self.body.begins(piece)
        time = BEGUN * piece.duration
        centre = self.body.ratio * piece.at(mpfr(0))[0]
        return [push * time, spin * time, centre + push * time**2 / 2, spin * time**2 / 2, time]

    def _moved(self, piece, state, mode, wanted):
        """The state at a time of the piece, and the mode then."""
        body = self.body
        while state[4] < wanted:
            if mode == "rest":
                if not isinstance(piece, Fixed):
                    raise Unknown
                return [*state[:4], wanted], mode
            if mode == "slide":
                state, still = self._slid(piece, state, wanted)
                if still is None:
                    continue
                mode = "rest" if still == "all" else (still, 1 if state[1] > 0 else -1)
            else:
                if not body.holds(piece, *mode, state):
                    raise Unknown
                state, mode = self._pivoted(piece, state, mode, wanted)
            if mode == "rest":
                state = [mpc(0), mpfr(0), *state[2:]]
        return state, mode

    def _speeds(self, piece, state):
        ways = self.body.velocities(*state[:2], *piece.at(state[4])[:2])
        return [abs(way) for way in ways]

    def _slid(self, piece, state, wanted):
        """The state at the end of sliding, and which support has stopped, if one has: its number,
        or all."""
        rates = self.body.sliding(piece)
        fastest = max(self._speeds(piece, state))
        step = min(wanted - state[4], state[4] or wanted) / 4
        left = iter(range(STEPS))
        while state[4] < wanted:
            ahead = min(step, wanted - state[4])
            if ahead < SMALLEST * wanted or next(left, None) is None:
                raise Unknown
            reached, error = extrapolated(rates, state, ahead)
            if not error < AGREED:
                step = ahead / 2
                continue
            last = ahead == wanted - state[4]
            state = [*reached[:4], wanted] if last else reached
            step = ahead * GROWTH if error < AGREED / 1000 else ahead
            speeds = self._speeds(piece, state)
            fastest = max(fastest, *speeds)
            if min(speeds) < STILL * fastest:
                stopped = speeds.index(min(speeds))
                return state, "all" if max(speeds) < ALL_STILL * fastest else stopped
        return state, None

    def _pivoted(self, piece, state, mode, wanted):
        """The state at the end of a pivot, and the mode then."""
        rates = self.body.pivoting(piece, *mode)
        step = (wanted - state[4]) / 4
        begun = abs(state[1])
        while state[4] < wanted:
            spin = rates(state)[1]
            ahead = min(step, wanted - state[4])
            if ahead < SMALLEST * wanted:
                raise Unknown
            if spin * mode[1] < 0:  # Newton's method for the time at which the turning ends
                ahead = min(ahead, -state[1] / spin)
            reached, error = extrapolated(rates, state, ahead)
            if not error < AGREED:
                step = ahead / 2
                continue
            state = [*reached[:4], wanted] if ahead == wanted - state[4] else reached
            if not self.body.holds(piece, *mode, state):
                raise Unknown
            if abs(state[1]) < STILL * begun:
                return state, "rest"
        return state, mode

    def _observed(self, piece, state, mode):
        body = self.body
        point, omega, centre, heading, time = state
        r, v, _ = piece.at(time)
        if isinstance(mode, tuple):
            point = body.pivot(piece, *mode, state)[1]
        ahead = turned(heading)
        place = centre - ahead * body.ratio * r
        velocity = (
            ahead * (point - body.ratio * (mpc(0, 1) * omega * r + v))
            if mode != "rest"
            else mpc(0)
        )
        return {
            "x": place.real,
            "y": place.imag,
            "velocity_x": velocity.real,
            "velocity_y": velocity.imag,
            "heading": heading,
            "heading_rate": omega,
            **{f"normal_force_{i}": n for i, n in enumerate(body.loads(r), start=1)},
        }


def coast(p):
    """Coasting with spin."""
    body = Body(p)
    r = mpc(*p["slider"])
    omega = p["heading_rate"]
    point = mpc(p["velocity_x"], p["velocity_y"]) + mpc(0, 1) * omega * body.ratio * r
    # C begins at the origin
    return Motion(body, (Fixed(r),), point, omega)


def turn(p):
    """The turn manoeuvre, and the coasting after it (Chernousko 2020, eq. 29)."""
    radius, push, half = p["radius"], p["angular_acceleration"], p["half_time"]
    middle = p["start"] + push * half**2 / 2
    there = Arc(radius, p["start"], mpfr(0), push, half)
    back = Arc(radius, middle, push * half, -push, half)
    return Motion(Body(p), (there, back, Fixed(radius * turned(p["start"] + push * half**2))))


def draw_coast(rng):
    """Slow and fast, with little spin and much."""
    p = body(rng)
    speeds = {"velocity_x": either(rng, 1e-2, 10), "velocity_y": either(rng, 1e-2, 10)}
    speed = float(np.hypot(*speeds.values()))
    # at most some ten turns until the body stops
    slowing = p["friction"] * p["gravity"]
    spin = min(speed * log(rng, 0.1, 100), 10 * slowing**0.5) * float(rng.choice([-1, 1]))
    p |= {"slider": place(rng), **speeds, "heading_rate": spin}
    return p, 1.3 * (speed + 0.2 * abs(spin)) / p["friction"] / p["gravity"]


def draw_turn(rng):
    """Fast and slow ones, to either side, the slider by a part of a circle or round ten times;
    epsilon of the source to 0.5."""
    p = body(rng)
    radius = log(rng, 0.02, 0.2)
    total = p["body_mass"] + p["slider_mass"]
    mu = p["slider_mass"] / total
    carried = mu * p["body_mass"] * radius**2
    inertia = p["inertia"] + carried
    arm = max(np.hypot(*arm) for arm in p["supports"]) + mu * radius
    tau = log(rng, 0.01, 0.5) / np.sqrt(arm * p["friction"] * p["gravity"] * total / inertia)
    push = either(rng, 0.1, 60) / tau**2
    return p | {
        "radius": radius,
        "start": float(rng.uniform(-3, 3)),
        "angular_acceleration": float(push),
        "half_time": float(tau),
    }, 4 * tau


ON_SUPPORTS = {
    "capsule-coast/spin": (draw_coast, coast),
    "capsule-turn": (draw_turn, turn),
}
