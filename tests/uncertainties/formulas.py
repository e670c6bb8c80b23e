"""Systems whose motion is made of parabolas, exponentials and rest, at random, far from the numbers
of their scenes: formulas of mpmath's numbers, written anew from the source of each system."""

from types import SimpleNamespace

import mpmath
import numpy as np

from plumbob.tests.closed_forms.test_servo import exact as saturating_states
from plumbob.tests.sensitivity.test_uncertainties import ball, servo

SUPPORTS = ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15))
TINY = (
    mpmath.mpf(10) ** -25
)  # of the speeds at the start: a difference that is zero but for 40 digits


def log(rng, low, high):
    """A number between two, of any size alike."""
    return float(10 ** rng.uniform(np.log10(low), np.log10(high)))


def either(rng, low, high):
    """The same, of either sign."""
    return float(rng.choice([-1, 1])) * log(rng, low, high)


def projectile(p, time):
    """A parabola and an even spin."""
    x, z = (p["speed"] * f(p["elevation"]) for f in (mpmath.cos, mpmath.sin))
    fall = p["gravity"] * time
    return {
        "x": x * time,
        "z": z * time - fall * time / 2,
        "angle": p["spin"] * time,
        "x_dot": x,
        "z_dot": z - fall,
        "angle_dot": p["spin"],
    }


def incline(p, time):
    """A cube that slides until it stops, and then rests or slides downhill."""
    pull, press = (p["gravity"] * f(p["slope"]) for f in (mpmath.sin, mpmath.cos))
    drag = p["friction"] * press
    a = pull - mpmath.sign(p["speed"]) * drag
    stops = -p["speed"] / a if p["speed"] * a < 0 else mpmath.mpf("inf")
    if not p["speed"]:
        stops = mpmath.mpf(0)
    moving = min(time, stops)
    later = time - moving
    again = max(pull - drag, mpmath.mpf(0))
    x = p["speed"] * moving + a * moving**2 / 2
    speed = p["speed"] + a * moving if time < stops else mpmath.mpf(0)
    return {"x": x + again * later**2 / 2, "speed": speed + again * later}


def rolling_ball(p, time):
    """A ball that slides, rolls and rests, from one zero of the slip or the spin to the next."""
    g, f, radius = p["gravity"], p["friction"], p["radius"]
    k = p["rolling_friction"] / radius
    v = p["speed"]
    u = radius * p["spin"]
    x = now = mpmath.mpf(0)
    least = TINY * (abs(v) + abs(u))
    while now < time:
        if abs(v - u) <= least:
            v = u = v if abs(v) > least else mpmath.mpf(0)
            a = b = -5 * k * g * mpmath.sign(v) / 7
        else:
            slides = mpmath.sign(v - u)
            a = -f * g * slides
            turns = mpmath.sign(u) if abs(u) > least else slides
            b = 5 * g * (f * slides - k * turns) / 2
            if abs(u) <= least and k >= f:
                b = u = mpmath.mpf(0)
        ends = [
            -y / r for y, r in ((v - u, a - b), (u, b), (v, a if v == u else 0)) if y * r < 0
        ]
        span = min([time - now, *(end for end in ends if end > 0)])
        x += span * (v + span * a / 2)
        v += span * a
        u += span * b
        now += span
    return {"x": x, "speed": v, "spin": u / radius}


def rod(p, time):
    """A rod that slides or sticks in an impact (Routh 1905, 187): the impulse along the floor is
    -f times that across, or holds the end."""
    m, t, e, g = p["mass"], p["angle"], p["restitution"], p["gravity"]
    sine, cosine = mpmath.sin(t), mpmath.cos(t)
    a, b, c = 1 + 3 * sine**2, -3 * sine * cosine, 1 + 3 * cosine**2
    fall = mpmath.sqrt(2 * p["height"] / g)
    v = -g * fall
    held = -b / a if abs(b) <= p["friction"] * a else -p["friction"] * mpmath.sign(b)
    first = -p["friction"] * mpmath.sign(p["speed"])
    slope = b + a * first
    ends = -p["speed"] * m / slope if p["speed"] * slope < 0 else mpmath.mpf("inf")
    # the impulse across the floor that takes the end's speed from v to -e v
    up = -(1 + e) * v * m / (c + b * first)
    if up > ends:
        up = ends + (-(1 + e) * v * m - (c + b * first) * ends) / (c + b * held)
    along = first * min(up, ends) + held * max(up - ends, 0)
    since = max(time - fall, mpmath.mpf(0)) / m
    return {
        "x": p["speed"] * time + along * since,
        "z": p["height"] + p["length"] * sine / 2 - g * time**2 / 2 + up * since,
        "angle": t + 6 * (along * sine - up * cosine) / p["length"] * since,
    }


