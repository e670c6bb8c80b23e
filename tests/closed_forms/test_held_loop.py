"""A digital controller's loop: 40 digits at random parameters, closed forms of its limits, and runs
of engines at its predicted errors and limits."""

import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.held_steps import scheme_limit
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.analytic.stability import LOOP_QUANTITIES
from plumbob.analytic.systems.held_loop import HeldLoop
from plumbob.analytic.systems.servo import Servo
from plumbob.engines.method import Unsupported, meant
from plumbob.engines.registry import engine_of, installed, method, methods
from plumbob.engines.study.loop_limits import LoopSearch, loop_limits
from plumbob.engines.study.measurement import scheme_of
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.stability import judged_limits
from plumbob.tests.closed_forms.test_servo import held

OMEGA = 20.0
LATE = scene("servo/held-half-late")
STEPPING = [m for m in methods("*") if meant(m, LATE) and installed(engine_of(m))]
EULERS = Scheme(EULER, "start", implicit_damping=True)


def loop_of(ratio, hold=0.05, delay=0.0):
    """A loop without damping in the joint, of this damping ratio and 20 rad/s."""
    return HeldLoop(0.2, 0.0, 80.0, 0.4 * ratio * OMEGA, hold, delay, -0.5, 0.0)


@pytest.mark.parametrize("seed", range(6))
def test_40_digits_at_random_parameters(seed):
    """Holds from a tenth to one and a half of the swing's time, delays of up to three periods, some
    whole: also loops that grow."""
    draw = np.random.default_rng(seed)
    hold = float(10 ** draw.uniform(-2.3, -1.1))
    delay = hold * (draw.integers(0, 3) + (0.0 if seed % 2 else draw.uniform()))
    sizes = draw.uniform(0.02, 0.2, 2), draw.uniform(0.2, 1.0), draw.uniform(0.0, 0.08)
    damping, start = draw.uniform(0.0, 2.0), draw.uniform(-1.0, 1.0, 2)
    numbers = map(float, (*sizes[0], 10.0, *sizes[1:], damping, 1.0, *start, hold, delay))
    servo = Servo(*numbers)
    times = np.array([0.37 * hold, 3.0 * hold, 0.4])
    observed, doubt = (f(times) for f in (servo.loop.observe, servo.loop.uncertainty))
    for k, time in enumerate(times):
        with mp.workdps(40):
            states = held(servo, float(time))
        for name, value in zip(("theta", "theta_dot"), states, strict=True):
            assert abs(value - mp.mpf(float(observed[name][k]))) < doubt[name][k]
            # the certificate says something: eleven digits of the motion and more
            assert doubt[name][k] < 1e-11 * max(np.abs(observed[name]).max(), 1.0)


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.7])
def test_limits_have_the_closed_forms_of_the_double_integrator(ratio):
    """Jury's conditions on z^2 - t z + d give the limits. Exact motion: d < 1 gives h w < 4
    zeta, and z = -1 gives h w < 1/zeta. Semi-implicit Euler at a step a hold: z = -1 at h w =
    2 (sqrt(1 + zeta^2) - zeta). RK4 takes a constant torque exactly."""
    loop = loop_of(ratio)
    exact = min(4.0 * ratio, 1.0 / ratio) / OMEGA
    assert loop.limit("hold") == pytest.approx(exact, rel=1e-9)
    euler = 2.0 * (math.sqrt(1.0 + ratio**2) - ratio) / OMEGA
    assert scheme_limit(loop, EULERS, "hold", loop.hold) == pytest.approx(euler, rel=1e-9)
    assert scheme_limit(loop, Scheme(RK4), "hold", loop.hold) == pytest.approx(exact, rel=1e-9)


def test_eulers_limit_tends_to_the_continuous_one_with_its_order():
    """38 % lower at a step a hold, 1 % at a hundred; delays of a step and more are in steps."""
    loop = loop_of(0.5)
    short = [
        1.0 - scheme_limit(loop, EULERS, "hold", loop.hold / n) / loop.limit("hold")
        for n in (1, 50, 100, 200)
    ]
    assert short[0] == pytest.approx(0.382, abs=1e-3)
    assert short[2] == pytest.approx(0.01, abs=1e-3)
    orders = np.log2(np.divide(short[1:-1], short[2:]))
    # a second-order term of relative size 1/50 moves a slope by 0.03 at most
    assert orders == pytest.approx(1.0, abs=0.03)
    step = loop.hold / 400
    late = scheme_limit(loop, EULERS, "delay", step)
    # an Euler step is half a step late, and a delay is cut to a step
    assert loop.limit("delay") - 3.0 * step < late <= loop.limit("delay")


