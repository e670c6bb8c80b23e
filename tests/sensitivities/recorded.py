"""Derivatives of motions by differences of 60-digit solutions; it takes some minutes.

`python -m plumbob.tests.sensitivities.recorded` writes recorded.json anew, for the parameters
in it, which were drawn at random: an independent method, from the equations of motion in other
variables, with neither a variational equation nor a chain rule.
"""

import json
from pathlib import Path

import gmpy2
from gmpy2 import mpfr

from plumbob.tests.smooth_systems.recorded_chains import slope
from plumbob.tests.support.extrapolation import states

FILE = Path(__file__).with_suffix(".json")
STEP = mpfr("1e-12")  # of a parameter: a difference's error is its square
DIGITS = 17
ANGLE = ("theta", "theta_dot")
LONGEST = {  # step [s]; else 0.1
    **{"cone-pendulum": 0.02, "capsule-coast": 0.01, "slider-crank": 0.02, "four-bar": 0.02},
    **{"n-pendulum": 0.02, "heavy-top": 0.01},
}
NUDGE = mpfr("1e-18")  # [rad] of a crank: its energies' differences have an error of the square


def cone(p):
    """The cone pendulum, whose moments about the pivot follow from its shape where these are not
    given, under gravity and the centrifugal force of every mass element."""
    if "mass" in p:
        mass, arm, yz = p["mass"], p["com_distance"], p["inertia_yz"]
        x, y, z = p["inertia_x"], p["inertia_y"], p["inertia_z"]
    else:
        radius = p["height"] * gmpy2.tan(p["apex_angle"] / 2)
        mass = gmpy2.const_pi() * p["density"] * radius**2 * p["height"] / 3
        arm, yz = 3 * p["height"] / 4, mpfr(0)
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
    names = [*(f"angular_velocity_{axis}" for axis in "xyz"), *(f"attitude_{i}" for i in "wxyz")]

    def rates(state):
        u, v, w, s, x, y, z = state
        turned = (-x * u - y * v - z * w, s * u + y * w - z * v, s * v + z * u - x * w)
        last = s * w + x * v - y * u
        turning = ((b - c) / a * v * w, (c - a) / b * w * u, (a - b) / c * u * v)
        return [*turning, *(part / 2 for part in (*turned, last))]

    return rates, [*spin, mpfr(1), *[mpfr(0)] * 3], lambda s: dict(zip(names, s, strict=True))


def coast(p):
    """A body on three sliding supports with the slider fixed, from Newton's equations of both in
    the axes of the ground, which are the body's at the start."""
    body, slider, arms = p["body_mass"], p["slider_mass"], []
    arms = [(p[f"supports[{i}][0]"], p[f"supports[{i}][1]"]) for i in range(3)]
    place = (p["slider[0]"], p["slider[1]"])
    loads = _loads(body * p["gravity"], slider * p["gravity"], arms, place)

    def rates(state):
        _, _, psi, vx, vy, omega = state
        sine, cosine = gmpy2.sin_cos(psi)

        def turned(point):
            return cosine * point[0] - sine * point[1], sine * point[0] + cosine * point[1]

        fx = fy = moment = mpfr(0)
        for load, arm in zip(loads, arms, strict=True):
            x, y = turned(arm)
            sx, sy = vx - omega * y, vy + omega * x
            size = p["friction"] * load / gmpy2.sqrt(sx**2 + sy**2)
            fx, fy = fx - size * sx, fy - size * sy
            moment += size * (y * sx - x * sy)
        rx, ry = turned(place)
        # (M + m) a + m alpha k x r = F + m omega^2 r; m r x a + (J + m r^2) alpha = moment.
        total, both = body + slider, p["inertia"] + slider * (rx**2 + ry**2)
        gx, gy = fx + slider * omega**2 * rx, fy + slider * omega**2 * ry
        inner = both - slider**2 * (rx**2 + ry**2) / total
        alpha = (moment - slider * (rx * gy - ry * gx) / total) / inner
        return [
            vx,
            vy,
            omega,
            (gx + slider * alpha * ry) / total,
            (gy - slider * alpha * rx) / total,
            alpha,
        ]

    def read(state):
        x, y, psi, vx, vy, omega = state
        names = ("x", "y", "velocity_x", "velocity_y", "heading", "heading_rate")
        values = (x, y, vx, vy, p["heading"] + psi, omega)
        named = dict(zip(names, values, strict=True))
        return named | {f"normal_force_{i}": load for i, load in enumerate(loads, start=1)}

    zero = mpfr(0)
    start = [zero, zero, zero, p["velocity_x"], p["velocity_y"], p["heading_rate"]]
    return rates, start, read


