"""The heavy top against integrals over its tilt with 40 digits, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp

from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene

TOP = case_of(scene("heavy-top/nutating")).problem


def passed(top, tilt):
    """Time [s] at which a top whose tilt grows passes one, and its precession then."""
    mass, length, across, axis, g, begin, around, over, spin = map(
        mp.mpf, vars(replace(top)).values()
    )
    across += mass * length**2
    along = axis * (spin + around * mp.cos(begin))
    vertical = across * around * mp.sin(begin) ** 2 + along * mp.cos(begin)

    def turning(t):
        return (vertical - along * mp.cos(t)) / (across * mp.sin(t) ** 2)

    def potential(t):
        return across * (turning(t) * mp.sin(t)) ** 2 / 2 + mass * g * length * mp.cos(t)

    def speed(t):
        return mp.sqrt(over**2 + 2 * (potential(begin) - potential(t)) / across)

    late = mp.quad(lambda t: 1 / speed(t), [begin, tilt])
    return late, mp.quad(lambda t: turning(t) / speed(t), [begin, tilt])


@pytest.mark.parametrize(
    "top",
    [TOP, replace(TOP, inertia_axis=3e-3, spin_rate=30.0, tilt_rate=2.0)],
    ids=["scene", "wide"],
)
def test_40_digits(top):
    time = 0.01  # before the tilt turns back
    exact, doubt = (f(np.array([time])) for f in (top.motion.observe, top.motion.uncertainty))
    assert exact["tilt_rate"][0] > 0.0
    with mp.workdps(40):
        late, precession = passed(top, mp.mpf(float(exact["tilt"][0])))
        error = float(late - mp.mpf(time))
        around = float(precession)
    assert abs(error) * exact["tilt_rate"][0] < doubt["tilt"][0] < 1e-14
    # at the time that the tilt's last digit is passed
    moved = error * exact["precession_rate"][0]
    assert abs(around - moved - exact["precession"][0]) < doubt["precession"][0] < 1e-14


@pytest.mark.parametrize("spin", [100.0, 285.0])
def test_rounded_axes_turn_a_top_in_mujoco_by_a_part_of_their_bound(spin):
    """A tenth to one: AXES is calibrated; the difference grows with the time, not its root."""
    case = case_of(scene("heavy-top", {"tilt": 0.65, "spin_rate": spin, "tilt_rate": 0.0}))
    how = method("mujoco/rk4")
    found, run = measure(case, how, 1e-3)
    stepped = case.errors.at_step(how.scheme, 1e-3, run.times).errors["precession"]
    exact = case.reference.observe(run.times)["precession"]
    moved = abs(run.observables["precession"] - exact - stepped)
    assert 0.1 < moved[-1] / found.errors["precession"].model["rounded axes"] < 1.0
    assert moved[-1] > 1.5 * moved[len(moved) // 2]
