"""Scenes of the capsule on a line, repeated and held, from event to event with 40 digits."""

import numpy as np
import pytest
from mpmath import mp

from plumbob.models.registry import case_of, scene

SCENES = (
    *("capsule-line/ca1", "capsule-line/at-123", "capsule-line/frictionless"),
    *("capsule-train/ten", "capsule-hold/0.999", "capsule-hold/slow-motion"),
    "capsule-hold/unloading",
)


def course(p):
    """The slider's accelerations along its line, each with its duration, from a scene's numbers."""
    holding = p["friction"] * p["gravity"] * (p["body_mass"] / p["slider_mass"] + 1)
    if "slider" in p:  # which is fixed
        return [(mp.mpf(0), mp.inf)]
    if "length" in p:
        w = p["fraction"] * holding
        half = mp.sqrt(p["length"] / w)
        return [(w, half), (-w, 2 * half), (w, half), (mp.mpf(0), mp.inf)]
    w1, w2, t1 = p["w1"], p["w2"], p["t1"]
    there = [(w1, t1), (-w2, w1 * t1 / w2)]
    if "count" not in p:
        return [*there, (mp.mpf(0), mp.inf)]
    w = p["fraction"] * holding
    half = mp.sqrt(w1 * (w1 + w2) * t1**2 / (2 * w2) / w)
    once = [*there, (-w, half), (w, half), (mp.mpf(0), p["pause"])]
    return [*(int(p["count"]) * once), (mp.mpf(0), mp.inf)]


def slid(p, time):
    """Way and rate of body and slider, acceleration of the body and of the slider in it, at a time:
    eqs. 11-16, where friction holds what it can."""
    mu = p["slider_mass"] / (p["body_mass"] + p["slider_mass"])
    most = p["friction"] * p["gravity"]
    x = v = xi = rate = mp.mpf(0)
    left = mp.mpf(time)
    for w, lasts in course(p):
        within = min(left, lasts)
        ends = lasts > left
        left -= within
        while True:
            pushed = -mu * w
            slips = mp.sign(v or (pushed if abs(pushed) > most else 0))
            a = pushed - most * slips if slips else mp.mpf(0)
            part = min(within, -v / a) if v * a < 0 else within
            x, v = x + part * (v + part * a / 2), v + part * a
            xi, rate = xi + part * (rate + part * w / 2), rate + part * w
            v = mp.mpf(0) if part < within else v
            within -= part
            if not within:
                break
        if ends:
            return x, v, xi, rate, a, w
    raise AssertionError("a course lasts for ever")


def supported(p, along, place, tilt):
    """N_i by the balance of forces and moments; gravity is tilted along the line."""
    press = p["gravity"] * mp.cos(tilt)
    weight = p["slider_mass"] * press
    total = weight + p["body_mass"] * press
    rows = mp.matrix([[1, 1, 1], *zip(*p["supports"], strict=True)])
    unit = mp.cos(along), mp.sin(along)
    at = [a + place * u for a, u in zip(p.get("slider", (0, 0)), unit, strict=True)]
    return mp.lu_solve(rows, mp.matrix([total, *(weight * part for part in at)]))


def observed(p, time):
    """All observables at a time [s]."""
    mass = p["body_mass"] + p["slider_mass"]
    x, v, xi, rate, a, w = slid(p, time)
    corner = p["supports"][0]
    along = p.get("direction", mp.atan2(corner[1], corner[0]))
    tilt = mp.atan(p["fraction"] * p["friction"]) if "slider" in p else mp.mpf(0)
    down = p["gravity"] * mp.sin(tilt)
    loads = supported(p, along, xi, tilt)
    return {
        "displacement": x,
        "velocity": v,
        "stroke": xi,
        "stroke_rate": rate,
        "heading": 0,
        "sideways": 0,
        **{f"normal_force_{i + 1}": loads[i] for i in range(3)},
        "friction_force": mass * (a - down) + p["slider_mass"] * w,
        "driving_force": p["slider_mass"] * (a + w - down),
    }


def exact(value):
    """A parameter in mpmath's digits."""
    return tuple(map(exact, value)) if isinstance(value, tuple) else mp.mpf(value)


@pytest.mark.parametrize("name", SCENES)
def test_40_digits(name):
    posed = scene(name)
    reference = case_of(posed).reference
    times = posed.duration * np.array([0.01, 0.113, 0.29, 0.47, 0.713, 0.97])
    found, doubt = reference.observe(times), reference.uncertainty(times)
    with mp.workdps(40):
        parameters = {n: exact(v) for n, v in posed.parameters.items()}
        for k, time in enumerate(times):
            wanted = observed(parameters, time)
            assert wanted.keys() == found.keys()
            for n, value in wanted.items():
                assert abs(value - mp.mpf(found[n][k])) <= doubt[n][k], (n, time)
