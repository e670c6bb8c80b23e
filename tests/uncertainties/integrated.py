"""Smooth systems at random, far from the numbers of their scenes, and their motions with 30 digits:
equations written anew from the source of each system, extrapolated in gmpy2's numbers."""

from dataclasses import dataclass
from functools import partial

import gmpy2
import numpy as np
from gmpy2 import mpfr

from plumbob.tests.support.extrapolation import midpoint

COLUMNS = 13  # of the extrapolation: order 26
AGREED = mpfr("1e-27")  # of a state, or of 1: two columns' difference in a step
GROWTH = mpfr("1.6")  # of a step after one that was right


def followed(rates, state, times, step):
    """The state at ascending `times` [s], by extrapolation of Gragg's midpoint rule (1965, SIAM J.
    Numer. Anal. 2, 384) in steps from `step` [s] on that choose themselves."""
    time = mpfr(0)
    states = []
    for until in times:
        while time < until:
            ahead = min(step, until - time)
            reached, error = extrapolated(rates, state, ahead)
            if error > AGREED:
                step = ahead / 2
                continue
            time = until if ahead == until - time else time + ahead
            state = reached
            step = max(step, ahead * GROWTH) if error < AGREED / 1000 else step
        states.append(state)
    return states


def extrapolated(rates, state, step):
    """The state after a step, and the difference of the last two columns."""
    table = []
    for k in range(1, COLUMNS + 1):
        row = [midpoint(rates, state, step, 2 * k)]
        for j, before in enumerate(table, start=1):
            ratio = (mpfr(k) / (k - j)) ** 2 - 1
            row.append([x + (x - y) / ratio for x, y in zip(row[-1], before, strict=True)])
        table = row
    pairs = zip(table[-1], table[-2], strict=True)
    return table[-1], max(abs(x - y) / (1 + abs(x)) for x, y in pairs)


@dataclass(frozen=True)
class Equations:
    """The rates of a state, its start, a first step [s], and what is observed of a state."""

    rates: object
    start: list
    step: object
    read: object

    def observed(self, times):
        """Observables at ascending `times` [s], by name."""
        rows = [
            self.read(state) for state in followed(self.rates, self.start, times, self.step)
        ]
        return {name: [row[name] for row in rows] for name in rows[0]}


def pendulum(p, linear=False):
    """Pendulum of one rod: theta'' = A sin(W t) - c theta' - (g/L) sin theta."""
    pull = p["gravity"] / p["length"]

    def rates(state):
        theta, rate, time = state
        push = p["forcing_amplitude"] * gmpy2.sin(p["forcing_frequency"] * time)
        back = theta if linear else gmpy2.sin(theta)
        return [rate, push - p["damping_rate"] * rate - pull * back, mpfr(1)]

    def read(state):
        theta, rate, _ = state
        tension = p["length"] * rate**2 + p["gravity"] * gmpy2.cos(theta)
        observed = {"theta": theta, "theta_dot": rate}
        return observed if linear else {**observed, "tension": tension}

    return Equations(
        rates, [p["theta"], p["theta_dot"], mpfr(0)], _pace(gmpy2.sqrt(pull)), read
    )


def cone(p):
    """Sudakov 2015, eq. 7, of a cone per kilogram, I theta'' = a sin 2 theta + b cos - c sin."""
    square = gmpy2.tan(p["apex_angle"] / 2) ** 2
    across = 3 * p["height"] ** 2 * (4 + square) / 20
    along = 3 * p["height"] ** 2 * square / 10
    arm = 3 * p["height"] / 4
    a = (across - along) / 2 * p["platform_rate"] ** 2
    b = p["pivot_y"] * arm * p["platform_rate"] ** 2
    c = p["gravity"] * arm

    def rates(state):
        theta, rate = state
        sine, cosine = gmpy2.sin_cos(theta)
        return [rate, (2 * a * sine * cosine + b * cosine - c * sine) / across]

    fastest = gmpy2.sqrt((2 * abs(a) + abs(b) + c) / across)
    return Equations(rates, [p["theta"], p["theta_dot"]], _pace(fastest), _named(*ONE))


