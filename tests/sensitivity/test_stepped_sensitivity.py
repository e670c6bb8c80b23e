"""A prediction of the wrong sign, or for a step later, fails at steps that no series reaches."""

from dataclasses import dataclass, replace

import pytest

from plumbob.analytic.reference import Reference
from plumbob.analytic.theory import ErrorTheory
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.verdict import judge

SLOW, BARRIER = "simple-pendulum/rotating-slow", "cone-pendulum/above-barrier-1e-6"


@dataclass(frozen=True)
class Altered:
    """An `ErrorTheory` that only steps, and whose predictions are altered."""

    theory: ErrorTheory
    exact: Reference
    sign: float
    late: float  # [steps]

    def series(self, scheme, times):
        """Empty."""
        return {}

    def at_step(self, scheme, step, times):
        """The prediction with this sign, for so many steps later."""
        later = times + self.late * step
        stepped = self.theory.at_step(scheme, step, later)
        here = self.exact.observe(times)
        there = self.exact.observe(later)
        errors = {n: self.sign * e + there[n] - here[n] for n, e in stepped.errors.items()}
        return replace(stepped, errors=errors)


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(
    ("sign", "late", "wanted"),
    [(1.0, 0.0, "predicted"), (-1.0, 0.0, "off-prediction"), (1.0, 1.0, "off-prediction")],
)
@pytest.mark.parametrize(
    ("name", "method", "step"),
    [
        (SLOW, "mujoco/euler", 1e-2),
        (SLOW, "pymunk/default", 1e-2),
        (SLOW, "ode/rk4", 1e-2),  # where the series reaches the step, both agree
        (BARRIER, "ode/leapfrog", 1e-3),
        ("linear-pendulum/forced-large", "mujoco/discrete", 1e-3),
    ],
)
def test_a_prediction(name, method, step, sign, late, wanted):
    case = case_of(scene(name))
    how = find_method(method)
    case = replace(case, errors=Altered(case.errors, case.reference, sign, late))
    assert judge(measure(case, how, step)[0], case.system, how).verdict == wanted