def saturating(p, time):
    """A servo at its limit and below, by exponentials of matrices."""
    states = saturating_states(SimpleNamespace(**p), time)
    return dict(zip(("theta", "theta_dot"), states, strict=True))


def impact(p):
    """Impulses off and along the floor that the end of a rod gets: while the impulse off the floor
    grows, slip and speed change evenly, from one event to the next; Poisson's and Stronge's laws.
    """
    m, t, e = p["mass"], p["angle"], p["restitution"]
    sine, cosine = mpmath.sin(t), mpmath.cos(t)
    a, b, c = (x / m for x in (1 + 3 * sine**2, -3 * sine * cosine, 1 + 3 * cosine**2))
    slip, speed = p["speed"], -mpmath.sqrt(2 * p["gravity"] * p["height"])
    up = along = work = mpmath.mpf(0)
    ratio = -p["friction"] * mpmath.sign(slip)
    sticks = -b / a
    last = None  # the impulse at the end by Poisson's law, or the work then by Stronge's
    while True:
        eases, lifts = b + a * ratio, c + b * ratio
        ends = {}
        if slip * eases < 0:
            ends["slip"] = -slip / eases
        if speed < 0 < lifts:
            ends["compression"] = -speed / lifts
        elif last is not None and p["law"] == "poisson":
            ends["all"] = last - up
        elif last is not None:
            # half the difference of the squares of speed, over its rate, is the work
            ends["all"] = (mpmath.sqrt(speed**2 + 2 * lifts * (last - work)) - speed) / lifts
        event = min(ends, key=ends.get)
        grown = ends[event]
        work += grown * (speed + lifts * grown / 2)
        up += grown
        along += ratio * grown
        slip = slip + eases * grown if event != "slip" else mpmath.mpf(0)
        speed = speed + lifts * grown if event != "compression" else mpmath.mpf(0)
        if event == "all":
            return up, along
        if event == "slip":
            ratio = max(min(sticks, p["friction"]), -p["friction"])
        else:
            last = (1 + e) * up if p["law"] == "poisson" else (1 - e**2) * work


def rebounding_rod(p, time):
    """A rod that strikes by Poisson's or Stronge's law."""
    up, along = impact(p)
    g, length = p["gravity"], p["length"]
    sine, cosine = mpmath.sin(p["angle"]), mpmath.cos(p["angle"])
    since = max(time - mpmath.sqrt(2 * p["height"] / g), mpmath.mpf(0)) / p["mass"]
    return {
        "x": p["speed"] * time + along * since,
        "z": p["height"] + length * sine / 2 - g * time**2 / 2 + up * since,
        "angle": p["angle"] + 6 * (along * sine - up * cosine) / length * since,
    }


def loads(p, place):
    """Normal forces of three supports with the slider at `place`."""
    arms = p["supports"]
    pull = p["slider_mass"] * p["gravity"]
    total = (p["body_mass"] + p["slider_mass"]) * p["gravity"]
    matrix = mpmath.matrix([[1, 1, 1], [a[0] for a in arms], [a[1] for a in arms]])
    found = mpmath.lu_solve(matrix, mpmath.matrix([total, *(pull * part for part in place)]))
    return {f"normal_force_{i}": load for i, load in enumerate(found, start=1)}