ONE = "theta", "theta_dot"


def _named(*names):
    return lambda state: dict(zip(names, state, strict=True))


def _pace(*rates):
    """A step [s] in which little changes at these rates [1/s]."""
    return 1 / (1 + sum(map(abs, rates)))


def top(p):
    """Lagrange's top by its two constant angular momenta, about the vertical and its axis."""
    across = p["inertia_across"] + p["mass"] * p["length"] ** 2
    axis = p["inertia_axis"]
    weight = p["mass"] * p["gravity"] * p["length"]
    sine, cosine = gmpy2.sin_cos(p["tilt"])
    along = axis * (p["spin_rate"] + p["precession_rate"] * cosine)
    upright = across * p["precession_rate"] * sine**2 + along * cosine

    def turning(tilt):
        sine, cosine = gmpy2.sin_cos(tilt)
        around = (upright - along * cosine) / (across * sine**2)
        return sine, cosine, around, along / axis - around * cosine

    def rates(state):
        _, tilt, _, leans = state
        sine, cosine, around, spin = turning(tilt)
        pull = sine * (weight - along * around) / across
        return [around, leans, spin, pull + around**2 * sine * cosine]

    def read(state):
        _, _, around, spin = turning(state[1])
        return _turns(*state[:3], around, state[3], spin)

    start = [mpfr(0), p["tilt"], mpfr(0), p["tilt_rate"]]
    pace = _pace(p["spin_rate"], p["precession_rate"], p["tilt_rate"])
    return Equations(rates, start, pace, read)


def _turns(*values):
    angles = "precession", "tilt", "spin"
    return dict(zip((*angles, *(f"{name}_rate" for name in angles)), values, strict=True))


def disc(p):
    """A rolling disc by its rates about a horizontal diameter, across that and about the axis
    (O'Reilly 1996, Nonlinear Dyn. 10, 287)."""
    pull = p["gravity"] / p["radius"]

    def rates(state):
        _, tilt, _, leans, across, along = state
        sine, cosine = gmpy2.sin_cos(tilt)
        around = across / sine
        return [
            around,
            leans,
            along - around * cosine,
            (across * around * cosine - 6 * across * along - 4 * pull * cosine) / 5,
            leans * (2 * along - around * cosine),
            2 * across * leans / 3,
        ]

    def read(state):
        sine, cosine = gmpy2.sin_cos(state[1])
        around = state[4] / sine
        return _turns(*state[:3], around, state[3], state[5] - around * cosine)

    sine, cosine = gmpy2.sin_cos(p["tilt"])
    turn = p["precession_rate"]
    zero = mpfr(0)
    start = [zero, p["tilt"], zero, p["tilt_rate"], turn * sine, p["spin_rate"] + turn * cosine]
    return Equations(rates, start, _pace(turn, p["tilt_rate"], p["spin_rate"]), read)


