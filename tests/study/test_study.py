"""A study: equal errors by one process, two, or any executor; costs timed alone; large steps."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from plumbob.engines.registry import method, methods
from plumbob.engines.study.convergence import (
    chosen_step_sizes,
    convergence_study,
)
from plumbob.engines.study.measurement import REFERENCE_STEP, floor, measure
from plumbob.engines.study.runner import most_steps, run_study
from plumbob.models.registry import case_of, matching_scenes, scene

SCENES = "cone-pendulum/rotating-base,cone-pendulum/deep-well"
METHODS = "mujoco/euler,ode/rk4"


def _study(**how):
    chosen = [replace(s, steps=(5e-3, 2e-3, 1e-3, 5e-4)) for s in matching_scenes(SCENES)]
    return run_study(chosen, methods(METHODS), timed=False, **how)


def _errors(convergence):
    return [
        (c.scene, c.method, m.step, m.errors["theta"].end)
        for c in convergence
        for m in c.measurements
    ]


@pytest.mark.long
def test_one_process_two_and_an_executor_agree_to_the_last_bit():
    alone = _errors(_study(jobs=1).convergence)
    assert len(alone) == 16
    assert _errors(_study(jobs=2).convergence) == alone
    with ThreadPoolExecutor(2) as executor:
        assert _errors(_study(executor=executor).convergence) == alone


def test_two_more_step_sizes_follow_the_first_at_the_floor():
    chosen = scene("cone-pendulum/resting-base")
    runs = convergence_study(chosen, method("ode/rk4"), 10**6).measurements
    assert runs[-1].step > min(chosen.steps)
    errors = [(run.errors["theta"], run.steps) for run in runs]
    at_floor = [error.largest <= 3.0 * floor(error, steps) for error, steps in errors]
    assert sum(at_floor) == 3
    assert at_floor[-1]


def test_the_step_that_is_asked_about_is_run_whatever_it_takes():
    chosen = scene("cone-pendulum/rotating-base")  # 0.5 s
    own = replace(method("mujoco/euler"), name="mujoco/mine", step_sizes=(1e-6, 1e-3, 5e-7))
    assert chosen_step_sizes(chosen, own, 1000) == (1e-6, 1e-3)
    assert 1e-6 not in chosen_step_sizes(chosen, method("ode/rk4"), 1000, (1e-3, 1e-6))


def test_an_error_curve_has_the_sign_of_the_error():
    # of the method less the exact answer; at the end it is the error that is stored
    chosen = replace(scene("cone-pendulum/rotating-base"), steps=(1e-3,))
    found = convergence_study(chosen, method("mujoco/euler"), 10**6)
    assert found.trace.errors[-1] == found.measurements[-1].errors["theta"].end != 0.0


def test_rounding_alone_leaves_open_what_the_floor_is_made_of():
    # where theory knows a run at its very step: four standard deviations of a random walk
    found, _ = measure(case_of(scene("capsule-line/ca1")), method("mujoco/euler+coulomb"), 1e-3)
    error = found.errors["displacement"]
    assert error.predicted.for_this_step
    wanted = floor(replace(error, model={}), found.steps)
    assert error.predicted.open == pytest.approx(wanted, rel=1e-9, abs=0.0)
    own = error.uncertainty * (1.0 + 2.0 * found.steps**0.5)
    assert wanted == pytest.approx(own, rel=1e-12, abs=0.0)


def test_a_cost_is_taken_at_the_step_that_errors_are_shown_at(monkeypatch):
    asked = []

    def record(chosen, timed, *how):
        asked.extend(step for _, step in timed)

    monkeypatch.setattr("plumbob.engines.study.runner.costs", record)
    chosen = replace(scene("cone-pendulum/deep-well"), steps=(1e-3, 5e-4, 2e-4, 1e-4))
    own = replace(method("mujoco/euler"), name="mujoco/mine", step_sizes=(2e-3, 1e-3, 5e-4))
    run_study([chosen], [method("ode/rk4"), own])
    assert asked == [1e-3, 2e-3]  # of a method with steps of its own the first, the user's
    asked.clear()
    run_study([replace(chosen, duration=0.05)], [method("ode/rk4")])
    assert asked == [2e-4]  # 50 steps of 1 ms are no time: the middle one


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(
    ("name", "finest"),  # what the quick profile ran without it
    [
        ("cone-pendulum/fast-platform", 5e-6),
        ("simple-pendulum/near-top-1e-6", 2e-3),
        ("capsule-turn/unloaded-short", 1.11e-4),
        ("capsule-hold/0.999", 2e-3),
    ],
)
def test_every_pair_is_run_at_the_step_that_methods_are_compared_at(name, finest):
    chosen = scene(name)
    how = method("mujoco/rk4+coulomb" if "capsule" in name else "ode/rk4")
    found = convergence_study(chosen, how, most_steps(chosen, "quick"))
    steps = [m.step for m in found.measurements]
    assert REFERENCE_STEP in steps
    assert steps == sorted(steps, reverse=True)
    rest = [h for h in steps if h != REFERENCE_STEP]
    assert min(rest) == pytest.approx(finest, rel=0.01)
    assert set(rest) <= set(chosen.steps)


def test_a_run_beside_the_step_sizes_tells_of_no_order():
    chosen = scene("cone-pendulum/fast-platform")
    how = method("ode/rk4")
    found = convergence_study(chosen, how, 25_000)
    assert found.beside == (REFERENCE_STEP,)
    alone = convergence_study(chosen, how, 25_000, chosen.steps)
    assert found.order == alone.order
    assert [m.step for m in found.measurements[1:]] == [m.step for m in alone.measurements]
    at = found.measurements[0]
    assert at.step == REFERENCE_STEP
    assert at.errors["theta"].largest > 1.0  # with it the order would be another one
