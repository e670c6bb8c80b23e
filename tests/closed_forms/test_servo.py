"""The servo against 40 digits, its largest force, and where MuJoCo's step takes its damping."""

from dataclasses import astuple, replace

import mpmath as mp
import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import engine_of, method
from plumbob.models.registry import case_of, scene, scenes

SCENES = scenes("servo")
LIGHT = case_of(scene("servo/lightly-damped")).problem


def exact(servo, time):
    """Angle and its rate at a time [s], with 40 digits."""
    inertia, armature, gear, kp, kv, damping, _, *start = map(mp.mpf, astuple(servo))
    total = inertia + armature
    flow = mp.matrix([[0, 1], [-(gear**2) * kp / total, -(gear**2 * kv + damping) / total]])
    return list(mp.expm(flow * mp.mpf(time)) * mp.matrix(start))


@pytest.mark.parametrize("chosen", SCENES, ids=lambda chosen: chosen.name)
def test_40_digits(chosen):
    case, times = case_of(chosen), np.array([0.1, 0.37, 1.0]) * chosen.duration
    observed, doubt = (f(times) for f in (case.reference.observe, case.reference.uncertainty))
    for k, time in enumerate(times):
        with mp.workdps(40):
            states = exact(case.problem, float(time))
            for name, value in zip(("theta", "theta_dot"), states, strict=True):
                assert abs(value - mp.mpf(float(observed[name][k]))) < doubt[name][k]
    largest = np.abs(case.reference.observe(np.linspace(0.0, chosen.duration, 99))["theta"]).max()
    assert doubt["theta"].max() < 1e-12 * largest


STARTS = ((-0.5, 0.0), (0.0, 5.0), (-0.5, 5.0), (-0.1, -6.0), (0.05, -6.0))


@pytest.mark.parametrize("kv", [0.0, 1e-3, 0.0788, 0.0791, 0.4], ids=lambda kv: f"kv={kv}")
def test_the_largest_force_is_that_of_the_first_peak(kv):
    times = np.linspace(0.0, 0.4, 4001)
    for start in STARTS:
        servo = replace(LIGHT, kv=kv, theta=start[0], theta_dot=start[1], force_limit=1e9)
        moved = servo.started.motion.observe(times)
        forces = servo.gear * np.abs(servo.kp * moved["theta"] + servo.kv * moved["theta_dot"])
        # sampled each 0.1 ms, a peak of 20 rad/s is missed by (h omega)^2/8 of it, 5e-7
        assert forces.max() * (1 - 1e-15) <= servo.peak_force <= forces.max() * (1 + 5e-6)


def test_a_motion_beyond_the_limit_of_force_is_refused():
    assert LIGHT.peak_force == pytest.approx(4.0)
    replace(LIGHT, force_limit=4.0001)
    with pytest.raises(ParameterError, match=r"force_limit = 3\.9999: must be at least 4 N m"):
        replace(LIGHT, force_limit=3.9999)


@pytest.mark.parametrize("part", [0.5, 0.49, 1.0, 0.0], ids=lambda part: f"part={part}")
def test_euler_takes_the_joints_part_of_the_damping_implicitly(part):
    case, euler = case_of(scene("servo/lightly-damped")), method("mujoco/euler")
    assert case.problem.joint_part == pytest.approx(0.5, rel=1e-15)
    run = engine_of(euler).prepare(case, euler, 1e-3).run()
    scheme = replace(euler.scheme, implicit_damping=part)
    predicted = case.errors.at_step(scheme, 1e-3, run.times).errors["theta"]
    off = run.observables["theta"] - case.reference.observe(run.times)["theta"] - predicted
    # 2000 steps round by 4e-17 each; a hundredth of the damping moves the motion by 1e-5
    assert (np.abs(off).max() < 1e-13) == (part == 0.5)
