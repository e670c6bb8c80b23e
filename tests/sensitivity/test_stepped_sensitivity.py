"""Small mistakes at steps that no series reaches fail the verdict, as they do at small steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest

from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.theory import Coefficients, ErrorTheory, SteppedErrors
from plumbob.engines.method import Method, meant
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of as case_of_scene
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case
from plumbob.reports.judge.verdict import judge

SLOW, TOP = "simple-pendulum/rotating-slow", "simple-pendulum/near-top-1e-6"
DAMPED, BARRIER = "simple-pendulum/damped-rotating", "cone-pendulum/above-barrier-1e-6"


def case_of(name: str, **changes: float) -> Case:
    """A scene's case with some parameters multiplied by these."""
    given = find_scene(name)
    wrong = {n: given.parameters[n] * factor for n, factor in changes.items()}
    return case_of_scene(find_scene(name, wrong))


def verdict(name: str, method: Method, step: float, **changes: float) -> str:
    """The verdict on an engine that runs a scene with changed parameters."""
    right = case_of(name)
    case = replace(case_of(name, **changes), reference=right.reference, errors=right.errors)
    found, _ = measure(case, method, step)
    predicted = found.errors["theta"].predicted
    assert predicted is not None
    if name != TOP:  # there a series reaches the scene's largest step
        assert predicted.uncertainty is not None
    return judge(found, case.system, method).verdict


def fixed_steps(name: str) -> list[Method]:
    """The methods with fixed steps that are meant for a scene."""
    scene = find_scene(name)
    return [
        m
        for m in find_methods("*")
        if m.control == "step" and meant(m, scene) and not engine_of(m).optional
    ]


@pytest.mark.long(keep=4)
@pytest.mark.parametrize("step", [1e-1, 5e-2])
@pytest.mark.parametrize("method", fixed_steps(SLOW), ids=lambda m: m.name)
def test_gravity_off_by_a_hundredth_next_to_the_separatrix(method: Method, step: float) -> None:
    if method.order == 4 and step < 0.1:
        return  # the series reaches it
    assert verdict(SLOW, method, step) == "predicted"
    assert verdict(SLOW, method, step, gravity=1.01) == "off-prediction"


@pytest.mark.parametrize("method", fixed_steps(TOP), ids=lambda m: m.name)
def test_gravity_off_by_a_hundredth_next_to_the_top(method: Method) -> None:
    step = 0.2 if method.order == 4 else 2e-2
    assert verdict(TOP, method, step) == "predicted"
    assert verdict(TOP, method, step, gravity=1.01) == "off-prediction"


@pytest.mark.long(keep=3)
@pytest.mark.parametrize(
    ("name", "method", "step", "parameter", "off"),
    [
        (SLOW, "mujoco/euler", 1e-2, "gravity", 1e-9),
        (SLOW, "ode/leapfrog", 2e-2, "gravity", 1e-9),
        (SLOW, "ode/rk4", 1e-1, "gravity", 1e-9),
        (SLOW, "pymunk/tight", 5e-3, "gravity", 1e-8),  # what its impulses round to is larger
        (BARRIER, "mujoco/euler", 1e-3, "gravity", 1e-8),  # for 1.5 s, by a hundredth of the force
        (BARRIER, "ode/euler", 1e-3, "platform_rate", 1e-9),
        (DAMPED, "mujoco/euler", 2e-2, "damping_rate", 1e-6),
        (DAMPED, "ode/euler", 2e-2, "damping_rate", 1e-6),
        (DAMPED, "pymunk/default", 1e-2, "damping_rate", 1e-6),
    ],
)
def test_a_parameter(name: str, method: str, step: float, parameter: str, off: float) -> None:
    how = find_method(method)
    assert verdict(name, how, step) == "predicted"
    assert verdict(name, how, step, **{parameter: 1.0 + off}) == "off-prediction"


@dataclass(frozen=True)
class Altered:
    """An `ErrorTheory` that only steps, and whose predictions are altered."""

    theory: ErrorTheory
    exact: Reference
    change: Callable[[ErrorTheory, Reference, Scheme, float, Array], SteppedErrors]

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Empty."""
        return {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """The altered prediction."""
        return self.change(self.theory, self.exact, scheme, step, times)


def as_it_is(
    theory: ErrorTheory, exact: Reference, scheme: Scheme, step: float, times: Array
) -> SteppedErrors:
    """What theory predicts."""
    return theory.at_step(scheme, step, times)


def flipped(
    theory: ErrorTheory, exact: Reference, scheme: Scheme, step: float, times: Array
) -> SteppedErrors:
    """The same with the other sign."""
    found = theory.at_step(scheme, step, times)
    return replace(found, errors={name: -error for name, error in found.errors.items()})


def late(
    theory: ErrorTheory, exact: Reference, scheme: Scheme, step: float, times: Array
) -> SteppedErrors:
    """What is predicted for one step later."""
    found = theory.at_step(scheme, step, times + step)
    here, there = exact.observe(times), exact.observe(times + step)
    return replace(found, errors={n: e + there[n] - here[n] for n, e in found.errors.items()})


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(
    ("change", "wanted"),
    [(as_it_is, "predicted"), (flipped, "off-prediction"), (late, "off-prediction")],
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
def test_a_prediction(
    name: str,
    method: str,
    step: float,
    change: Callable[[ErrorTheory, Reference, Scheme, float, Array], SteppedErrors],
    wanted: str,
) -> None:
    case, how = case_of(name), find_method(method)
    case = replace(case, errors=Altered(case.errors, case.reference, change))
    found, _ = measure(case, how, step)
    assert judge(found, case.system, how).verdict == wanted