@pytest.mark.parametrize("quantity", LOOP_QUANTITIES)
def test_a_limit_parts_loops_that_decay_from_loops_that_grow(quantity):
    loop = loop_of(0.5, hold=0.012, delay=0.006)
    limit = loop.limit(quantity)
    sizes = []
    for value in (0.98 * limit, 1.02 * limit):
        changed = loop.changed(quantity, value)
        motion = np.abs(changed.observe(changed.hold * np.arange(400.0))["theta"])
        sizes.append(motion[300:].max() / motion[:100].max())
    assert sizes[0] < 0.5 < 2.0 < sizes[1]


@pytest.mark.parametrize("step", [1e-3, 7e-4], ids=["divides", "between"])
@pytest.mark.parametrize("how", STEPPING, ids=lambda how: how.name)
def test_engines_ask_the_controller_with_their_own_states(how, step):
    """A run has the errors of its scheme's own loop, at a step that divides hold and delay and at
    one that does not. The same run under a hold that is a millionth longer does not."""
    case = case_of(LATE)
    theory = case.errors.at_step(scheme_of(case, how), step, np.arange(501) * step).errors
    if not theory:
        pytest.skip("no theory covers the step")
    short = replace(case, scene=replace(LATE, duration=500 * step))
    run = engine_of(how).prepare(short, how, step).run()
    exact = case.reference.observe(run.times)["theta"]
    off = np.abs(run.observables["theta"] - exact - theory["theta"][: len(exact)]).max()
    # 500 steps round by 6e-17 each, and the loop keeps a tenth of what it is given each 36 ms
    assert off < 1e-13
    wrong = case_of(scene(LATE.name, {"kp": 0.8 * (1.0 + 1e-9)}))
    other = wrong.reference.observe(run.times)["theta"]
    assert np.abs(other - exact).max() > 1e-11


@pytest.mark.parametrize("name", ["ode/rk4", "heyoka/taylor"])
def test_methods_without_steps_of_a_mechanism_refuse_it(name):
    how = method(name)
    assert not meant(how, LATE)
    with pytest.raises(Unsupported, match="fed back"):
        engine_of(how).prepare(case_of(LATE), how, 1e-3)


LIMITED = (
    *("mujoco/euler", "mujoco/implicitfast", "mujoco/rk4"),
    *("pinocchio/aba+euler", "pybullet/undamped+iterated"),
)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", LIMITED)
def test_limits_by_runs_are_those_of_the_schemes_map(name):
    how = method(name)
    if not installed(engine_of(how)):
        pytest.skip("not installed")
    posed = scene("servo/held-half")
    step = posed.parameters["hold"] / 2
    measured = loop_limits(posed, how, step)
    assert [limit.kind for limit in measured.limits] == list(LOOP_QUANTITIES)
    for judged in judged_limits(LoopSearch(posed.name, name, step), measured):
        assert judged.verdict == "predicted", judged
    hold, _, gain = measured.limits
    # the ends of a bracket are 1 % apart
    assert hold.fails / hold.holds == pytest.approx(1.01, rel=1e-9)
    assert hold.holds <= hold.predicted <= hold.fails
    assert gain.holds <= gain.predicted <= gain.fails


def test_a_step_that_does_not_divide_the_hold_has_no_limits():
    measured = loop_limits(scene("servo/held-half"), method("mujoco/euler"), 7e-3)
    assert not measured.limits
    assert "does not divide" in measured.why


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"hold": -0.01}, "hold = -0.01: must be 0 or greater"),
        ({"hold": 0.0, "delay": 0.01}, "delay = 0.01: must be 0 without a hold"),
        ({"delay": 11.0}, "delay = 11.0: must be at most 200 times the hold"),
    ],
)
def test_bad_numbers(changes, message):
    with pytest.raises(ParameterError) as refused:
        scene("servo/held-half", changes)
    assert str(refused.value) == message
