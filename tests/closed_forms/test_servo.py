"""The servo against 40 digits, its largest force and its limit, and where MuJoCo's step takes its
damping."""

from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from scipy.optimize import brentq

from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, method, methods
from plumbob.engines.study.measurement import scheme_of
from plumbob.models.registry import case_of, matching_scenes, scene

SCENES = matching_scenes("servo")
SAMPLES = 1000  # of what is left of a motion, each a tenth of its fastest time or less
STEPPING = [m for m in methods("mujoco/*,pymunk/*,ode/rk4") if meant(m, SCENES[0])]
LIGHT = case_of(scene("servo/lightly-damped")).problem


def flow_of(servo, side):
    """The matrix of the equation of x, x' and 1: with the motor below its limit, or at it on a
    side."""
    names = "inertia", "armature", "gear", "kp", "kv", "damping", "force_limit"
    inertia, armature, gear, kp, kv, damping, limit = (mp.mpf(getattr(servo, n)) for n in names)
    pull = [-(gear**2) * kp, -(gear**2) * kv - damping, 0]
    flow = mp.matrix([[0, 1, 0], [0, -damping, side * gear * limit] if side else pull, [0] * 3])
    flow[1, :] /= inertia + armature
    return flow


def held(servo, time):
    """Angle and its rate at a time [s] under a digital controller, with 40 digits: from each moment
    at which a sample is taken or a force begins to act to the next."""
    flow, hold = flow_of(servo, 0), mp.mpf(servo.hold)
    flow[1, :] = mp.matrix([[0, -mp.mpf(servo.damping), 1]])
    flow[1, :] /= mp.mpf(servo.inertia) + mp.mpf(servo.armature)
    taken = [k * hold for k in range(int(time / servo.hold) + 1)]
    acting = [(at + mp.mpf(servo.delay), k) for k, at in enumerate(taken)]
    state, now, forces = mp.matrix([servo.theta, servo.theta_dot, 0]), mp.mpf(0), {}
    for at in sorted({at for at, _ in acting} | set(taken) | {mp.mpf(time)}):
        if at > time:
            break
        state, now = mp.expm(flow * (at - now)) * state, at
        if at in taken:
            forces[taken.index(at)] = servo.gear * asked(servo, state)
        for begins, k in acting:
            if begins == at:
                state[2] = forces[k]
    return list(state)[:2]


def asked(servo, state):
    """The force before the gear without its limit [N m]."""
    return -servo.gear * (servo.kp * state[0] + servo.kv * state[1])


def exact(servo, time):
    """Angle and its rate at a time [s], with 40 digits: the motion is sampled in doubles for a
    moment at which the motor comes to its limit or leaves it, which is then found as a root."""
    if getattr(servo, "hold", 0.0):
        return held(servo, time)
    state = mp.matrix([servo.theta, servo.theta_dot, 1])
    limit = mp.mpf(servo.force_limit)
    force = asked(servo, state)
    side = int(mp.sign(force)) if abs(force) > limit else 0
    left = mp.mpf(time)
    while True:
        flow = flow_of(servo, side)
        signs = (side,) if side else (1, -1)

        def at(since, flow=flow, state=state):
            return mp.expm(flow * since) * state

        step = left / SAMPLES
        forward = np.array(mp.expm(flow * step).tolist(), dtype=float)
        sampled = np.array(state.tolist(), dtype=float)[:, 0]
        k, passed = 0, []
        while k < SAMPLES and not passed:
            sampled = forward @ sampled
            passed = [
                s
                for s in signs
                if (s * asked(servo, sampled) > servo.force_limit) != bool(side)
            ]
            k += 1
        if not passed:
            return list(at(left))[:2]

        def beyond(since, sign=passed[0], at=at):
            return sign * asked(servo, at(since)) - limit

        bracket = max(k - 1, 1e-3) * step, k * step
        near = brentq(lambda since: float(beyond(since)), *map(float, bracket), xtol=1e-9)
        ends = mp.findroot(beyond, (near, near + 1e-9))
        state = at(ends)
        left -= ends
        side = 0 if side else passed[0]


