"""Small mistakes in a pendulum fail its verdict: damping rate or length wrong by a millionth, a
push half a step early; for every kind of exact answer."""

from __future__ import annotations

from dataclasses import replace

import pytest

from plumbob.analytic.errors.smooth_motion.global_error import RotorErrors
from plumbob.analytic.errors.smooth_motion.pendulum_errors import RodErrors
from plumbob.analytic.errors.theory import ErrorTheory
from plumbob.analytic.reference import Reference
from plumbob.analytic.systems.pendulums.rod_tension import RodMotion
from plumbob.analytic.systems.pendulums.unending_motion import UnendingMotion
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge
from plumbob.tests.support.cases import run_of

DURATION = 20.0  # [s]
Exact = tuple[Reference, ErrorTheory]


def verdict(name: str, method: str, step: float, exact: Exact | None = None) -> str:
    """The verdict on one run, compared with its own reference or another."""
    scene, how = replace(find_scene(name), duration=DURATION), find_method(method)
    case = case_of(scene)
    if exact is None:
        return judge(run_of(how, scene, step)[0], case.system, how).verdict
    other = replace(case, reference=exact[0], errors=exact[1])
    return judge(measure(other, how, step)[0], case.system, how).verdict




def early(problem: SimplePendulum, time: float) -> Exact:
    """The exact motion and its prediction, under a push that comes `time` [s] early."""
    rotor = replace(problem.rotor, forcing_phase=problem.forcing_frequency * time)
    start = (problem.theta, problem.theta_dot)
    angle, errors = UnendingMotion(rotor, *start), RotorErrors(rotor, *start)
    if problem.linear:
        return angle, errors
    return RodMotion(angle, rotor, problem.length, problem.gravity), RodErrors(problem, errors)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("method", ["ode/rk4", "ode/leapfrog", "mujoco/rk4+midpoint"])
@pytest.mark.parametrize("case", ["forced-small", "forced-large", "forced-chaotic"])
@pytest.mark.parametrize("system", ["simple-pendulum", "linear-pendulum"])
def test_a_push_half_a_step_early(system: str, case: str, method: str) -> None:
    name, step = f"{system}/{case}", 5e-3
    problem = system_of(find_scene(name)).problem(find_scene(name).parameters)
    assert verdict(name, method, step, early(problem, 0.0)) == "pass"
    assert verdict(name, method, step, early(problem, step / 2)) == "fail"


