"""Laws that derivatives obey: units of mass, length and time, and mirror symmetry."""

from __future__ import annotations

import numpy as np
import pytest

from plumbob.analytic.reference import Array
from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene

ACCURATE = 1e-7  # of the sum of all terms of a law
# Of observables and parameters: powers of a unit of mass, length and time.
UNITS = {
    "m": (0, 1, 0),
    "m/s": (0, 1, -1),
    "rad": (0, 0, 0),
    "rad/s": (0, 0, -1),
    "N": (1, 1, -2),
    "1": (0, 0, 0),
}
SIZES = {
    "body_mass": (1, 0, 0),
    "slider_mass": (1, 0, 0),
    "mass": (1, 0, 0),
    "inertia": (1, 2, 0),
    "inertia_x": (1, 2, 0),
    "inertia_y": (1, 2, 0),
    "inertia_z": (1, 2, 0),
    "density": (1, -3, 0),
    "gravity": (0, 1, -2),
    "w1": (0, 1, -2),
    "w2": (0, 1, -2),
    "t1": (0, 0, 1),
    "pause": (0, 0, 1),
    "half_time": (0, 0, 1),
    "angular_acceleration": (0, 0, -2),
    "radius": (0, 1, 0),
    "supports": (0, 1, 0),
    "slider": (0, 1, 0),
    "length": (0, 1, 0),
    "height": (0, 1, 0),
    "pivot_x": (0, 1, 0),
    "pivot_y": (0, 1, 0),
    "velocity_x": (0, 1, -1),
    "velocity_y": (0, 1, -1),
    "theta_dot": (0, 0, -1),
    "platform_rate": (0, 0, -1),
    "heading_rate": (0, 0, -1),
    "angular_velocity": (0, 0, -1),
    "damping_rate": (0, 0, -1),
    "forcing_frequency": (0, 0, -1),
    "forcing_amplitude": (0, 0, -2),
}
METAMORPHIC = tuple(
    (name, axis)
    for axis in range(3)
    for name in (
        "cone-pendulum/rotating-base",
        "simple-pendulum/rotating-slow",
        "linear-pendulum/free-large",
        "free-body/flip",
        "capsule-line/at-50",
        "capsule-train/ten",
        "capsule-hold/slow-motion",
        "capsule-coast/spin",
        "capsule-turn/0.3",
    )
    # Of the free body lengths are in the moments of inertia only.
    if (name, axis) != ("free-body/flip", 1)
)


@pytest.mark.long(keep=7)
@pytest.mark.parametrize(("name", "axis"), METAMORPHIC)
def test_derivatives_obey_units(name, axis):
    """A motion is the same in another unit of mass, length or time: the parameters' derivatives
    and the velocity add up to the observable itself (Euler's theorem)."""
    heavier = {"mass": 1.3} if "pendulum/" in name and "cone" not in name else None
    case = case_of(scene(name, heavier))
    parameters = case.scene.parameters
    by = [n for n in SIZES if parameters.get(n) and SIZES[n][axis]]
    times = np.array([0.31, 0.83]) * case.scene.duration
    edge = 1e-5 * case.scene.duration
    found = exact_gradient(case, by, times)
    observed = case.reference.observe(times)
    around = [case.reference.observe(times + k * edge) for k in (-2, -1, 1, 2)]
    for observable in case.system.observables:
        terms = list[Array]()
        for key, one in found.items():
            value = parameters[key.partition("[")[0]]
            for index in key.replace("]", "").split("[")[1:]:
                value = value[int(index)]
            power = SIZES[key.partition("[")[0]][axis]
            terms.append(power * value * one.values[observable.name])
        if axis == 2:
            a, b, c, d = (part[observable.name] for part in around)
            terms.append(times * (a - 8 * b + 8 * c - d) / (12 * edge))
        wanted = UNITS[observable.unit][axis] * observed[observable.name]
        off = np.abs(sum(terms) - wanted)
        size = sum(float(np.abs(term).max()) for term in (*terms, wanted))
        assert off.max() <= ACCURATE * (size + 1e-3), (observable.name, off, size)


@pytest.mark.long
def test_mirrored_capsules_have_mirrored_derivatives():
    """A body, its slider and its start reflected across x: derivatives by y-like parameters of
    y-like observables agree, mixed ones change their sign."""
    case = case_of(scene("capsule-coast/spin", {"slider": (0.05, 0.03)}))
    given = dict(case.scene.parameters)
    (a, b, c), (x, y) = given["supports"], given["slider"]
    mirrored = {
        "supports": tuple((px, -py) for px, py in (a, b, c)),
        "slider": (x, -y),
        "velocity_y": -given["velocity_y"],
        "heading_rate": -given["heading_rate"],
    }
    other = case_of(scene("capsule-coast/spin", {**given, **mirrored}))
    odd = ("y", "velocity_y", "heading", "heading_rate", "slider[1]")
    by, times = ["friction", "velocity_x", "velocity_y", "heading_rate", "slider"], np.array([0.35])
    one, two = (exact_gradient(each, by, times) for each in (case, other))
    for parameter, found in one.items():
        for observable, values in found.values.items():
            sign = -1.0 if (parameter in odd) != (observable in odd) else 1.0
            same = two[parameter].values[observable]
            assert values == pytest.approx(sign * same, rel=1e-9, abs=1e-11)