def _loads(body, slider, arms, place):
    """Loads that balance the weights of body and slider, by Cramer's rule."""
    (x1, y1), (x2, y2), (x3, y3) = arms
    area = (x2 - x1) * (y3 - y1) - (x3 - x1) * (y2 - y1)
    px, py = (slider * place[k] / (body + slider) for k in (0, 1))
    corners = (((x2, y2), (x3, y3)), ((x3, y3), (x1, y1)), ((x1, y1), (x2, y2)))
    return [
        (body + slider) * ((ax - px) * (by - py) - (bx - px) * (ay - py)) / area
        for (ax, ay), (bx, by) in corners
    ]


def linkage(p, links):
    """A crank that moves other links: I w' + I_t w^2/2 + V_t = 0, by differences of I and V."""

    def energies(angle):
        inertia, height = mpfr(0), mpfr(0)
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


def slider_crank(p):
    """Mass, length, velocity, turn and height of each link by the crank's angle; the slider."""

    def links(angle):
        crank = turned(p["crank"], angle)
        rod = gmpy2.mpc(gmpy2.sqrt(p["rod"] ** 2 - crank.imag**2), -crank.imag)
        turn, half = -crank.real / rod.real, crank.imag / 2
        ahead, along = crank * 1j, rod * 1j * turn
        return (
            (p["crank_mass"], p["crank"], ahead / 2, 1, half),
            (p["rod_mass"], p["rod"], ahead + along / 2, turn, half),
            (p["slider_mass"], 0, ahead + along, 0, 0),
        ), (crank + rod).real

    return *linkage(p, links), lambda s: {"angle": s[0], "slider": links(s[0])[1]}


def four_bar(p):
    """The same, by the law of cosines; the coupler's centre."""

    def links(angle):
        crank, (b, c) = turned(p["crank"], angle), (p["coupler"], p["rocker"])
        line = p["ground"] - crank
        inner = gmpy2.acos((b**2 + gmpy2.norm(line) - c**2) / (2 * b * abs(line)))
        coupler = turned(b, gmpy2.phase(line) + inner)
        rocker, ahead = coupler - line, crank * 1j
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


def top(p):
    """Lagrange's top by its two momenta."""
    across = p["inertia_across"] + p["mass"] * p["length"] ** 2
    sine, cosine = gmpy2.sin_cos(p["tilt"])
    along = p["inertia_axis"] * (p["spin_rate"] + p["precession_rate"] * cosine)
    vertical = across * p["precession_rate"] * sine**2 + along * cosine
    weight = p["mass"] * p["gravity"] * p["length"]

    def rates(state):
        _, tilt, _, rate = state
        sine, cosine = gmpy2.sin_cos(tilt)
        around = (vertical - along * cosine) / (across * sine**2)
        moment = (across * around**2 * cosine - along * around + weight) * sine
        return [around, rate, along / p["inertia_axis"] - around * cosine, moment / across]

    start = [mpfr(0), p["tilt"], mpfr(0), p["tilt_rate"]]
    return rates, start, lambda s: dict(zip(("precession", "tilt", "spin"), s, strict=False))


EQUATIONS = {
    "cone-pendulum": cone,
    "simple-pendulum": pendulum,
    "linear-pendulum": lambda p: pendulum(p, linear=True),
    "free-body": free,
    "capsule-coast": coast,
    "slider-crank": slider_crank,
    "four-bar": four_bar,
    "n-pendulum": chain,
    "heavy-top": top,
}


def nested(values):
    """Parameters as `--set` takes them, from numbers with indices in their order."""
    found = {}
    for name, value in values.items():
        head, *indices = name.replace("]", "").split("[")
        if not indices:
            found[head] = value
        elif indices[1:] and int(indices[1]):
            found[head] = (*found[head][:-1], (*found[head][-1], value))
        else:
            found[head] = (*found.get(head, ()), (value,) if indices[1:] else value)
    return found


def scene_of(system):
    """The scene whose parameters are replaced."""
    return "capsule-coast/spin" if system == "capsule-coast" else system


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
            of["by"] = dict(_derived(of["system"], of["parameters"], of["times"]))
            print(of["system"], flush=True)
    FILE.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    write()
