"""Derivatives of motions by differences of 60-digit solutions; it takes some minutes.

`python -m plumbob.tests.sensitivity.recorded` writes recorded.json anew, for the parameters
in it, which were drawn at random: an independent method, from the equations of motion in other
variables, with neither a variational equation nor a chain rule. Turns, coasts and plans go through
stops and pivots, of which smoothed friction knows none: to some 1e-8 of scale.
"""

import json
from pathlib import Path

import gmpy2
import numpy as np
from gmpy2 import mpfr

from plumbob.models.gradient import numbers
from plumbob.models.registry import case_of, scene
from plumbob.tests.smooth_systems.recorded_chains import slope
from plumbob.tests.support.extrapolation import states, tuples
from plumbob.tests.support.smoothed_friction import smoothed_pose

FILE = Path(__file__).with_suffix(".json")
STEP = mpfr("1e-12")  # of a parameter: a difference's error is its square
DIGITS = 17
ANGLE = ("theta", "theta_dot")
LONGEST = {"cone-pendulum": 0.02, "four-bar": 0.02, "n-pendulum": 0.02}  # step [s]; else 0.1
POSE = ("x", "y", "heading")
STENCIL = {1: 45, 2: -9, 3: 1}  # of order 6
# From one pose to the next, of a parameter; width of the friction [m/s] and order of its error: all
# of these, and of turns with a gradual start.
SHARP = (3e-3, 1e-9, 1.0)
GRADUAL = (1e-3, 1e-10, 0.8)
NUDGE = mpfr("1e-18")  # [rad] of a crank: its energies' differences have an error of the square


def cone(p):
    """The cone pendulum, whose moments about the pivot follow from its shape where these are not
    given, under gravity and the centrifugal force of every mass element."""
    if "mass" in p:
        mass = p["mass"]
        arm = p["com_distance"]
        yz = p["inertia_yz"]
        x = p["inertia_x"]
        y = p["inertia_y"]
        z = p["inertia_z"]
    else:
        radius = p["height"] * gmpy2.tan(p["apex_angle"] / 2)
        mass = gmpy2.const_pi() * p["density"] * radius**2 * p["height"] / 3
        arm = 3 * p["height"] / 4
        yz = mpfr(0)
        z = 3 * mass * radius**2 / 10
        x = y = 3 * mass * (radius**2 / 4 + p["height"] ** 2) / 5
    squared = p["platform_rate"] ** 2

    def rates(state):
        theta, rate = state
        sine, cosine = gmpy2.sin_cos(theta)
        moment = squared * (y - z) * sine * cosine - mass * arm * p["gravity"] * sine
        moment += squared * mass * arm * p["pivot_y"] * cosine
        moment += squared * yz * (cosine**2 - sine**2)
        return [rate, moment / x]

    return rates, [p["theta"], p["theta_dot"]], lambda s: dict(zip(ANGLE, s, strict=True))


def pendulum(p, linear=False):
    """The simple pendulum, or its linear companion; the third number of the state is the time."""

    def rates(state):
        theta, rate, time = state
        pull = theta if linear else gmpy2.sin(theta)
        force = p["forcing_amplitude"] * gmpy2.sin(p["forcing_frequency"] * time)
        return [
            rate,
            force - p["damping_rate"] * rate - p["gravity"] / p["length"] * pull,
            mpfr(1),
        ]

    def read(state):
        theta, rate, _ = state
        angles = {"theta": theta, "theta_dot": rate}
        if linear:
            return angles
        radial = p["length"] * rate**2 + p["gravity"] * gmpy2.cos(theta)
        return {**angles, "tension": p["mass"] * radial}

    return rates, [p["theta"], p["theta_dot"], mpfr(0)], read


def free(p):
    """Euler's equations and the attitude's."""
    a, b, c = (p[f"inertia_{axis}"] for axis in "xyz")
    spin = [p[f"angular_velocity[{i}]"] for i in range(3)]
    names = [
        *(f"angular_velocity_{axis}" for axis in "xyz"),
        *(f"attitude_{i}" for i in "wxyz"),
    ]

    def rates(state):
        u, v, w, s, x, y, z = state
        turned = (-x * u - y * v - z * w, s * u + y * w - z * v, s * v + z * u - x * w)
        last = s * w + x * v - y * u
        turning = ((b - c) / a * v * w, (c - a) / b * w * u, (a - b) / c * u * v)
        return [*turning, *(part / 2 for part in (*turned, last))]

    return rates, [*spin, mpfr(1), *[mpfr(0)] * 3], lambda s: dict(zip(names, s, strict=True))


