"""A push that comes half a step early fails the verdict, whatever the kind of exact answer."""

from dataclasses import replace

import pytest

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.rod_tension import RodMotion
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.verdict import judge

STEP, DURATION = 5e-3, 20.0  # [s]


def early(case, time):
    """The case with the exact motion and its prediction under a push `time` [s] early."""
    problem = case.problem
    rotor = replace(problem.rotor, forcing_phase=problem.forcing_frequency * time)
    start = (problem.theta, problem.theta_dot)
    motion = DrivenMotion(rotor, *start)
    if not problem.linear:
        motion = RodMotion(motion, problem.system)
    return replace(case, reference=motion, errors=RotorErrors(rotor, *start, motion))


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    "method", ["mujoco/rk4+midpoint", "mujoco/euler+midpoint", "ode/rk4", "ode/leapfrog"]
)
@pytest.mark.parametrize("case", ["forced-small", "forced-large", "forced-chaotic"])
@pytest.mark.parametrize("system", ["simple-pendulum", "linear-pendulum"])
def test_a_push_half_a_step_early(system, case, method):
    posed = case_of(scene(f"{system}/{case}"))
    how = find_method(method)
    posed = posed.lasting(DURATION)
    verdicts = [
        judge(measure(early(posed, time), how, STEP)[0], posed.system, how).verdict
        for time in (0.0, STEP / 2)
    ]
    assert verdicts == ["predicted", "off-prediction"]
