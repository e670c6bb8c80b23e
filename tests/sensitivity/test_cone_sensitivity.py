"""Small mistakes fail the verdicts: gravity, the platform's rate, the Hamiltonian, the step. A
tolerance that lets these pass has no purpose."""

from dataclasses import replace

import pytest

from plumbob.analytic.errors.smooth_motion.rotor_errors import pendulum_errors
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge

METHODS = [("mujoco/rk4", 5e-4), ("ode/rk4", 5e-4), ("mujoco/rk4", 1e-4), ("ode/dop853", 1e-13)]


@pytest.mark.parametrize(("method", "step"), [*METHODS, ("mujoco/euler", 1e-4)])
def test_the_printed_hamiltonian(method, step):
    scene = find_scene("cone-pendulum/rotating-base")
    system = system_of(scene)
    how = find_method(method)
    printed = system.problem(scene.parameters).printed_motion()
    wrong = replace(case_of(scene), reference=printed, errors=pendulum_errors(printed))
    assert judge(measure(wrong, how, step)[0], system, how).verdict == "off-prediction"


def test_a_bound_wider_than_the_motion_is_no_bound():
    """Near a separatrix the tolerance of a loose solver exceeds the range of the motion."""
    scene = find_scene("cone-pendulum/above-barrier-1e-6")
    system = system_of(scene)
    how = find_method("ode/radau")
    found, _ = measure(case_of(scene), how, 1e-5)
    assert found.errors["theta"].largest > 1.0
    assert judge(found, system, how).verdict == "pre-asymptotic"
