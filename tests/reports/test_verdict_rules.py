"""What a verdict allows and no more: a series' remainder, an error that hardly falls, a failure."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from plumbob.analytic.answer_cache import Same, expected_series
from plumbob.engines.registry import engine_of, limits_of, methods
from plumbob.engines.registry import method as find_method
from plumbob.engines.sampling import sampled, step_count
from plumbob.engines.study import measurement
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, ObservedError, Prediction, measure
from plumbob.engines.study.runner import pairs
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, matching_scenes, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Quantity
from plumbob.reports.judge import expectations
from plumbob.reports.judge.tolerance import tolerance
from plumbob.reports.judge.verdict import judge, judge_method

SCENE, STEP = "cone-pendulum/rotating-base", 1e-5  # [s] where a series tells the error
EULER = find_method("ode/euler")
STEPS = (8e-4, 4e-4, 2e-4, 1e-4)


@dataclass
class Given:
    """A simulation that returns a trajectory."""

    trajectory: Trajectory
    compile_seconds: float = 0.0

    def run(self):
        return self.trajectory

    def stepped(self, fraction):
        raise NotImplementedError


def beside_the_series(parts, monkeypatch):
    """A run whose error is the series', and so many times its last two terms more."""
    case = case_of(find_scene(SCENE))
    steps = step_count(case.scene.duration, STEP)
    times = sampled(steps).astype(np.float64) * STEP
    powers, total, _ = expected_series(
        Same(case.reference), Same(case.errors), EULER.scheme, STEP, times.tobytes()
    )
    last = sorted(powers)[-2:]
    seen = {
        name: values + total[name] + parts * sum(np.abs(powers[p][name]) for p in last)
        for name, values in case.reference.observe(times).items()
        if name in total
    }
    run = Trajectory(times, seen, steps=steps)
    false = replace(engine_of(EULER), prepare=lambda case, method, step: Given(run))
    monkeypatch.setattr(measurement, "engine_of", lambda method: false)
    return measure(case, EULER, STEP)[0]


@pytest.mark.parametrize(
    ("parts", "verdict"),
    [
        (0.9, "predicted"),
        (-0.9, "predicted"),
        (4.0, "off-prediction"),
        (-4.0, "off-prediction"),
    ],
)
def test_a_series_leaves_its_last_two_terms_open(parts, verdict, monkeypatch):
    """To either side, and rounding, which is half as much here: a smaller error is none better."""
    found = beside_the_series(parts, monkeypatch)
    assert judge(found, system_of(find_scene(SCENE)), EULER).verdict == verdict


def test_the_remainder_in_a_tolerance_is_what_the_series_leaves_out(
    monkeypatch,
):
    found = beside_the_series(0.0, monkeypatch)
    predicted = found.errors["theta"].predicted
    allowed = tolerance(found, EULER, "theta", "rad")
    terms = {term.name: term.value for term in allowed.terms}
    wanted = sum(predicted.terms[p] for p in (3, 4))
    wanted += predicted.nonlinearity**4 * predicted.largest  # terms of degree five in the error
    assert terms["discretisation: remainder"] == pytest.approx(wanted, rel=1e-12)


def test_a_series_leaves_the_square_of_the_error_open():
    """Four terms of RK4 end before the power of the error's square. At 42.8 ms this square is more
    than the last two terms, and less than what is left open."""
    case = case_of(find_scene("simple-pendulum/rotating-slow"))
    error = measure(case, find_method("mujoco/rk4"), 0.0428)[0].errors["tension"]
    assert error.predicted.terms.keys() == {4, 5, 6, 7}
    assert error.predicted.difference > error.predicted.terms[6] + error.predicted.terms[7]
    assert error.predicted.beyond <= error.model_error
    assert 0.2 < error.predicted.difference / error.left_open < 1.0


def run_with(step, error, predicted):
    """Of a motion of size 1."""
    of = ObservedError(error, error, 1e-16, 1.0, predicted=predicted)
    errors = dict.fromkeys(("theta", "theta_dot"), of)
    return Measurement(SCENE, EULER.name, step, "done", errors=errors, steps=1000)


@pytest.mark.parametrize(
    ("left", "verdict"), [(0.25, "predicted"), (0.65, "predicted"), (0.75, "not-converging")]
)
def test_three_finer_steps_have_to_leave_less_than_seven_tenths(left, verdict):
    """Of an error that is as predicted at each."""
    runs = []
    for step in STEPS:
        error = 1e-3 * float(left ** (np.log(STEPS[0] / step) / np.log(STEPS[0] / STEPS[-1])))
        predicted = Prediction(error, error, {1: error, 2: 0.0, 3: 0.0}, 0.0)
        runs.append(run_with(step, error, predicted))
    found = ConvergenceStudy(SCENE, EULER.name, tuple(runs))
    about = (Quantity("theta", 1.0),)
    assert (
        judge_method(found, system_of(find_scene(SCENE)), EULER, about).whole.verdict == verdict
    )


