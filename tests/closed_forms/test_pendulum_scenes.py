"""Scenes of the simple and the linear pendulum by Taylor series of their equation, 40 digits."""

import numpy as np
import pytest
from mpmath import mp

from plumbob.models.registry import case_of, scene

TERMS = 32  # of a step that is a quarter of the fastest time: the next one is below 1e-19
STEP = mp.mpf(1) / 4

# A time [s] and the changes of a scene; the first digits of a chaotic motion last for some seconds.
SCENES = {
    "simple-pendulum/free-large": (1.7, {}),
    "simple-pendulum/damped-rotating": (1.7, {"mass": 0.7, "length": 1.3}),
    "simple-pendulum/forced-large": (1.7, {}),
    "simple-pendulum/near-top-1e-6": (3.0, {}),
    "simple-pendulum/forced-chaotic": (3.0, {}),
    "linear-pendulum/forced-large": (1.7, {"length": 0.8}),
    "linear-pendulum/damped-rotating": (1.7, {}),
    "linear-pendulum/overdamped": (0.3, {}),
}


def series(p, time, theta, rate, linear):
    """Taylor coefficients of an angle at a time [s], of theta'' = A sin(W t) - xi theta' - (g/L)
    sin theta, or of theta for the sine."""
    pull = p["gravity"] / p["length"]
    force, often = p["forcing_amplitude"], p["forcing_frequency"]
    angle, sine, cosine = [theta, rate], [mp.sin(theta)], [mp.cos(theta)]
    for k in range(TERMS):
        back = angle[k] if linear else sine[k]
        push = force * often**k * mp.sin(often * time + k * mp.pi / 2) / mp.factorial(k)
        gained = push - p["damping_rate"] * (k + 1) * angle[k + 1] - pull * back
        angle.append(gained / ((k + 1) * (k + 2)))
        slopes = [(j + 1) * angle[j + 1] for j in range(k + 1)]
        sine.append(sum(cosine[k - j] * s for j, s in enumerate(slopes)) / (k + 1))
        cosine.append(-sum(sine[k - j] * s for j, s in enumerate(slopes)) / (k + 1))
    return angle


def swung(p, time, linear):
    """Angle, rate and tension of the rod, m (L theta'^2 + g cos theta), at a time [s]."""
    top = p.get("theta_from_top")
    theta = p["theta"] if top is None else mp.pi + top
    rate, now = p["theta_dot"], mp.mpf(0)
    fast = mp.sqrt(p["gravity"] / p["length"]) + p["damping_rate"] + abs(p["forcing_frequency"])
    while now < time:
        part = min(STEP / (fast + abs(rate)), time - now)
        angle = series(p, now, theta, rate, linear)
        theta = sum(a * part**k for k, a in enumerate(angle))
        rate = sum(k * a * part ** (k - 1) for k, a in enumerate(angle) if k)
        now += part
    pulled = p["length"] * rate**2 + p["gravity"] * mp.cos(theta)
    return {"theta": theta, "theta_dot": rate, "tension": p.get("mass", 1) * pulled}


@pytest.mark.parametrize("name", SCENES)
def test_40_digits(name):
    end, changes = SCENES[name]
    posed = scene(name, changes)
    reference = case_of(posed).reference
    times = np.array([end])
    found, doubt = reference.observe(times), reference.uncertainty(times)
    with mp.workdps(40):
        numbers = {n: mp.mpf(v) for n, v in posed.parameters.items() if v is not None}
        for k, time in enumerate(times):
            state = swung(numbers, mp.mpf(time), name.startswith("linear"))
            for n in found:
                assert abs(state[n] - mp.mpf(found[n][k])) <= doubt[n][k], n
