"""The stated uncertainty of exact derivatives is never exceeded, at random parameters: of systems
with a formula (of those without, test_sensitivities has recorded differences)."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.derivatives import scaled

SMOOTH = 1e-9  # of scale
# of a parameter, and of what a derivative is made of
STEP = mpmath.mpf(10) ** -13
ROUNDED = 1e-15
DIGITS = 40
# Of a difference of formulas with so many digits, relative to the largest value: at rest the slope
# is zero, and which of its last digits are not is the arithmetic's of mpmath or of gmpy2.
DIFFERENCED = float(mpmath.mpf(10) ** (1 - DIGITS) / STEP)


def ball(p, time):
    """A bouncing ball, from impact to impact."""
    begun = mpmath.mpf(0)
    speed = mpmath.mpf(0)
    height = p["height"]
    flight = mpmath.sqrt(2 * p["height"] / p["gravity"])
    rebound = p["restitution"] * p["gravity"] * flight
    while begun + flight <= time:
        begun = begun + flight
        speed = rebound
        height = mpmath.mpf(0)
        flight = 2 * speed / p["gravity"]
        rebound = p["restitution"] * speed
    since = time - begun
    return {"z": height + speed * since - p["gravity"] * since**2 / 2}


def rolling(p, time):
    """A ball that is thrown forward without spin, slides, and rolls."""
    u = p["radius"] * p["spin"]
    pull = p["friction"] * p["gravity"]
    rolls = 2 * (p["speed"] - u) / (7 * pull)
    sliding = min(time, rolls)
    x = p["speed"] * sliding - pull * sliding**2 / 2
    v = p["speed"] - pull * sliding
    spin = (u + 5 * pull * sliding / 2) / p["radius"]
    return {"x": x + v * (time - sliding), "speed": v, "spin": spin}


def thrown(p, time):
    """A parabola."""
    x, z = (p["speed"] * time * f(p["elevation"]) for f in (mpmath.cos, mpmath.sin))
    return {"x": x, "z": z - p["gravity"] * time**2 / 2, "angle": p["spin"] * time}


def sliding(p, time):
    """A cube on a slope, until it stops, and after that downhill if it slides."""
    pull, press = (p["gravity"] * f(p["slope"]) for f in (mpmath.sin, mpmath.cos))
    a = pull - mpmath.sign(p["speed"]) * p["friction"] * press
    moving = min(time, -p["speed"] / a)
    x = p["speed"] * moving + a * moving**2 / 2
    v = p["speed"] + a * moving
    back = max(pull - p["friction"] * press, 0)
    later = time - moving
    return {"x": x + back * later**2 / 2, "speed": v + back * later}


def servo(p, time):
    """A damped oscillator by its roots."""
    total = p["inertia"] + p["armature"]
    square = p["gear"] ** 2
    half = (square * p["kv"] + p["damping"]) / total / 2
    root = mpmath.sqrt(mpmath.mpc(half**2 - square * p["kp"] / total))
    slow = root - half
    fast = -root - half
    a = (p["theta_dot"] - fast * p["theta"]) / (slow - fast)
    parts = a * mpmath.exp(slow * time), (p["theta"] - a) * mpmath.exp(fast * time)
    rate = slow * parts[0] + fast * parts[1]
    return {"theta": sum(parts).real, "theta_dot": rate.real}


MOTOR = "inertia", "gear", "kp", "kv"
HELD = "mass", "size", "finger_mass", "friction", "normal_force", "gravity"
FORMULAS = {
    "bouncing-ball": (ball, ("height", "restitution", "gravity")),
    "rolling-ball": (rolling, ("radius", "speed", "spin", "friction", "gravity")),
    "projectile": (thrown, ("speed", "elevation", "spin", "gravity")),
    "incline/stops": (sliding, ("slope", "friction", "speed", "gravity", "mass", "size")),
    "incline/returns": (sliding, ("slope", "friction", "speed", "gravity", "heading")),
    "servo/motor-damped": (servo, (*MOTOR, "theta", "theta_dot", "force_limit")),
    "servo/lightly-damped": (servo, (*MOTOR, "armature", "damping", "theta")),
    "pinch/0.5": (lambda p, time: dict.fromkeys(("slip", "speed"), 0 * time), HELD),
    "stack": (lambda p, time: {"top": 0 * time}, ("size", "mass", "mass_ratio", "gravity")),
}


def drawn(name, seed):
    """A scene with its numbers moved by up to a tenth."""
    rng = np.random.default_rng(seed)
    posed = scene(name)

    def moved(value):
        if isinstance(value, tuple):
            return tuple(map(moved, value))
        return value * float(rng.uniform(0.9, 1.1)) if isinstance(value, float) else value

    changed = {n: v if n == "supports" else moved(v) for n, v in posed.parameters.items()}
    return case_of(replace(posed, parameters=changed))


def mp(value):
    return tuple(map(mp, value)) if isinstance(value, tuple) else mpmath.mpf(value)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", FORMULAS)
def test_differences_of_40_digits_are_within_the_uncertainty(name, seed):
    formula, by = FORMULAS[name]
    case = drawn(name, seed)
    times = case.scene.duration * np.array([0.11, 0.23, 0.37, 0.51, 0.73, 0.97])
    exact = {n: mp(v) for n, v in case.scene.parameters.items()}
    observed = case.reference.observe(times)
    with mpmath.workdps(DIGITS):
        for parameter, found in exact_gradient(case, by, times).items():
            sides = (exact | {parameter: exact[parameter] + s * STEP} for s in (1, -1))
            more, less = ([formula(p, mpmath.mpf(t)) for t in times] for p in sides)
            for observable in more[0]:
                pairs = zip(more, less, strict=True)
                slopes = [float((a[observable] - b[observable]) / (2 * STEP)) for a, b in pairs]
                wanted = np.array(slopes)
                off = np.abs(found.values[observable] - wanted)
                unsure = found.uncertainty[observable]
                rounded = DIFFERENCED * np.abs(observed[observable]).max()
                assert (off <= unsure + ROUNDED * np.abs(wanted) + rounded).all(), (
                    parameter,
                    off / unsure,
                )
                scale = scaled(wanted, observed[observable], float(exact[parameter]))
                # A time may lie beside a switch.
                assert np.median(unsure) <= SMOOTH * scale, (parameter, unsure)
