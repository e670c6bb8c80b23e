"""MuJoCo's cone pendulum against the exact motion and another solver: error, order, armature."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbob.analytic.errors.contact_models.added_inertia import platform_error
from plumbob.analytic.errors.smooth_motion.pendulum_errors import PendulumErrors
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import cone
from plumbob.engines.adapters.mujoco import ENGINE, model_error, prepare
from plumbob.engines.adapters.mujoco.cone_pendulum import armature as model_armature
from plumbob.engines.adapters.mujoco.cone_pendulum import whole
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.trimming import trimming
from plumbob.engines.method import Method
from plumbob.engines.trajectory import Trajectory
from plumbob.tests.support.cone_scene import DEFAULT, MJCF, SYSTEM, THETA, THETA_DOT, scene

# nothing is controlled here: the methods that differ in a control are left out
METHODS = {
    m.name: m for m in ENGINE.methods if not {"control_at", "contact", "model"} & m.settings.keys()
}
RK4, EULER = METHODS["mujoco/rk4"], METHODS["mujoco/euler"]
END = np.array([0.5])


def run(
    method: Method = RK4, step: float = 1e-4, duration: float = 0.5, **given: Any
) -> Trajectory:
    """Run the default scene, with some of its fields changed."""
    return prepare(SYSTEM.case(scene(duration, **given)), method, step).run()


def error(method: Method, step: float, **given: Any) -> float:
    """Error of theta [rad] at 0.5 s relative to the default scene, for any scene that was run."""
    trajectory = run(method, step, **given)
    assert trajectory.times[-1] == pytest.approx(0.5, abs=1e-12)
    return float(trajectory.observables["theta"][-1]) - THETA


def predicted(method: Method, step: float) -> float:
    """What the first two terms of the scheme's error series say."""
    terms = PendulumErrors(DEFAULT.motion).series(method.scheme, END)
    return sum(float(values["theta"][0]) * step**power for power, values in terms.items())


def slope(steps: Array, errors: Array) -> float:
    """Observed order: the slope of log error against log step."""
    return float(np.polyfit(np.log(steps), np.log(np.abs(errors)), 1)[0])


def test_rk4_reaches_the_exact_motion() -> None:
    # 20 000 steps: C4 h^4 + C5 h^5 is 2e-15 and round-off 2e-13, both at theta = 20; 1e-10 would
    # do. The rate must not drift by as much either; it does not change.
    trajectory = run(step=2.5e-5)
    exact = DEFAULT.motion.observe(trajectory.times)
    assert np.abs(trajectory.observables["theta"] - exact["theta"]).max() < 2e-12
    assert np.abs(trajectory.observables["theta_dot"] - exact["theta_dot"]).max() < 2e-11
    assert trajectory.observables["theta"][-1] == pytest.approx(THETA, abs=2e-12)
    assert trajectory.observables["theta_dot"][-1] == pytest.approx(THETA_DOT, abs=2e-11)
    assert np.ptp(trajectory.channels["platform_rate"]) == 0.0
    assert trajectory.channels["platform_rate"][0] == 26.0


WIDE = cone(8000.0, 0.1, 2.6)
SKEW = replace(DEFAULT.body, inertia_y=DEFAULT.body.inertia_y + 0.03)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(
    ("given", "duration", "tolerance"),
    [
        ({}, 0.5, 1e-11),  # DOP853's 1e-13 a step, accumulated over about 150 steps
        ({"platform_rate": 0.0, "theta_dot": 13.0}, 1.0, 1e-11),
        ({"pivot_x": 0.2}, 0.5, 1e-11),  # X does not affect the motion
        ({"body": WIDE}, 0.5, 1e-11),  # I_x < I_z
        ({"body": SKEW}, 0.5, 1e-11),  # I_x, I_y and I_z all differ
        ({"platform_rate": 1000.0}, 0.05, 3e-10),  # seven turns of 26 000 rad/s^2
        ({"pivot_y": 0.0, "platform_rate": 30.0, "theta_dot": 3.0}, 0.5, 1e-11),
    ],
)
def test_mujoco_agrees_with_dop853(
    given: dict[str, Any], duration: float, tolerance: float
) -> None:
    problem = replace(DEFAULT, **given)
    body, square = problem.body, problem.platform_rate**2
    arm = body.mass * body.com_distance

    def slopes(t: float, y: Array) -> tuple[float, float]:
        pull = (body.inertia_y - body.inertia_z) / 2 * square * np.sin(2 * y[0])
        pull += arm * problem.pivot_y * square * np.cos(y[0]) - arm * problem.gravity * np.sin(y[0])
        return y[1], pull / body.inertia_x

    start = (problem.theta, problem.theta_dot)
    solved: Any = solve_ivp(slopes, (0.0, duration), start, method="DOP853", rtol=1e-13, atol=1e-13)
    trajectory = run(RK4, duration / 20_000, duration, **given)
    assert trajectory.observables["theta"][-1] == pytest.approx(solved.y[0, -1], abs=tolerance)


def test_general_body_takes_inertia_y_where_the_source_prints_inertia_x() -> None:
    # with I_y = I_x + 0.03 the two differ by 0.07 rad; the digits are those of physics section 1
    theta = run(body=SKEW).observables["theta"][-1]
    assert theta == pytest.approx(19.729448, abs=5e-7)


