"""What `solve` says of a system beside its motion, by formulas written anew, with 30 digits."""

import math

import pytest
from mpmath import mp

from plumbob.models.registry import case_of, scene, system_of


def bounced(p):
    """A ball's impacts one after another, the heights after them, and the limit of their times."""
    e, g = p["restitution"], p["gravity"]
    time = mp.sqrt(2 * p["height"] / g)
    speed = g * time
    last = time * (1 + e) / (1 - e)
    times, heights = [], []
    for _ in range(5):
        speed *= e
        times.append(time)
        heights.append(speed**2 / (2 * g))
        time += 2 * speed / g
    return {"impact_times": times, "next_heights": heights, "zeno_time": last}


def slope(p):
    """Of a cube that stops: its threshold, and where it stops."""
    down = p["gravity"] * mp.sin(p["slope"])
    held = p["friction"] * p["gravity"] * mp.cos(p["slope"])
    braked = held * mp.sign(p["speed"]) - down
    return {
        "threshold": mp.atan(p["friction"]),
        "acceleration": down - held,
        "stop_time": p["speed"] / braked,
        "stop_place": p["speed"] ** 2 / (2 * braked),
        "stays": down <= held,
    }


def rolled(p):
    """A ball that slides until it rolls, by its momenta: 2/7 of the slip is left to the spin."""
    slip = p["speed"] - p["radius"] * p["spin"]
    pull = p["friction"] * p["gravity"]
    time = 2 * slip / (7 * pull)
    place = p["speed"] * time - pull * time**2 / 2
    return {
        "rolling_time": time,
        "rolling_place": place,
        "rolling_speed": p["speed"] - pull * time,
    }


def slides(p):
    """A ball whose moment of rolling is more than its friction turns: it never rolls."""
    assert p["rolling_friction"] / p["radius"] > mp.mpf(7) / 5 * p["friction"]
    return {"rolling_time": mp.inf}


def circled(p):
    """A disc that keeps its tilt: the moment of gravity about the contact turns its momentum."""
    t, turn, r = p["tilt"], p["precession_rate"], p["radius"]

    def unbalanced(spin):
        whole = spin + turn * mp.cos(t)  # about the axis
        about = turn * mp.sin(t) * (mp.mpf(3) / 2 * whole - turn * mp.cos(t) / 4)
        return about + p["gravity"] / r * mp.cos(t)

    spin = mp.findroot(unbalanced, -p["gravity"] / (r * turn))
    return {"steady_spin": spin, "circle_radius": abs(spin / turn) * r}


def wobbled(p):
    """Of a disc upright, small tilt a and heading b: 5/4 a'' + 3/2 s b' = g/R a, b''/2 = a' s."""
    spin, pull = p["spin_rate"], p["gravity"] / p["radius"]
    return {"wobble_rate": mp.sqrt((3 * spin**2 - pull) / (mp.mpf(5) / 4))}


def held(p):
    """A cube between two fingers."""
    load = mp.hypot(p["mass"] * (p["gravity"] + p.get("lift", 0)), p.get("push", 0))
    least = load / 2 / p["friction"]
    return {"load": load, "fraction": least / p["normal_force"], "least_normal_force": least}


def spun(p):
    """Energy and momenta of a top with its point at rest."""
    across = p["inertia_across"] + p["mass"] * p["length"] ** 2
    sine, cosine = mp.sin(p["tilt"]), mp.cos(p["tilt"])
    along = p["inertia_axis"] * (p["spin_rate"] + p["precession_rate"] * cosine)
    level = across * p["precession_rate"] * sine
    turning = (
        across * p["tilt_rate"] ** 2 + level**2 / across + along**2 / p["inertia_axis"]
    ) / 2
    return {
        "energy": turning + p["mass"] * p["gravity"] * p["length"] * cosine,
        "vertical_momentum": level * sine + along * cosine,
        "axial_momentum": along,
    }


def linked(places, masses, lengths, p):
    """Energy of links whose middles' places and angles a crank's angle gives."""
    energy = mp.mpf(0)
    for i, (mass, length) in enumerate(zip(masses, lengths, strict=True)):
        x, y, turn = (
            mp.diff(lambda t, k=k, i=i: places(t)[i][k], p["angle"]) for k in range(3)
        )
        moving = mass * (x**2 + y**2 + (length * turn) ** 2 / 12) / 2
        energy += moving * p["angular_velocity"] ** 2
        energy += mass * p["gravity"] * places(p["angle"])[i][1]
    return energy


def cranked(p):
    """The slider-crank: it turns over where its energy exceeds that of crank and rod at the top."""
    a, length = p["crank"], p["rod"]

    def places(t):
        rod = mp.asin(-a * mp.sin(t) / length)
        end = a * mp.cos(t) + length * mp.cos(rod)
        middle = a * mp.cos(t) + length / 2 * mp.cos(rod), a * mp.sin(t) / 2
        return (a / 2 * mp.cos(t), a / 2 * mp.sin(t), t), (*middle, rod), (end, 0, 0)

    masses = p["crank_mass"], p["rod_mass"], p["slider_mass"]
    energy = linked(places, masses, (a, length, 0), p)
    top = sum(mass * p["gravity"] * a / 2 for mass in masses[:2])
    return {"energy": energy, "turns over": energy > top}


