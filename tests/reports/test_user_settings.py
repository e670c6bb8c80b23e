"""Report on a user's settings, on made-up curves: cheaper methods, and more accurate ones."""

from dataclasses import replace

import pytest

from plumbob.analytic.schemes import CLOSED_FORM, Scheme
from plumbob.engines.method import USER_METHOD as NAME
from plumbob.engines.method import Method
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.runner import joined
from plumbob.models.scene import step_sizes
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.tests.support.studies import SCENE, made_up

STEPS = step_sizes(5e-3, 1e-4)
OWN = replace(find_method("mujoco/euler"), name=NAME, step_sizes=(2e-3, 1e-3, 5e-4, 2.5e-4))
RK4 = find_method("mujoco/rk4")
PEER = find_method("ode/rk4")
EXACT = Method("exact/closed-form", Scheme(CLOSED_FORM), None, "tolerance", {}, (1e-16,))


def study(largest=1.0):
    """Errors 1000 h, 1e8 h^4 twice, and a closed form; steps of 1000, 4000, 2000 and 10 ns."""
    return made_up(
        [
            (OWN, OWN.step_sizes, lambda h: 1e3 * h * largest),
            (RK4, STEPS, lambda h: 1e8 * h**4),
            (PEER, STEPS, lambda h: 1e8 * h**4),
            (EXACT, EXACT.step_sizes, lambda h: 1e-15),
        ],
        ns=(1000.0, 4000.0, 2000.0, 10.0),
    )


def said(of):
    return user_results(of, judge_study(of))


def test_what_costs_less_and_what_is_more_accurate():
    (found,) = said(study())
    assert (found.step, found.error) == (2e-3, 2.0)
    assert found.finest == (2.5e-4, 0.25)
    assert found.ns_per_second == pytest.approx(1000 / 2e-3)
    # 1e8 h^4 is 0.0625 at the coarsest step, and 2 nowhere: that step is the cheapest
    here = found.at_equal_accuracy.here
    anywhere = found.at_equal_accuracy.anywhere
    assert (here.method, here.step) == ("mujoco/rk4", 5e-3)
    assert here.ns_per_second / found.ns_per_second == pytest.approx(4000 / 5e-3 * 2e-3 / 1000)
    assert (anywhere.method, anywhere.step) == ("ode/rk4", 5e-3)
    # 5e5 ns per second are too little for any step of the one, and enough for steps of 5e-3 s of
    # the other; closed forms do not count
    assert found.better.here is None
    assert (found.better.anywhere.method, found.better.anywhere.step) == ("ode/rk4", 5e-3)


def test_joined_costs_are_those_of_the_first_study():
    first = made_up([(RK4, STEPS, lambda h: h)], ns=(4000.0,))
    slow = replace(
        made_up([(OWN, OWN.step_sizes, lambda h: h)], ns=(3000.0,)), reference_step=3000.0
    )
    both = joined(first, slow)
    assert [m.name for m in both.methods] == [NAME, "mujoco/rk4"]
    # the reference step took three times as long: on the first day a step would have taken 1000 ns
    assert both.costs[SCENE, NAME].ns_per_step == pytest.approx(1000.0)
    assert both.costs[SCENE, "mujoco/rk4"].ns_per_step == 4000.0