@pytest.mark.parametrize("chosen", SCENES, ids=lambda chosen: chosen.name)
def test_40_digits(chosen):
    case = case_of(chosen)
    times = np.array([0.1, 0.37, 1.0]) * chosen.duration
    observed, doubt = (f(times) for f in (case.reference.observe, case.reference.uncertainty))
    for k, time in enumerate(times):
        with mp.workdps(40):
            states = exact(case.problem, float(time))
            for name, value in zip(("theta", "theta_dot"), states, strict=True):
                assert abs(value - mp.mpf(float(observed[name][k]))) < doubt[name][k]
    largest = np.abs(
        case.reference.observe(np.linspace(0.0, chosen.duration, 99))["theta"]
    ).max()
    assert doubt["theta"].max() < 1e-12 * largest


STARTS = ((-0.5, 0.0), (0.0, 5.0), (-0.5, 5.0), (-0.1, -6.0), (0.05, -6.0))


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("kv", [0.0, 1e-3, 0.0788, 0.0791, 0.4], ids=lambda kv: f"kv={kv}")
def test_the_largest_force_is_that_of_the_first_peak(kv):
    times = np.linspace(0.0, 0.4, 4001)
    for start in STARTS:
        servo = replace(LIGHT, kv=kv, theta=start[0], theta_dot=start[1], force_limit=1e9)
        moved = servo.started.motion.observe(times)
        forces = servo.gear * np.abs(servo.kp * moved["theta"] + servo.kv * moved["theta_dot"])
        # sampled each 0.1 ms, a peak of 20 rad/s is missed by (h omega)^2/8 of it, 5e-7
        assert forces.max() * (1 - 1e-15) <= servo.peak_force <= forces.max() * (1 + 5e-6)


def test_the_limit_is_reached_where_the_motion_takes_more():
    assert LIGHT.peak_force == pytest.approx(4.0)
    assert not replace(LIGHT, force_limit=4.0001).saturates
    limited = replace(LIGHT, force_limit=3.9999)
    assert limited.saturates
    assert limited.peak_force == 3.9999


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("damping", [0.0, 5.6])
@pytest.mark.parametrize("kv", [0.0, 0.0788, 0.4])
def test_starts_and_dampings_with_40_digits(kv, damping):
    for start in STARTS[:3]:
        values = {"theta": start[0], "theta_dot": start[1], "force_limit": 0.5}
        servo = replace(LIGHT, kv=kv, damping=damping, **values)
        observed, doubt = (f(np.array([0.7])) for f in (servo.observe, servo.uncertainty))
        with mp.workdps(40):
            for name, value in zip(("theta", "theta_dot"), exact(servo, 0.7), strict=True):
                assert abs(value - mp.mpf(float(observed[name][0]))) < doubt[name][0]


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("how", STEPPING, ids=lambda how: how.name)
@pytest.mark.parametrize("case", ["saturated", "saturated-swings"])
def test_steps_at_the_limit_make_the_predicted_errors(case, how):
    """And a limit that is a millionth higher makes others."""
    posed = case_of(scene(f"servo/{case}"))
    higher = 1.000001 * posed.problem.force_limit
    right, wrong = (
        engine_of(how).prepare(of, how, 1e-3).run()
        for of in (posed, case_of(scene(f"servo/{case}", {"force_limit": higher})))
    )
    theory = posed.errors.at_step(scheme_of(posed, how), 1e-3, right.times).errors["theta"]
    expected = posed.reference.observe(right.times)["theta"] + theory
    off, further = (np.abs(run.observables["theta"] - expected).max() for run in (right, wrong))
    # 2000 steps round by 4e-17 each; a millionth of the limit moves the motion by 1e-7 and more
    assert off < 1e-13 < further


@pytest.mark.parametrize("part", [0.5, 0.49, 1.0, 0.0], ids=lambda part: f"part={part}")
def test_euler_takes_the_joints_part_of_the_damping_implicitly(part):
    case = case_of(scene("servo/lightly-damped"))
    euler = method("mujoco/euler")
    assert case.problem.joint_part == pytest.approx(0.5, rel=1e-15)
    run = engine_of(euler).prepare(case, euler, 1e-3).run()
    scheme = replace(euler.scheme, implicit_damping=part)
    predicted = case.errors.at_step(scheme, 1e-3, run.times).errors["theta"]
    off = run.observables["theta"] - case.reference.observe(run.times)["theta"] - predicted
    # 2000 steps round by 4e-17 each; a hundredth of the damping moves the motion by 1e-5
    assert (np.abs(off).max() < 1e-13) == (part == 0.5)