def slider_crank(p):
    """Lagrange's equation of the crank's angle, the rod's by l sin b = -a sin t."""
    a, length, g = p["crank"], p["rod"], p["gravity"]
    first, second, third = p["crank_mass"], p["rod_mass"], p["slider_mass"]

    def rates(state):
        t, rate = state
        sine, cosine = gmpy2.sin_cos(t)
        low = -a * sine / length
        level = gmpy2.sqrt(1 - low**2)
        turn = -a * cosine / (length * level)
        more = a * sine / (length * level) + turn**2 * low / level
        ends = [-a * sine - part * low * turn for part in (length / 2, length)]
        curves = [
            -a * cosine - part * (level * turn**2 + low * more) for part in (length / 2, length)
        ]
        inertia = (
            first * a**2 / 3
            + second * (ends[0] ** 2 + (a * cosine / 2) ** 2 + (length * turn) ** 2 / 12)
            + third * ends[1] ** 2
        )
        half_slope = (
            second
            * (ends[0] * curves[0] - a**2 * sine * cosine / 4 + length**2 * turn * more / 12)
            + third * ends[1] * curves[1]
        )
        moment = (first + second) * g * a * cosine / 2
        return [rate, -(half_slope * rate**2 + moment) / inertia]

    def read(state):
        sine, cosine = gmpy2.sin_cos(state[0])
        place = a * cosine + gmpy2.sqrt(length**2 - (a * sine) ** 2)
        return {"angle": state[0], "angle_dot": state[1], "slider": place}

    pace = _pace(p["angular_velocity"], gmpy2.sqrt(g / a))
    return Equations(rates, [p["angle"], p["angular_velocity"]], pace, read)


def four_bar(p):
    """Lagrange's equation of the crank's angle; coupler and rocker turn as the closed loop does."""
    a, b, c, d = (p[name] for name in ("crank", "coupler", "rocker", "ground"))
    first, second, third = (p[f"{name}_mass"] for name in ("crank", "coupler", "rocker"))
    g = p["gravity"]

    def solved(f, r, right):
        """Of b sin f x - c sin r y = right, b cos f x - c cos r y = right."""
        sine_f, cosine_f = gmpy2.sin_cos(f)
        sine_r, cosine_r = gmpy2.sin_cos(r)
        size = b * c * (cosine_f * sine_r - sine_f * cosine_r)
        x = (-c * cosine_r * right[0] + c * sine_r * right[1]) / size
        y = (b * sine_f * right[1] - b * cosine_f * right[0]) / size
        return x, y

    def rates(state):
        t, rate, f, r = state
        (sine, cosine), (sine_f, cosine_f), (sine_r, cosine_r) = map(gmpy2.sin_cos, (t, f, r))
        turn, rocks = solved(f, r, (-a * sine, -a * cosine))
        more = (
            -a * cosine - b * cosine_f * turn**2 + c * cosine_r * rocks**2,
            a * sine + b * sine_f * turn**2 - c * sine_r * rocks**2,
        )
        bend, rock = solved(f, r, more)
        x = -a * sine - b / 2 * sine_f * turn
        y = a * cosine + b / 2 * cosine_f * turn
        x_more = -a * cosine - b / 2 * (cosine_f * turn**2 + sine_f * bend)
        y_more = -a * sine - b / 2 * (sine_f * turn**2 - cosine_f * bend)
        inertia = (first * a**2 + third * (c * rocks) ** 2) / 3 + second * (
            x**2 + y**2 + (b * turn) ** 2 / 12
        )
        half_slope = third * c**2 * rocks * rock / 3
        half_slope += second * (x * x_more + y * y_more + b**2 * turn * bend / 12)
        moment = g * (first * a / 2 * cosine + second * y + third * c / 2 * cosine_r * rocks)
        return [rate, -(half_slope * rate**2 + moment) / inertia, turn * rate, rocks * rate]

    def read(state):
        (sine, cosine), (sine_f, cosine_f) = map(gmpy2.sin_cos, (state[0], state[2]))
        return {
            "angle": state[0],
            "angle_dot": state[1],
            "coupler_x": a * cosine + b / 2 * cosine_f,
            "coupler_y": a * sine + b / 2 * sine_f,
        }

    sine, cosine = gmpy2.sin_cos(p["angle"])
    x, y = d - a * cosine, -a * sine
    far = gmpy2.sqrt(x**2 + y**2)
    opens = gmpy2.acos((far**2 + b**2 - c**2) / (2 * far * b))
    f = gmpy2.atan2(y, x) + opens
    end = a * cosine + b * gmpy2.cos(f) - d, a * sine + b * gmpy2.sin(f)
    start = [p["angle"], p["angular_velocity"], f, gmpy2.atan2(end[1], end[0])]
    return Equations(rates, start, _pace(p["angular_velocity"], gmpy2.sqrt(g / a)), read)