def line(p, time):
    """A line manoeuvre, phase by phase (Chernousko 2020, eqs. 11-20)."""
    total = p["body_mass"] + p["slider_mass"]
    m = p["slider_mass"]
    mu = m / total
    limit = p["friction"] * p["gravity"]
    w1, w2, t1 = p["w1"], p["w2"], p["t1"]
    rest = t1 * mu * (w1 + w2) / (mu * w2 + limit)
    stop = t1 * (w1 + w2) / w2
    x = v = xi = rate = now = w = mpmath.mpf(0)
    slides = False
    for end, push, moves in ((t1, w1, True), (rest, -w2, True), (stop, -w2, False)):
        span = min(end, time) - now
        if span <= 0:
            break
        w, slides = push, moves
        a = limit - mu * w if slides else mpmath.mpf(0)
        x += v * span + a * span**2 / 2
        v = v + a * span if slides else mpmath.mpf(0)
        xi += rate * span + w * span**2 / 2
        rate += w * span
        now += span
    v = v if time < rest else mpmath.mpf(0)
    if time >= stop:
        w = rate = mpmath.mpf(0)
    friction = total * limit if slides and time < rest else m * w
    reach = p["start"] + xi
    along = mpmath.cos(p["direction"]), mpmath.sin(p["direction"])
    return {
        "displacement": x,
        "velocity": v,
        "stroke": xi,
        "stroke_rate": rate,
        "friction_force": friction,
        "driving_force": m * (w + (friction - m * w) / total),
        **loads(p, [reach * part for part in along]),
    }


def at_rest(p, xi, rate, w):
    """A body that friction holds while its slider moves."""
    along = mpmath.cos(p["direction"]), mpmath.sin(p["direction"])
    return {
        "displacement": mpmath.mpf(0),
        "velocity": mpmath.mpf(0),
        "stroke": xi,
        "stroke_rate": rate,
        "friction_force": p["slider_mass"] * w,
        "driving_force": p["slider_mass"] * w,
        **loads(p, [(p["start"] + xi) * part for part in along]),
    }


def slow(p, length, time):
    """Stroke, its rate and its acceleration, of a slow way from rest to rest."""
    total = p["body_mass"] + p["slider_mass"]
    most = p["fraction"] * p["friction"] * p["gravity"] * total / p["slider_mass"]
    w = mpmath.sign(length) * most
    half = mpmath.sqrt(abs(length) / most)
    if time < half:
        return w * time**2 / 2, w * time, w
    left = max(2 * half - time, mpmath.mpf(0))
    return length - w * left**2 / 2, w * left, -w if left else mpmath.mpf(0)


def stroke(p, time):
    """A slow way out, and back."""
    total = p["body_mass"] + p["slider_mass"]
    most = p["fraction"] * p["friction"] * p["gravity"] * total / p["slider_mass"]
    turn = 2 * mpmath.sqrt(abs(p["length"]) / most)
    if time < turn:
        return at_rest(p, *slow(p, p["length"], time))
    xi, rate, w = slow(p, -p["length"], time - turn)
    return at_rest(p, p["length"] + xi, rate, w)


def repeated_lines(p, time):
    """Line manoeuvres, each with a slow return and a pause (Chernousko 2020, eqs. 17-22)."""
    total = p["body_mass"] + p["slider_mass"]
    mu = p["slider_mass"] / total
    limit = p["friction"] * p["gravity"]
    w1, w2, t1 = p["w1"], p["w2"], p["t1"]
    stop = (w1 + w2) * t1 / w2
    way = w1 * (w1 + w2) * t1**2 / (2 * w2)
    moved = -mu * (w1 + w2) * (mu * w1 - limit) * t1**2 / (2 * (mu * w2 + limit))
    back = 2 * mpmath.sqrt(way * mu / (p["fraction"] * limit))
    period = stop + back + p["pause"]
    done = min(mpmath.floor(time / period), p["count"] - 1)
    since = time - done * period
    if since < stop:
        now = line(p, since)
    else:
        xi, rate, w = slow(p, -way, since - stop)
        now = at_rest(p, way + xi, rate, w)
        now["displacement"] = moved
    now["displacement"] += done * moved
    return now


def coast(p, time):
    """Coasting without spin: an even deceleration along a line."""
    speed = mpmath.hypot(p["velocity_x"], p["velocity_y"])
    pull = p["friction"] * p["gravity"]
    moving = min(time, speed / pull)
    way = (speed - pull * moving / 2) * moving / speed
    left = (speed - pull * moving) / speed
    return {
        "x": way * p["velocity_x"],
        "y": way * p["velocity_y"],
        "velocity_x": left * p["velocity_x"],
        "velocity_y": left * p["velocity_y"],
        **loads(p, p["slider"]),
    }