def linkage(p, links):
    """A crank that moves other links: I w' + I_t w^2/2 + V_t = 0, by differences of I and V."""

    def energies(angle):
        inertia = mpfr(0)
        height = mpfr(0)
        for mass, length, velocity, turn, y in links(angle)[0]:
            inertia += mass * (gmpy2.norm(velocity) + (length * turn) ** 2 / 12)
            height += mass * y
        return inertia, p["gravity"] * height

    def rates(state):
        angle, w = state
        (less, low), here, (more, high) = (energies(angle + k * NUDGE) for k in (-1, 0, 1))
        return [w, -((more - less) / 2 * w**2 + high - low) / (2 * NUDGE * here[0])]

    return rates, [p["angle"], p["angular_velocity"]]


def turned(length, angle):
    """A link as a complex number."""
    return length * gmpy2.mpc(gmpy2.cos(angle), gmpy2.sin(angle))


def four_bar(p):
    """Mass, length, velocity, turn and height of each link by the crank's angle, by the law of
    cosines; the coupler's centre."""

    def links(angle):
        crank = turned(p["crank"], angle)
        (b, c) = (p["coupler"], p["rocker"])
        line = p["ground"] - crank
        inner = gmpy2.acos((b**2 + gmpy2.norm(line) - c**2) / (2 * b * abs(line)))
        coupler = turned(b, gmpy2.phase(line) + inner)
        rocker = coupler - line
        ahead = crank * 1j
        turn = -(ahead * rocker.conjugate()).real / (coupler * 1j * rocker.conjugate()).real
        end = ahead + coupler * 1j * turn
        return (
            (p["crank_mass"], p["crank"], ahead / 2, 1, crank.imag / 2),
            (p["coupler_mass"], b, ahead / 2 + end / 2, turn, (crank + coupler / 2).imag),
            (p["rocker_mass"], c, end / 2, (end / (rocker * 1j)).real, rocker.imag / 2),
        ), crank + coupler / 2

    def read(state):
        middle = links(state[0])[1]
        return {"angle": state[0], "coupler_x": middle.real, "coupler_y": middle.imag}

    return *linkage(p, links), read


def chain(p):
    """Three rods, each by its own equations; the end of the last."""
    names = "masses", "lengths", "angles", "angular_velocities"
    masses, lengths, *start = ([p[f"{name}[{i}]"] for i in range(3)] for name in names)

    def read(state):
        tip = sum(turned(*rod) for rod in zip(lengths, state[:3], strict=True))
        return {"tip_x": tip.imag, "tip_z": -tip.real}

    return slope(masses, lengths, p["gravity"]), start[0] + start[1], read


EQUATIONS = {
    "cone-pendulum": cone,
    "simple-pendulum": pendulum,
    "linear-pendulum": lambda p: pendulum(p, linear=True),
    "free-body": free,
    "four-bar": four_bar,
    "n-pendulum": chain,
}


def _through_events(case, by, times):
    """Each parameter in `by` with the derivatives of the pose at all times."""
    apart, *accuracy = (
        GRADUAL if case.scene.name in ("capsule-turn/held", "capsule-turn/pivot") else SHARP
    )

    def poses(problem):
        setup = problem.setup
        path = problem.motion.path
        start = np.array([0.0, 0.0, 0.0, *setup.velocity, setup.heading_rate])
        return np.array(
            [smoothed_pose(setup.capsule, path, start, t, *accuracy).pose for t in times]
        )

    for name in by:
        number = next(numbers(case, name))
        ends = [
            poses(number.problem(number.value + k * apart * number.size)) for k in range(-3, 4)
        ]
        slopes = sum(w * (ends[3 + k] - ends[3 - k]) for k, w in STENCIL.items())
        slopes /= 60 * apart * number.size
        yield name, {n: [f"{x:.11g}" for x in s] for n, s in zip(POSE, slopes.T, strict=True)}


def _derived(system, parameters, times):
    """Each parameter with the derivatives of every observable at all times."""
    longest = LONGEST.get(system, 0.1)
    exact = {name: mpfr(value) for name, value in parameters.items()}
    for name, value in exact.items():
        step = STEP * (abs(value) or 1)
        ends = []
        for sign in (1, -1):
            rates, start, read = EQUATIONS[system]({**exact, name: value + sign * step})
            ends.append([read(state) for state in states((rates, start, times), longest)])
        yield (
            name,
            {
                observable: [
                    f"{(above[observable] - below[observable]) / (2 * step):.{DIGITS}g}"
                    for above, below in zip(*ends, strict=True)
                ]
                for observable in ends[0][0]
            },
        )


def write():
    """Record the derivatives of every set of parameters anew."""
    table = json.loads(FILE.read_text("utf-8"))
    with gmpy2.context(gmpy2.get_context(), precision=200):
        for of in table:
            if of["scene"] in EQUATIONS:
                of["by"] = dict(_derived(of["scene"], of["numbers"], of["times"]))
            else:
                case = case_of(scene(of["scene"], tuples(of["parameters"])))
                of["by"] = dict(_through_events(case, of["by"], of["times"]))
            print(of["scene"], flush=True)
    FILE.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    write()