def barred(p):
    """The four-bar linkage, and the least angle between coupler and rocker, at the nearest and the
    farthest end of the crank."""
    a, b, c, d = (p[n] for n in ("crank", "coupler", "rocker", "ground"))

    def places(t):
        crank, line = a * mp.expj(t), d - a * mp.expj(t)
        inner = mp.acos((b**2 + abs(line) ** 2 - c**2) / (2 * b * abs(line)))
        coupler = b * mp.expj(mp.arg(line) + inner)
        rocker = crank + coupler - d
        middles = crank / 2, crank + coupler / 2, d + rocker / 2
        return tuple(
            (mp.re(z), mp.im(z), mp.arg(v))
            for z, v in zip(middles, (crank, coupler, rocker), strict=True)
        )

    masses = p["crank_mass"], p["coupler_mass"], p["rocker_mass"]
    between = [mp.acos((b**2 + c**2 - far**2) / (2 * b * c)) for far in (d - a, d + a)]
    least = min(min(angle, mp.pi - angle) for angle in between)
    return {"energy": linked(places, masses, (a, b, c), p), "transmission_angle": least}


def tumbled(p):
    """A free body that turns over: half its period by Legendre's integral."""
    i = p["inertia_x"], p["inertia_y"], p["inertia_z"]
    w = p["angular_velocity"]
    energy = sum(a * b**2 for a, b in zip(i, w, strict=True))
    square = sum((a * b) ** 2 for a, b in zip(i, w, strict=True))
    low, mid, high = sorted(i)
    over = (high - mid) * (square - energy * low)
    under = (mid - low) * (energy * high - square)
    m = min(over / under, under / over)
    rate = mp.sqrt(max(over, under) / (low * mid * high))
    momentum = [a * b for a, b in zip(i, w, strict=True)]
    return {
        "half_period": 2 * mp.ellipk(m) / rate,
        "energy": energy / 2,
        "angular_momentum": momentum,
    }


def swings(p):
    """A pendulum released at rest."""
    natural = mp.sqrt(p["gravity"] / p["length"])
    lifted = p["gravity"] * p["length"]
    return {
        "natural_frequency": natural,
        "period": 4 * mp.ellipk(mp.sin(p["theta"] / 2) ** 2) / natural,
        "energy": -lifted * mp.cos(p["theta"]),
        "barrier": lifted,
    }


def driven(p):
    """A servo below its limit."""
    total = p["inertia"] + p["armature"]
    natural = p["gear"] * mp.sqrt(p["kp"] / total)
    damping = (p["gear"] ** 2 * p["kv"] + p["damping"]) / total
    return {"natural_frequency": natural, "damping_ratio": damping / (2 * natural)}


def thrown(p):
    """The top of a parabola."""
    return {"apex": (p["speed"] * mp.sin(p["elevation"])) ** 2 / (2 * p["gravity"])}


def piled(p):
    """Masses and weights of cubes, and where two of them tip."""
    count = int(p["count"])
    masses = [p["mass"] * p["mass_ratio"] ** (mp.mpf(i) / (count - 1)) for i in range(count)]
    weights = [p["gravity"] * sum(masses[i:]) for i in range(count)]
    return {"masses": masses, "normal_forces": weights}


FACTS = [
    ("bouncing-ball/half", {"height": 0.7}, bounced),
    ("incline/stops", {}, slope),
    ("incline/returns", {}, slope),
    ("rolling-ball/slide-to-roll", {"spin": -7.0}, rolled),
    ("rolling-ball/slide-to-roll", {"rolling_friction": 0.05}, slides),
    ("rolling-disc/circle", {"tilt": 1.1}, circled),
    ("rolling-disc/wobbling", {}, wobbled),
    ("pinch/pushed", {}, held),
    ("heavy-top/nutating", {}, spun),
    ("slider-crank/turning", {}, cranked),
    ("slider-crank/turning", {"angular_velocity": 4.0}, cranked),
    ("four-bar/crank-rocker", {}, barred),
    ("four-bar/crank-rocker", {"ground": 0.65}, barred),
    ("free-body/flip", {}, tumbled),
    ("free-body/about-largest", {}, tumbled),
    ("simple-pendulum/free-large", {"length": 1.3}, swings),
    ("servo/joint-damped", {}, driven),
    ("projectile/thrown", {}, thrown),
    ("stack/tall", {"mass_ratio": 3.0}, piled),
]


def exact(value):
    """A parameter in mpmath's digits."""
    return tuple(map(exact, value)) if isinstance(value, tuple | list) else mp.mpf(value)


@pytest.mark.parametrize(("name", "changes", "formula"), FACTS)
def test_facts(name, changes, formula):
    """To a few roundings of their parameters."""
    posed = scene(name, changes)
    found = system_of(posed).facts(case_of(posed).problem)
    with mp.workdps(30):
        wanted = formula({n: exact(v) for n, v in posed.parameters.items() if v is not None})
        for fact, value in wanted.items():
            if isinstance(value, bool):
                assert found[fact] == value
            elif found[fact] is None:
                assert math.isinf(value) or value <= 0, fact
            else:
                values = [float(v) for v in value] if isinstance(value, list) else float(value)
                assert found[fact] == pytest.approx(values, rel=4e-15), fact
