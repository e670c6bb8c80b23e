"""The recommended step has the stated error, on made-up curves of every kind; fresh runs are in
tests/validation."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.method import Method
from plumbob.engines.study.stability import (
    MeasuredLimit,
    SceneLimits,
    StabilitySearch,
)
from plumbob.models.scene import step_sizes
from plumbob.reports.advice.advice import study_recommendation
from plumbob.reports.judge.verdict import JudgedMethod, Judgement
from plumbob.reports.view.top_tables import ERRORS
from plumbob.tests.site import whole_profile
from plumbob.tests.support.studies import SCENE, made_up

STEPS = step_sizes(5e-3, 1e-5)
FIRST = Method("made/euler", Scheme(EULER), 1)
FOURTH = Method("made/rk4", Scheme(RK4), 4)
positive = st.floats(-3, 3).map(lambda x: 10.0**x)


def one(method, error):
    return made_up([(method, STEPS, error)])


def cheapest(study, error, judged=None):
    """The answer from a study of one scene, by default with nothing known against any method."""
    return study_recommendation(study, study.scenes[0], error, judged or {})


@given(c4=positive, c5=positive, wanted=st.floats(-12, -1).map(lambda x: 10.0**x))
def test_convex_curve(c4, c5, wanted):
    def error(h):
        return 1e8 * c4 * h**4 + 1e10 * c5 * h**5

    choice = cheapest(one(FOURTH, error), wanted).choice
    if choice is None:
        assert error(STEPS[-1]) > wanted
        return
    assert error(choice.step) <= wanted * (1 + 1e-12)
    finer = [h for h in STEPS if error(h) <= wanted]
    assert choice.step == finer[0]


def test_a_run_that_diverged_bounds_the_step():
    study = one(FOURTH, lambda h: math.inf if h > 1e-3 else 1e6 * h**4)
    choice = cheapest(study, 1e3).choice
    assert (choice.step, choice.measured) == (1e-3, True)


def test_cheapest_first_then_another_method():
    study = made_up(
        [(FIRST, STEPS, lambda h: h), (FOURTH, STEPS, lambda h: 1e4 * h**4)],
        ns=(1000.0, 4000.0),
    )
    tight = cheapest(study, 1e-5)
    loose = cheapest(study, 5e-3)
    assert tight.choice.method == FOURTH.name
    assert (loose.choice.method, loose.runner_up.method) == (FIRST.name, FOURTH.name)
    assert [c.method for c in loose.by_engine] == [FIRST.name]
    assert loose.choice.ns_per_second == pytest.approx(1000.0 / 5e-3)


@pytest.mark.parametrize("verdict", ["not-converging", "off-prediction", "diverged"])
def test_a_method_that_does_not_converge_is_never_recommended(verdict):
    study = made_up([(FIRST, STEPS, lambda h: 1e-9), (FOURTH, STEPS, lambda h: 1e8 * h**4)])
    verdicts = {
        (SCENE, name): JudgedMethod(Judgement(found, {}, ""), ())
        for name, found in ((FIRST.name, verdict), (FOURTH.name, "predicted"))
    }
    open_to_all = cheapest(study, 1e-3)
    assert open_to_all.choice.method == FIRST.name
    found = cheapest(study, 1e-3, verdicts)
    named = (found.choice, found.runner_up, *found.by_engine, found.best)
    assert {choice.method for choice in named if choice is not None} == {FOURTH.name}
    assert cheapest(one(FIRST, lambda h: 1e-9), 1e-3, verdicts).choice is None


def test_without_theory_the_errors_themselves_have_to_converge():
    verdicts = {(SCENE, FIRST.name): JudgedMethod(Judgement("pre-asymptotic", {}, ""), ())}
    assert cheapest(one(FIRST, lambda h: h), 1e-3, verdicts).choice is not None
    for error in (lambda h: 1e-4 + 0.01 * h, lambda h: 1e-4 * (h / 1e-5) ** 0.4):
        assert cheapest(one(FIRST, error), 1e-3, verdicts).choice is None
    few = made_up([(FIRST, STEPS[:4], lambda h: h)])
    assert cheapest(few, 1e-2, verdicts).choice is None


def test_the_heads_of_the_page_say_the_errors_that_are_looked_up():
    for error, head in ERRORS:
        percent = head.endswith("%")
        assert float(head.rstrip(" %")) == pytest.approx(error * (100.0 if percent else 1.0))


def _limited(study, step, measured=False):
    """A study whose methods have a limit at a step [s], or one that holds up to it at least."""
    bound = SceneLimits((MeasuredLimit("unstable", None, step, None, ""),))
    predicted = SceneLimits((MeasuredLimit("unstable", step, None, None, ""),))
    pairs = [(c.scene, c.method) for c in study.convergence]
    extras = {StabilitySearch(*pair, False): predicted for pair in pairs}
    if measured:
        extras = {StabilitySearch(*pair): bound for pair in pairs}
    return replace(study, extras=extras)


def _named(found):
    every = (found.choice, found.runner_up, *found.by_engine, found.surrogate, found.best)
    return [choice for choice in every if choice is not None]


def test_a_limit_of_stability_limits_the_step():
    study = one(FOURTH, lambda h: 1e6 * h**4)
    near, far = (cheapest(_limited(study, step), 1e6).choice for step in (6e-3, 1.0))
    assert (near.step, near.limited) == (2e-3, True)
    assert near.margin == pytest.approx(3.0)
    assert (far.step, far.limited) == (5e-3, False)
    assert far.margin == pytest.approx(200.0)
    never, bound = (
        cheapest(_limited(study, step, measured), 1e6).choice
        for step, measured in ((math.inf, False), (6e-3, True))
    )
    for free in (never, bound):
        assert (free.step, free.limit, free.limited) == (5e-3, None, False)
    none = cheapest(_limited(study, 0.0), 1e6)
    assert (none.choice, none.best) == (None, None)


@pytest.mark.long
def test_no_step_of_the_quick_profile_is_within_a_fifth_of_a_limit():
    """Over every pair, with the limits that are stored, and with one at the step that is named."""
    study = whole_profile.study()
    moved = 0
    for scene in study.scenes:
        runs = tuple(c for c in study.convergence if c.scene == scene.name)
        of_scene = replace(study, scenes=(scene,), convergence=runs)
        first = cheapest(of_scene, 1e-1)
        assert all(c.limit is None or c.step < 0.8 * c.limit.step for c in _named(first))
        if first.choice is not None and first.choice.control == "step":
            again = cheapest(_limited(of_scene, first.choice.step), 1e-1)
            assert again.choice != first.choice
            assert all(c.limit and c.step < 0.8 * c.limit.step for c in _named(again))
            moved += 1
    assert moved > 10