def held(p, time):
    """Rest under gravity that is tilted to tan(alpha) = fraction f."""
    tilt = mpmath.atan(p["fraction"] * p["friction"])
    return loads({**p, "gravity": p["gravity"] * mpmath.cos(tilt)}, p["slider"])


# Random parameters, and a time by which most has happened.


def draw_ball(rng):
    """From dead to lively balls."""
    p = {"height": log(rng, 1e-3, 1e3), "restitution": float(rng.uniform(0.05, 0.98))}
    p["gravity"] = log(rng, 0.1, 100)
    fall = np.sqrt(2 * p["height"] / p["gravity"])
    return p, fall * (1 + p["restitution"]) / (1 - p["restitution"])


def draw_projectile(rng):
    """Thrown up or down, fast or slow."""
    p = {
        "speed": log(rng, 1e-2, 1e4),
        "elevation": float(rng.uniform(-1.5, 1.5)),
        "spin": either(rng, 1e-2, 1e3),
        "gravity": log(rng, 0.1, 100),
    }
    return p, log(rng, 1e-2, 1e3)


def draw_incline(rng):
    """Pushed up or down, on slopes that hold it or not."""
    p = {
        "slope": float(rng.uniform(0.01, 1.4)),
        "friction": float(rng.uniform(0.01, 0.99)),
        "mass": log(rng, 1e-2, 1e2),
        "size": log(rng, 1e-2, 1),
        "speed": either(rng, 1e-2, 1e2),
        "gravity": log(rng, 0.1, 100),
    }
    return p, 4 * abs(p["speed"]) / p["gravity"] / p["friction"]


def draw_rolling(rng):
    """With and without spin and rolling friction."""
    radius = log(rng, 1e-2, 1)
    friction = log(rng, 1e-2, 1)
    p = {
        "radius": radius,
        "mass": log(rng, 1e-2, 1e2),
        "speed": either(rng, 1e-2, 1e2),
        "spin": float(rng.integers(0, 2)) * either(rng, 1e-1, 1e2) / radius,
        "friction": friction,
        "gravity": log(rng, 0.1, 100),
        "torsional_friction": 0.0,
        "rolling_friction": float(rng.integers(0, 2)) * friction * radius * log(rng, 0.01, 1),
    }
    scale = abs(p["speed"]) + radius * abs(p["spin"])
    return p, 2 * scale / friction / p["gravity"]


def draw_servo(rng):
    """Underdamped and overdamped, from rest and from a blow; the motor has no limit."""
    p = {
        "inertia": log(rng, 1e-3, 10),
        "armature": float(rng.integers(0, 2)) * log(rng, 1e-3, 10),
        "gear": log(rng, 0.1, 100),
        "kp": log(rng, 1e-2, 1e3),
        "kv": float(rng.integers(0, 2)) * log(rng, 1e-4, 1),
        "damping": float(rng.integers(0, 2)) * log(rng, 1e-4, 1),
        "force_limit": 1e12,
        "theta": either(rng, 1e-2, 3),
        "theta_dot": float(rng.integers(0, 2)) * either(rng, 1e-1, 1e2),
    }
    total = p["inertia"] + p["armature"]
    rate = p["gear"] * np.sqrt(p["kp"] / total)
    return p, 20 / rate


def draw_saturating(rng):
    """Servos whose motor reaches its limit, most of them, and is at it long or shortly."""
    p, _ = draw_servo(rng)
    most = p["gear"] * (p["kp"] * abs(p["theta"]) + p["kv"] * abs(p["theta_dot"]))
    part = log(rng, 0.1, 1)
    p["force_limit"] = most * part
    rate = p["gear"] * np.sqrt(p["kp"] / (p["inertia"] + p["armature"]))
    return p, 10 / rate / part


def draw_rebounding_rod(rng):
    """By Poisson's and Stronge's laws; where friction is large some jam."""
    p, last = draw_rod(rng)
    p["friction"] = log(rng, 0.01, 3)
    p["law"] = str(rng.choice(["poisson", "energetic"]))
    return p, last


