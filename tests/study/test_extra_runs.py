"""Extra runs: declared as data, made once with the rest of a study, kept to the last bit."""

import math
from dataclasses import replace

import pytest

from plumbob.engines.registry import engine_of, method, methods
from plumbob.engines.study import store
from plumbob.engines.study.extra_runs import ExtraRun, StepRun, TrimmingRun
from plumbob.engines.study.runner import run_study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of, matching_scenes, scene
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import bits

SCENE = "cone-pendulum/deep-well"
PLAIN = ExtraRun(SCENE, "ode/rk4", 1e-3)
CHANGED = ExtraRun(SCENE, "mujoco/rk4", 1e-3, 0.05, (("platform_rate", 12.0),))
SETTING = ExtraRun(
    "simple-pendulum/free-large", "pymunk/default", 4e-3, 0.4, settings=(("iterations", 1),)
)
NOT_MEANT = ExtraRun(SCENE, "pymunk/feet", 1e-3)
DIVERGES = ExtraRun(SCENE, "mujoco/euler", 0.05, None, (("platform_rate", 900.0),))
TRIMMING = TrimmingRun(SCENE, "mujoco/euler", 1e-3, 20, 3)
NO_TRIMMING = TrimmingRun(SCENE, "ode/rk4", 1e-3, 20, 3)
STEP = StepRun(SCENE, "ode/rk4", 2e-3)  # one of the steps of the study too
ALL = (
    STEP,
    PLAIN,
    CHANGED,
    SETTING,
    NOT_MEANT,
    DIVERGES,
    TRIMMING,
    NO_TRIMMING,
)


def wanted(plan):
    """Each request twice, as from two findings that need the same run."""
    return (*ALL, *ALL)


@pytest.fixture(scope="module")
def study():
    chosen = [replace(s, steps=(5e-3, 2e-3)) for s in matching_scenes(SCENE)]
    return run_study(
        chosen, methods("ode/rk4"), timed=False, requests=wanted, command="plumbob"
    )


def untimed(run):
    """All that a recording says but how long it took."""
    return bits(run and replace(run, seconds=0.0))


def run_directly(request):
    chosen = scene(request.scene, dict(request.changes))
    how = method(request.method)
    how = replace(how, settings={**how.settings, **dict(request.settings)})
    case = case_of(chosen)
    if request.duration is not None:
        case = case.lasting(request.duration)
    return engine_of(how).prepare(case, how, request.step).run()


@pytest.mark.parametrize("request_", [PLAIN, CHANGED, SETTING])
def test_a_recording_is_that_of_the_run(study, request_):
    assert untimed(study.answer(request_)) == untimed(run_directly(request_))


def test_one_more_step_has_the_errors_of_a_step_of_the_scene(study):
    ((run,),) = ([m for m in c.measurements if m.step == STEP.step] for c in study.convergence)
    more = study.answer(STEP)
    assert (more.status, more.steps, more.duration) == (run.status, run.steps, run.duration)
    sizes = [{n: (of.largest, of.end) for n, of in m.errors.items()} for m in (run, more)]
    # Both compare the same run with the exact motion, in double precision and in twice that: they
    # differ by the rounding of angles and rates, some hundred units in the last place.
    for name, (largest, end) in sizes[0].items():
        assert sizes[1][name] == pytest.approx((largest, end), abs=1e-13)


def test_settings_of_a_request_replace_those_of_the_method():
    request = ExtraRun("simple-pendulum/free-large", "pymunk/tight", 4e-3, 0.4)
    how = method(request.method)
    plain, again, other = (
        replace(request, settings=settings).answer(how)
        for settings in ((), (("error_bias", 0.0),), (("error_bias", 0.5),))
    )
    assert isinstance(plain, Trajectory)
    assert isinstance(again, Trajectory)
    assert isinstance(other, Trajectory)
    assert untimed(again) == untimed(plain) != untimed(other)


def test_a_stored_study_is_the_study(study, tmp_path):
    back = store.load(tmp_path / "new", save(study, tmp_path / "new"))
    for request, result in study.extras.items():
        again = back.extras[request]
        if isinstance(result, Trajectory):
            assert isinstance(again, Trajectory)
            assert bits(again) == bits(result)
        else:
            assert again == result
    nothing = {"extras": {}, "reference_step": 0.0}  # which is NaN: not timed
    assert replace(back, **nothing) == replace(study, **nothing)
    assert math.isnan(back.reference_step)
