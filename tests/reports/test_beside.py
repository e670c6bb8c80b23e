"""A run beside a method's step sizes is judged by itself, and tells of no plateau."""

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement, ObservedError, Prediction
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge_method

SCENE, METHOD = "cone-pendulum/rotating-base", "ode/rk4"
STEPS = (8e-3, 4e-3, 2e-3, 1.5e-3)
BESIDE = 1e-3


def run(step, error, predicted):
    """A run with this error of both observables, and a prediction of it."""
    found = Prediction(
        predicted,
        predicted,
        {},
        0.0,
        abs(error - predicted),
        1e-9,
        max(abs(error - predicted) - 1e-9, 0.0),
    )
    errors = {
        n: ObservedError(error, error, 1e-16, 1.0, predicted=found)
        for n in ("theta", "theta_dot")
    }
    return Measurement(SCENE, METHOD, step, "done", errors=errors, duration=0.5, steps=500)


def study(error, predicted, beside=(BESIDE,)):
    """The verdict on errors of first order, and one beside them."""
    runs = (*(run(h, h, h) for h in STEPS), run(BESIDE, error, predicted))
    found = ConvergenceStudy(SCENE, METHOD, runs, beside=beside)
    case = case_of(find_scene(SCENE))
    return judge_method(found, case.system, find_method(METHOD), case.system.quantities(case))


def test_an_error_that_is_not_the_predicted_one_fails_beside_the_step_sizes_too():
    assert study(1e-3, 1e-3).whole.verdict == "predicted"
    assert study(1.1e-3, 1e-3).whole.verdict == "off-prediction"
    assert [j.verdict for j in study(1.1e-3, 1e-3).runs] == ["predicted"] * 4 + [
        "off-prediction"
    ]


def test_it_tells_of_no_plateau_and_of_no_size():
    # as large as the largest of the four before it: among these it would be a plateau
    beside, among = (study(5e-3, 5e-3, steps) for steps in ((BESIDE,), ()))
    assert among.whole.verdict == "not-converging"
    assert beside.whole.verdict == "predicted"
    assert set(beside.whole.errors) == set(STEPS)