def draw_rod(rng):
    """By Newton's law, sliding, sticking and reversing, to either side."""
    p = {
        "length": log(rng, 0.1, 10),
        "mass": log(rng, 0.1, 10),
        "angle": float(rng.uniform(0.1, 3.0)),
        "height": log(rng, 1e-2, 10),
        "speed": either(rng, 1e-2, 10),
        "friction": float(rng.uniform(0, 0.7)),
        "restitution": float(rng.uniform(0.05, 1)),
        "law": "newton",
        "gravity": log(rng, 0.5, 30),
    }
    return p, 2 * np.sqrt(2 * p["height"] / p["gravity"])


def body(rng):
    return {
        "body_mass": log(rng, 0.1, 100),
        "slider_mass": log(rng, 0.01, 10),
        "inertia": log(rng, 1e-3, 1),
        "supports": tuple(
            tuple(float(x * rng.uniform(0.5, 2)) for x in arm) for arm in SUPPORTS
        ),
        "friction": log(rng, 0.02, 1),
        "gravity": log(rng, 0.5, 30),
    }


def place(rng):
    return tuple(rng.uniform(-0.03, 0.03, 2).tolist())


def draw_line(rng):
    """Strokes up to ten centimetres, in any direction."""
    p = body(rng)
    limit = p["friction"] * p["gravity"] * (1 + p["body_mass"] / p["slider_mass"])
    w1 = limit * (1 + log(rng, 0.05, 20))
    w2 = limit * float(rng.uniform(0.1, 1))
    stroke = log(rng, 1e-3, 0.05)
    t1 = float(np.sqrt(2 * w2 * stroke / (w1 * (w1 + w2))))
    direction = float(rng.uniform(-3, 3))
    p |= {"w1": w1, "w2": w2, "t1": t1, "start": 0.0, "direction": direction}
    return p, 1.3 * t1 * (w1 + w2) / w2


def draw_repeated_lines(rng):
    """Two to forty manoeuvres, at rest in between or not."""
    p, last = draw_line(rng)
    p["count"] = int(rng.integers(2, 40))
    p["fraction"] = float(rng.uniform(0.1, 1))
    p["pause"] = float(rng.integers(0, 2)) * log(rng, 1e-3, 1) * last
    return p, p["count"] * last * (1 + 1 / p["fraction"])


def draw_stroke(rng):
    """Forward and backward, from the middle of the body or beside it."""
    p = body(rng)
    p |= {
        "direction": float(rng.uniform(-3, 3)),
        "length": either(rng, 1e-3, 0.05),
        "start": float(rng.uniform(-0.02, 0.02)),
        "fraction": float(rng.uniform(0.01, 0.999)),
    }
    most = (
        p["fraction"] * p["friction"] * p["gravity"] * (1 + p["body_mass"] / p["slider_mass"])
    )
    return p, 4.4 * np.sqrt(abs(p["length"]) / most)


def draw_coast(rng):
    """Slow and fast, without spin."""
    p = body(rng)
    speeds = {"velocity_x": either(rng, 1e-2, 10), "velocity_y": either(rng, 1e-2, 10)}
    p |= {"slider": place(rng), **speeds, "heading_rate": 0.0}
    return p, 1.3 * np.hypot(*speeds.values()) / p["friction"] / p["gravity"]


def draw_held(rng):
    """From hardly tilted to almost sliding."""
    p = body(rng)
    fraction = float(rng.uniform(0.01, 0.999))
    return p | {
        "direction": float(rng.uniform(-3, 3)),
        "slider": place(rng),
        "fraction": fraction,
    }, 10.0


FORMULAS = {
    "bouncing-ball": (draw_ball, ball),
    "capsule-coast": (draw_coast, coast),
    "capsule-hold": (draw_held, held),
    "capsule-hold/stroke": (draw_stroke, stroke),
    "capsule-line": (draw_line, line),
    "capsule-train": (draw_repeated_lines, repeated_lines),
    "incline": (draw_incline, incline),
    "projectile": (draw_projectile, projectile),
    "rod-impact": (draw_rod, rod),
    "rod-impact/rebounds": (draw_rebounding_rod, rebounding_rod),
    "rolling-ball": (draw_rolling, rolling_ball),
    "servo": (draw_servo, servo),
    "servo/saturated": (draw_saturating, saturating),
}