def chain(p):
    """Rods that hang one on another, by Lagrange's equations."""
    masses, lengths = p["masses"], p["lengths"]
    count = len(masses)
    below = [masses[i] / 2 + sum(masses[i + 1 :]) for i in range(count)]

    def weight(i, j):
        if i == j:
            return (below[i] - masses[i] / 6) * lengths[i] ** 2
        return below[max(i, j)] * lengths[i] * lengths[j]

    weights = [[weight(i, j) for j in range(count)] for i in range(count)]

    def rates(state):
        angles, speeds = state[:count], state[count:]
        pairs = [[gmpy2.sin_cos(x - y) for y in angles] for x in angles]
        rows = []
        for i in range(count):
            pulls = [weights[i][j] * pairs[i][j][0] * speeds[j] ** 2 for j in range(count)]
            moment = -p["gravity"] * lengths[i] * below[i] * gmpy2.sin(angles[i]) - sum(pulls)
            rows.append([*(weights[i][j] * pairs[i][j][1] for j in range(count)), moment])
        return [*speeds, *_eliminated(rows)]

    def read(state):
        names = [f"angle_{i}" for i in range(1, count + 1)]
        named = dict(zip((*names, *(f"{name}_dot" for name in names)), state, strict=True))
        ends = [gmpy2.sin_cos(angle) for angle in state[:count]]
        x, z = (
            sum(part * end[k] for part, end in zip(lengths, ends, strict=True)) for k in (0, 1)
        )
        return {**named, "tip_x": x, "tip_z": -z}

    pace = _pace(*p["angular_velocities"], gmpy2.sqrt(p["gravity"] / min(lengths)))
    return Equations(rates, [*p["angles"], *p["angular_velocities"]], pace, read)


def _eliminated(rows):
    """Solution of linear equations, the right-hand side in the last column."""
    size = len(rows)
    for k in range(size):
        for row in rows[k + 1 :]:
            part = row[k] / rows[k][k]
            row[k:] = [x - part * y for x, y in zip(row[k:], rows[k][k:], strict=True)]
    found = [mpfr(0)] * size
    for k in reversed(range(size)):
        known = sum(rows[k][j] * found[j] for j in range(k + 1, size))
        found[k] = (rows[k][-1] - known) / rows[k][k]
    return found


# Each system's equations, and random parameters far from those of its scenes.


def _log(rng, low, high):
    return float(10 ** rng.uniform(np.log10(low), np.log10(high)))


def _either(rng, low, high):
    return float(rng.choice([-1, 1])) * _log(rng, low, high)


def draw_top(rng):
    """From a slow to a fast top, from nearly upright to hanging."""
    across = _log(rng, 1e-4, 1)
    return {
        "mass": _log(rng, 1e-2, 1e2),
        "length": _log(rng, 1e-2, 1),
        "inertia_across": across,
        "inertia_axis": across * _log(rng, 1e-3, 2),
        "gravity": float(rng.choice([0.0, _log(rng, 0.1, 30)], p=[0.1, 0.9])),
        "tilt": float(np.pi / (1 + _log(rng, 0.02, 50))),
        "precession_rate": _either(rng, 0.01, 30),
        "tilt_rate": _either(rng, 0.01, 10),
        "spin_rate": _either(rng, 0.1, 300),
    }


def draw_disc(rng):
    """From nearly flat to upright, fast and slow."""
    tilt = float(np.pi / (1 + _log(rng, 0.02, 50)))
    turn = _either(rng, 0.1, 30)
    flat = rng.uniform() < 0.5  # then it rolls slowly round a small circle
    spin = -turn * np.cos(tilt) + _either(rng, 0.01, 1) if flat else _either(rng, 0.1, 50)
    return {
        "radius": _log(rng, 0.01, 1),
        "gravity": _log(rng, 0.5, 30),
        "tilt": tilt,
        "precession_rate": turn,
        "tilt_rate": _either(rng, 0.01, 3),
        "spin_rate": float(spin),
    }


