"""The four-bar linkage against an energy integral with 40 digits; its soft loop in MuJoCo."""

from dataclasses import astuple, replace

import mujoco
import numpy as np
import pytest
from mpmath import mp

from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.models.registry import case_of, scene
from plumbob.tests.support import links

TURNING = case_of(scene("four-bar/crank-rocker"))
BARS = TURNING.problem
DRAG_LINK = replace(BARS, crank=0.5, coupler=0.4, ground=0.2, gravity=1.6)


def bodies(bars):
    """Crank angle -> place of each middle and angle of each link, by the law of cosines."""
    a, b, c, d = map(mp.mpf, astuple(bars)[:4])

    def places(t):
        crank = a * mp.expj(t)
        line = d - crank
        square = mp.re(line) ** 2 + mp.im(line) ** 2
        inner = mp.acos((b**2 + square - c**2) / (2 * b * mp.sqrt(square)))
        coupler = b * mp.expj(mp.arg(line) + inner)
        rocker = crank + coupler - d
        middles = crank / 2, crank + coupler / 2, d + rocker / 2
        turns = (mp.arg(link) for link in (crank, coupler, rocker))
        return tuple((mp.re(x), mp.im(x), turn) for x, turn in zip(middles, turns, strict=True))

    return places


def passed(bars, angle):
    """Time [s] at which a crank that turns forward passes an angle."""
    *lengths, _, first, second, third, g, begin, rate = map(mp.mpf, astuple(bars))
    masses = first, second, third
    return links.passed(bodies(bars), masses, lengths, g, (begin, angle), rate)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("bars", [BARS, DRAG_LINK], ids=["crank-rocker", "drag-link"])
def test_40_digits(bars):
    error, doubt = links.error_at(0.1, bars, passed)
    assert error < doubt < 2e-13


@pytest.mark.parametrize("bars", [BARS, DRAG_LINK], ids=["crank-rocker", "drag-link"])
def test_the_coupler_is_where_the_angle_puts_it(bars):
    times = np.linspace(0.0, 0.4, 5)
    observed, doubt = bars.motion.observe(times), bars.motion.uncertainty(times)
    with mp.workdps(40):
        for k, angle in enumerate(observed["angle"]):
            places = bodies(bars)(mp.mpf(angle))[1][:2]
            for name, place in zip(("coupler_x", "coupler_y"), places, strict=True):
                assert abs(place - mp.mpf(observed[name][k])) <= doubt[name][k] < 1e-12


def test_the_soft_loop_pulls_as_mujoco_s_does():
    for gap in (0.0, 1e-5):  # [rad] of the rocker
        joints, ours = links.loop_accelerations(TURNING, gap)
        # the solver's Hessian costs four digits: a condition of 1/(1 - d)
        np.testing.assert_allclose(np.cumsum(joints), ours, 1e-10, 1e-8)


def axis_force(bars):
    """Force [N] of its axis on the rocker at the start, by Newton's and Euler's equations of rocker
    and coupler."""
    at = mp.mpf(bars.angle)
    speed = mp.mpf(bars.angular_velocity)
    system = bars.motion.system
    gained = mp.mpf(
        system.acceleration(0.0, (bars.angle,), (bars.angular_velocity,), system.values)[0]
    )
    place = bodies(bars)

    def moving(link, part):
        slope, bend = (mp.diff(lambda t: place(t)[link][part], at, n) for n in (1, 2))
        return slope * gained + bend * speed**2

    crank = bars.crank * mp.expj(at)
    middle = {link: mp.mpc(*place(at)[link][:2]) for link in (1, 2)}
    pin = 2 * middle[2] - bars.ground  # coupler and rocker
    mass = {1: bars.coupler_mass, 2: bars.rocker_mass}
    push = {
        i: mass[i] * (mp.mpc(moving(i, 0), moving(i, 1)) + 1j * bars.gravity) for i in (1, 2)
    }

    def turned(i, length, about):
        arm = mp.im(mp.conj(middle[i] - about) * push[i])
        return mass[i] * mp.mpf(length) ** 2 / 12 * moving(i, 2) + arm

    of_rocker = turned(2, bars.rocker, pin)
    of_coupler = turned(1, bars.coupler, crank)
    # of the axis about the pin, of the pin about the crank
    arms = bars.ground - pin, pin - crank
    rows = mp.matrix([[-mp.im(arm), mp.re(arm)] for arm in arms])
    pulled = of_coupler + mp.im(mp.conj(arms[1]) * push[2])
    return mp.lu_solve(rows, mp.matrix([of_rocker, pulled]))


@pytest.mark.parametrize("angle", [1.0, 2.7, -1.3])
def test_the_axis_pulls_as_newton_and_euler_say_with_40_digits(angle):
    bars = replace(BARS, angle=angle)
    with mp.workdps(40):
        exact = [float(force) for force in axis_force(bars)]
    np.testing.assert_allclose(bars.reaction(np.zeros(1))[:, 0], exact, 1e-12)


@pytest.mark.parametrize(
    ("name", "step", "error"),
    [
        ("four-bar/crank-rocker", 1e-3, 4.6e-3),
        ("four-bar/crank-rocker", 1e-4, 1.8e-6),
        ("slider-crank/turning", 1e-4, 5.2e-7),
    ],
)
def test_mujoco_s_constraint_force_is_that_reaction(name, step, error):
    """At 0.5 s with RK4, within a third of what the README says."""
    case = case_of(scene(name))
    spec = filled(case.system.mjcf, case.system.model_file, case.problem)
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, round(0.5 / step))
    mujoco.mj_forward(model, data)
    exact = case.problem.reaction(np.array([0.5]))[:, 0]
    off = np.hypot(*(data.efc_force[[0, 2]] - exact)) / np.hypot(*exact)
    assert 0.7 * error < off < 1.3 * error