@pytest.mark.parametrize(
    ("stays", "lasting", "verdict"),
    [
        (0.01, 0.0, "not-converging"),
        (0.01, 0.01, "predicted"),
        (0.01, 0.0099, "not-converging"),
        (0.01, 0.02, "predicted"),
        (0.6, 0.0, "pre-asymptotic"),  # of a motion of size 1: which way it goes on is open
        (1e-12, 0.0, "predicted"),  # a hundred round-offs
        (1e-10, 0.0, "not-converging"),
    ],
)
@pytest.mark.parametrize("name", ["theta", "theta_dot"])
def test_an_error_that_stays_is_predicted_where_its_size_is_derived(
    name, stays, lasting, verdict
):
    """Of a scheme that is stepped, and as predicted at each step: also of an observable that is not
    the leading one."""
    runs = []
    for step in STEPS:
        beside = max(stays - lasting, 0.0)
        known = Prediction(
            *(stays, stays, {}, 0.0), uncertainty=1e-16, lasting=lasting, beside_lasting=beside
        )
        run = run_with(step, step, Prediction(step, step, {}, 0.0, uncertainty=1e-16))
        errors = {**run.errors, name: replace(run.errors[name], largest=stays, predicted=known)}
        runs.append(replace(run, errors=errors))
    found = ConvergenceStudy(SCENE, EULER.name, tuple(runs))
    about = (Quantity("theta", 1.0),)
    assert (
        judge_method(found, system_of(find_scene(SCENE)), EULER, about).whole.verdict == verdict
    )


@pytest.mark.parametrize(
    ("predicted", "off", "verdict"),
    [
        (0.6, 1e-9, "off-prediction"),  # of a motion of size 1
        (0.6, 0.0, "pre-asymptotic"),
        (0.4, 1e-9, "not-converging"),
        (0.01, 0.59, "not-converging"),
    ],
)
def test_an_error_predicted_as_large_as_the_motion_shows_no_plateau(predicted, off, verdict):
    """All steps have the same error. If theory predicts it as large as the motion, a run that is
    off its prediction is `off-prediction`, and says nothing about convergence."""
    known = Prediction(predicted, predicted, {}, 0.0, off, beyond=off, uncertainty=1e-16)
    runs = tuple(run_with(step, predicted + off, known) for step in STEPS)
    study = ConvergenceStudy(SCENE, EULER.name, runs)
    interest = (Quantity("theta", 1.0),)
    judged = judge_method(study, system_of(find_scene(SCENE)), EULER, interest)
    assert judged.whole.verdict == verdict


@pytest.mark.parametrize(
    ("error", "verdict"),
    [(3.2, "pre-asymptotic"), (3.1, "not-converging")],  # [rad] half a turn is 3.14
)
def test_an_angle_error_of_half_a_turn_shows_no_plateau(error, verdict):
    """The angle reaches 20 rad: its motion counts as one turn all the same."""
    known = Prediction(error, error, {}, 0.0, uncertainty=1e-16)
    angle = ObservedError(error, error, 1e-16, 20.0, predicted=known)
    runs = []
    for step in STEPS:
        run = run_with(step, step, Prediction(step, step, {}, 0.0, uncertainty=1e-16))
        runs.append(replace(run, errors={**run.errors, "theta": angle}))
    study = ConvergenceStudy(SCENE, EULER.name, tuple(runs))
    interest = (Quantity("theta", 1.0),)
    judged = judge_method(study, system_of(find_scene(SCENE)), EULER, interest)
    assert judged.whole.verdict == verdict


@pytest.mark.parametrize(
    ("predicted", "error", "verdict"),
    [
        (11.0, 0.1, "pre-asymptotic"),
        (9.0, 0.1, "off-prediction"),
        (11.0, 12.0, "off-prediction"),
        (11.0, 11.0, "predicted"),
    ],
)
def test_a_run_may_stay_below_an_error_that_is_predicted_to_have_no_bounds(
    predicted, error, verdict
):
    """One that exceeds it is off, and one that is as predicted is that."""
    off = abs(predicted - error)
    of = Prediction(predicted, predicted, {}, 0.0, off, beyond=off, uncertainty=1e-9)
    run = run_with(1e-3, error, of)
    assert judge(run, system_of(find_scene(SCENE)), EULER).verdict == verdict


def test_no_failure_is_expected_without_a_size():
    """Also not beside another verdict: a body that nothing touches fails nowhere."""
    for scene, method in pairs(matching_scenes("*", "quick"), methods()):
        wanted = expectations.expected(scene.name, method.name)
        if {wanted.verdict, wanted.other} & {"off-prediction", "not-converging"}:
            limits = limits_of(method.name)
            assert (scene.name, method.name) in {**limits.sizes, **limits.solvers}