def draw_slider_crank(rng):
    """From a light to a very heavy slider."""
    crank = _log(rng, 0.05, 1)
    return {
        "crank": crank,
        "rod": crank * (1 + _log(rng, 0.03, 5)),
        "crank_mass": _log(rng, 0.1, 10),
        "rod_mass": _log(rng, 0.1, 10),
        "slider_mass": _log(rng, 0.01, 1000),
        "gravity": _log(rng, 0.1, 30),
        "angle": float(rng.uniform(-np.pi, np.pi)),
        "angular_velocity": _either(rng, 0.3, 30),
    }


def draw_four_bar(rng):
    """Linkages whose crank turns fully, where they are accepted."""
    crank = _log(rng, 0.05, 0.5)
    others = crank * (1 + rng.uniform(0.1, 4, 3))
    return {
        **dict(zip(("coupler", "rocker", "ground"), others.tolist(), strict=True)),
        "crank": crank,
        "crank_mass": _log(rng, 0.1, 10),
        "coupler_mass": _log(rng, 0.1, 10),
        "rocker_mass": _log(rng, 0.1, 10),
        "gravity": _log(rng, 0.1, 30),
        "angle": float(rng.uniform(-np.pi, np.pi)),
        "angular_velocity": _either(rng, 0.3, 30),
    }


def draw_chain(rng):
    """One to four rods, anywhere."""
    count = int(rng.integers(1, 5))
    several = {"masses": (0.1, 10), "lengths": (0.1, 2), "angular_velocities": (0.01, 5)}
    named = {n: tuple(_log(rng, *ends) for _ in range(count)) for n, ends in several.items()}
    angles = tuple(rng.uniform(-np.pi, np.pi, count).tolist())
    return {**named, "angles": angles, "gravity": _log(rng, 0.1, 30)}


def draw_pendulum(rng):
    """Free, damped and forced; one in four of each."""
    damped, forced = rng.integers(0, 2, 2)
    return {
        "length": _log(rng, 0.05, 10),
        "gravity": _log(rng, 0.1, 30),
        "damping_rate": float(damped) * _log(rng, 1e-3, 5),
        "forcing_amplitude": float(forced) * _log(rng, 1e-2, 5),
        "forcing_frequency": float(forced) * _log(rng, 0.1, 10),
        "theta": float(rng.uniform(-3.1, 3.1)),
        "theta_dot": float(rng.choice([0.0, _either(rng, 0.01, 20)])),
    }


def draw_cone(rng):
    """Slow and fast platforms, sharp and blunt cones, swinging and rotating."""
    return {
        "density": _log(rng, 100, 20000),
        "height": _log(rng, 0.03, 3),
        "apex_angle": float(rng.uniform(0.05, 2.9)),
        "pivot_x": 0.0,
        "pivot_y": float(rng.choice([0.0, _either(rng, 1e-3, 1)])),
        "platform_rate": float(rng.choice([0.0, _either(rng, 0.1, 60)])),
        "gravity": _log(rng, 0.1, 30),
        "theta": float(rng.uniform(-3.1, 3.1)),
        "theta_dot": float(rng.choice([0.0, _either(rng, 0.1, 60)])),
    }


SMOOTH = {
    "heavy-top": (draw_top, top),
    "rolling-disc": (draw_disc, disc),
    "slider-crank": (draw_slider_crank, slider_crank),
    "cone-pendulum": (draw_cone, cone),
    "four-bar": (draw_four_bar, four_bar),
    "linear-pendulum": (draw_pendulum, partial(pendulum, linear=True)),
    "n-pendulum": (draw_chain, chain),
    "simple-pendulum": (draw_pendulum, pendulum),
}
