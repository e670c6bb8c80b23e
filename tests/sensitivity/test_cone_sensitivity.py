"""Small mistakes fail the verdicts: gravity, the platform's rate, the Hamiltonian, the step. A
tolerance that lets these pass has no purpose."""

from __future__ import annotations

from dataclasses import replace

import pytest

from plumbob.analytic.errors.smooth_motion.pendulum_errors import PendulumErrors
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge
from plumbob.tests.support.cases import held_against

METHODS = [("mujoco/rk4", 5e-4), ("ode/rk4", 5e-4), ("mujoco/rk4", 1e-4), ("ode/dop853", 1e-13)]


@pytest.mark.long(keep=5)
@pytest.mark.parametrize(("method", "step"), METHODS)
@pytest.mark.parametrize("name", ["gravity", "platform_rate", "pivot_y", "theta_dot"])
def test_a_parameter_error_of_a_millionth(name: str, method: str, step: float) -> None:
    right = find_scene("cone-pendulum/rotating-base")
    system, how = system_of(right), find_method(method)
    assert judge(measure(case_of(right), how, step)[0], system, how).verdict == "predicted"
    wrong = find_scene(right.name, {name: right.parameters[name] * (1 + 1e-6)})
    other = held_against(case_of(right), case_of(wrong))
    assert judge(measure(other, how, step)[0], system, how).verdict == "off-prediction"


@pytest.mark.parametrize(("method", "step"), [*METHODS, ("mujoco/euler", 1e-4)])
def test_the_printed_hamiltonian(method: str, step: float) -> None:
    scene = find_scene("cone-pendulum/rotating-base")
    system, how = system_of(scene), find_method(method)
    printed = system.problem(scene.parameters).printed_motion()
    wrong = replace(case_of(scene), reference=printed, errors=PendulumErrors(printed))
    assert judge(measure(wrong, how, step)[0], system, how).verdict == "off-prediction"


@pytest.mark.parametrize("scene_name", ["rotating-base", "unequal-inertia", "deep-well"])
@pytest.mark.parametrize("method", ["mujoco/euler", "mujoco/rk4", "ode/leapfrog", "ode/rk4"])
def test_a_step_ten_times_too_large(method: str, scene_name: str) -> None:
    scene = find_scene(f"cone-pendulum/{scene_name}")
    system, how = system_of(scene), find_method(method)
    right, _ = measure(case_of(scene), how, 2e-4)
    large, _ = measure(case_of(scene), how, 2e-3)
    assert judge(right, system, how).verdict == "predicted"
    pretended = {
        name: replace(error, largest=large.errors[name].largest)
        for name, error in right.errors.items()
    }
    assert judge(replace(right, errors=pretended), system, how).verdict == "off-prediction"


def test_the_inertia_that_the_source_prints() -> None:
    """I_x for I_y in the centrifugal term: equal for a cone, wrong for a general body."""
    scene = find_scene("cone-pendulum/unequal-inertia")
    system, how = system_of(scene), find_method("mujoco/rk4")
    printed = find_scene(scene.name, {"inertia_y": scene.parameters["inertia_x"]})
    other = held_against(case_of(scene), case_of(printed))
    assert judge(measure(case_of(scene), how, 5e-4)[0], system, how).verdict == "predicted"
    assert judge(measure(other, how, 5e-4)[0], system, how).verdict == "off-prediction"


def test_a_bound_wider_than_the_motion_is_no_bound() -> None:
    """Near a separatrix the tolerance of a loose solver exceeds the range of the motion."""
    scene = find_scene("cone-pendulum/above-barrier-1e-6")
    system, how = system_of(scene), find_method("ode/radau")
    found, _ = measure(case_of(scene), how, 1e-5)
    assert found.errors["theta"].largest > 1.0
    assert judge(found, system, how).verdict == "pre-asymptotic"


def test_a_run_far_from_the_exact_motion_has_no_bound() -> None:
    """Model-error bounds are computed along the exact motion and hold near it only."""
    scene = find_scene("capsule-line/ca1")
    system, how = system_of(scene), find_method("mujoco/euler+coulomb")
    found, _ = measure(case_of(scene), how, 1e-3)
    error = found.errors["displacement"]
    assert error.predicted is not None
    assert judge(found, system, how).verdict == "predicted"
    far = replace(error, predicted=replace(error.predicted, largest=0.6 * error.scale))
    elsewhere = replace(found, errors={**found.errors, "displacement": far})
    assert judge(elsewhere, system, how).verdict == "pre-asymptotic"