@pytest.mark.parametrize("name", [name for name in METHODS if name != "mujoco/rk4"])
def test_euler_types_are_of_first_order(name: str) -> None:
    # C2/C1 = -9.5/s: at 1e-3 s the slope has an error of 0.5 %, and by less below
    steps = np.array([0.5 / 2**n for n in range(9, 14)])
    errors = np.array([error(METHODS[name], float(step)) for step in steps])
    assert METHODS[name].order == 1
    assert slope(steps, errors) == pytest.approx(1.0, abs=0.01)
    wanted = [predicted(METHODS[name], float(step)) for step in steps]
    np.testing.assert_allclose(errors, wanted, rtol=1e-3)  # the third term, at the coarsest step


def test_rk4_has_the_error_of_its_two_leading_terms() -> None:
    # C5/C4 = 8900/s, so both show between 1e-3 and 1e-4 s; C6 takes 2 % at the coarsest step
    steps = 0.5 / np.array([200, 400, 800, 1600, 3200])
    errors = np.array([error(RK4, float(step)) for step in steps])
    wanted = np.array([predicted(RK4, float(step)) for step in steps])
    np.testing.assert_allclose(errors, wanted, rtol=0.02)
    assert slope(steps, errors) == pytest.approx(slope(steps, wanted), abs=0.01)
    assert 4.5 < slope(steps, errors) < 4.95


def test_the_first_order_integrators_take_the_same_steps() -> None:
    # the additional terms of `implicit` act between platform and cone, and the platform keeps its
    # rate
    ends = {
        name: run(method, 1e-3).observables["theta"]
        for name, method in METHODS.items()
        if name != "mujoco/rk4"
    }
    for name in ("mujoco/implicitfast", "mujoco/discrete"):
        np.testing.assert_array_equal(ends[name], ends["mujoco/euler"])
    np.testing.assert_allclose(ends["mujoco/implicit"], ends["mujoco/euler"], rtol=0, atol=1e-12)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("pivot_x", [0.0, 0.2])
@pytest.mark.parametrize("armature", [1e6, 1e8, 1e10])
def test_armature_has_the_error_that_theory_gives_it(armature: float, pivot_x: float) -> None:
    # second order in 1/A, and 5e-13 of round-off and step error beside an error of 1.6/A
    problem = replace(DEFAULT, pivot_x=pivot_x)
    simulation = compiled(SYSTEM.case(scene(pivot_x=pivot_x)), RK4, 5e-5)
    firm = simulation.run().observables["theta"]
    simulation.model = whole(MJCF, problem, armature).compile()
    simulation.model.opt.timestep = 5e-5
    simulation.data = mujoco.MjData(simulation.model)
    moved = np.abs(simulation.run().observables["theta"] - firm).max()
    assert moved == pytest.approx(platform_error(problem, 0.5, armature)[0], rel=1e-3, abs=5e-13)


def test_armature_of_the_model_adds_less_than_round_off() -> None:
    # below one unit in the last place of theta (3.6e-15 at 20 rad), whatever the body's size
    for body in (DEFAULT.body, cone(8000.0, 5.0, 0.5), cone(100.0, 0.01, 0.5)):
        bounds = model_error(SYSTEM.case(scene(body=body)), RK4, 1e-4)
        assert bounds["theta"]["armature"] < 3.6e-15


@pytest.mark.parametrize("pivot", [(20.0, 0.0), (0.0, 20.0), (-15.0, 15.0)])
def test_armature_exceeds_the_load_wherever_the_pivot_is(pivot: tuple[float, float]) -> None:
    x, y = pivot
    problem = replace(DEFAULT, pivot_x=x, pivot_y=y)
    carried = DEFAULT.body.mass * (x**2 + y**2)  # and the body's own, which is less
    assert 1e15 * carried < model_armature(problem) < 2e16 * carried


WRONG: tuple[dict[str, Any], ...] = (
    {"gravity": 9.8 * (1 + 1e-6)},
    {"platform_rate": 26.0 * (1 + 1e-6)},
    {"theta_dot": 37.0 * (1 + 1e-9)},
    {"body": replace(DEFAULT.body, inertia_x=DEFAULT.body.inertia_x * (1 + 1e-9))},
)


@pytest.mark.parametrize("changed", WRONG, ids=lambda changed: next(iter(changed)))
def test_a_small_change_is_seen(changed: dict[str, Any]) -> None:
    # by the tolerance of test_rk4_reaches_the_exact_motion, and by that of the prediction
    wrong = error(RK4, 1e-4, **changed)
    assert abs(wrong) > 2e-12
    assert abs(wrong - predicted(RK4, 1e-4)) > 0.02 * abs(predicted(RK4, 1e-4))


def test_the_printed_hamiltonian_is_seen() -> None:
    printed = DEFAULT.printed_motion().observe(END)["theta"][0]
    assert abs(run(step=1e-3).observables["theta"][-1] - printed) > 6.0


def test_a_step_ten_times_too_large_is_seen() -> None:
    assert abs(error(EULER, 1e-3)) > 9 * abs(predicted(EULER, 1e-4))
    assert abs(error(RK4, 1e-3)) > 1e4 * abs(predicted(RK4, 1e-4))


def test_trimming_changes_no_bit() -> None:
    # the cost itself is measured in tests/benchmarks; here 0.1 s of each is enough
    for method in METHODS.values():
        assert trimming(SYSTEM.case(scene()), method, steps=1000, repeats=3).identical


def test_a_start_given_by_its_excess_energy_is_taken() -> None:
    given = replace(DEFAULT, excess=1e-3)
    assert run(excess=1e-3).observables["theta_dot"][0] == given.started.theta_dot
