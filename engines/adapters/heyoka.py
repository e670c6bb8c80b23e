"""heyoka as an engine: Taylor series whose order the tolerance chooses, compiled for each scene.

heyoka is optional. It integrates the same equations as the references, by independent code, and
shows how little a smooth scene can cost. It takes the equations of a free body, and those of any
system with a mass matrix and forces, as expressions."""

from __future__ import annotations

import operator
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.rotor.orbit import rotor_system
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import ADAPTIVE, Scheme
from plumbob.analytic.systems.free_body.equations import factors, slope
from plumbob.analytic.systems.free_body.rotation import ANGULAR_VELOCITY_NAMES, ATTITUDE
from plumbob.engines.abilities import SecondRun
from plumbob.engines.adapters.stepping import (
    Followed,
    FollowedSimulation,
    relative_tolerance,
)
from plumbob.engines.method import Engine, Method, Simulation, Unsupported, no_error
from plumbob.engines.sampling import MAX_SAMPLES
from plumbob.models.scene import FREE_ROTATION, ONE_SMOOTH, SMOOTH, Case

SMALLEST = ULP  # smallest relative tolerance
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 17, 2))
KINDS = (ONE_SMOOTH, SMOOTH, FREE_ROTATION)
METHODS = (
    Method(
        "heyoka/taylor",
        Scheme(ADAPTIVE),
        None,
        "tolerance",
        {},
        TOLERANCES,
        # An equation of motion has no controls that a digital controller could hold.
        systems=("!servo/held-*",),
        kinds=KINDS,
    ),
)


@dataclass(frozen=True)
class FirstOrderEquations:
    """Equations of motion of first order, for heyoka."""

    variables: tuple[str, ...]  # names of the variables of a state
    slopes: Callable[[Any, Sequence[Any]], Sequence[Any]]
    """Time, variables -> derivatives of the variables by time."""
    start: tuple[float, ...]
    observe: Callable[[Array], Signals]
    """States, shape (variables, samples) -> observables, shape (samples,) each."""


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compiles `case` at the relative tolerance `step`; raises Unsupported and ParameterError."""
    relative_tolerance(step, SMALLEST)
    begin = time.perf_counter()
    equations = _equations(case)
    import heyoka

    variables: Any = heyoka.make_vars(*equations.variables)
    terms = [_Term(variable) for variable in variables]
    slopes = [_expression(slope) for slope in equations.slopes(_Term(heyoka.time), terms)]
    # The compact mode compiles loops in a fraction of the time; they run half as fast.
    compact = case.system.kind == SMOOTH
    integrator = cast(Any, heyoka.taylor_adaptive)(
        list(zip(variables, slopes, strict=True)),
        list(equations.start),
        tol=step,
        compact_mode=compact,
    )
    seconds = time.perf_counter() - begin
    follow = partial(_follow, integrator, equations.start)
    return FollowedSimulation(follow, equations.observe, case.scene.duration, seconds)


def _follow(
    integrator: Any, start: tuple[float, ...], duration: float, samples: int
) -> Followed:
    """Integrates from the start over a duration [s]."""
    integrator.time, integrator.state[:] = 0.0, start
    times = np.linspace(0.0, duration, MAX_SAMPLES + 1)
    outcome, _, _, steps, *_, states = integrator.propagate_grid(times)
    finite = np.isfinite(states).all(axis=1)
    ended = "time_limit" in str(outcome) and bool(finite.all())
    # A Taylor step counts as many evaluations of the right-hand side as its order.
    evaluations = int(steps) * int(integrator.order)
    why = () if ended else (str(outcome),)
    return Followed(times[finite], states[finite].T, evaluations, ended, why)


def _equations(case: Case) -> FirstOrderEquations:
    """The equations of a case: of a free body, of a smooth system, or of the angle of a driven
    rotor. Raises Unsupported."""
    problem = getattr(case.problem, "started", case.problem)
    if case.system.name == "free-body":
        return _free_body_equations(problem)
    if case.system.kind == SMOOTH:
        return _smooth_equations(problem.motion.system)
    if case.system.loop(case.problem):
        raise Unsupported("its controls are fed back, and the equation has none")
    rotor = getattr(getattr(problem, "motion", None), "rotor", None)
    if rotor is None or getattr(case.problem, "saturates", False):
        raise Unsupported(
            f"heyoka has no builder for {case.system.name}: no driven rotor in one angle"
        )
    tilt = getattr(problem, "tilt", 0.0)  # direction from which the rotor's angle is measured
    system = rotor_system(rotor, problem.theta + tilt, problem.theta_dot)
    return _smooth_equations(system, tilt)


def _free_body_equations(problem: Any) -> FirstOrderEquations:
    """Euler's equations of a free body, and the rate of its attitude."""
    names = (*ANGULAR_VELOCITY_NAMES, *ATTITUDE)
    moments = factors(problem)
    return FirstOrderEquations(
        variables=names,
        slopes=lambda time, state: slope(moments, state),
        start=(*problem.angular_velocity, 1.0, 0.0, 0.0, 0.0),
        observe=lambda states: dict(zip(names, states, strict=True)),
    )


def _smooth_equations(system: SmoothSystem, tilt: float = 0.0) -> FirstOrderEquations:
    """The equations of a smooth system, whose observed coordinates are less by `tilt`."""
    half = len(system.rates)

    def slopes(time: Any, state: Sequence[Any]) -> Sequence[Any]:
        """The rates, followed by the accelerations."""
        q = state[:half]
        v = state[half:]
        return (*v, *system.acceleration(time, q, v, system.values))

    def observe(states: Array) -> Signals:
        """The observables of states."""
        return system.observed(np.concatenate([states[:half] - tilt, states[half:]]))

    variables = (*system.coordinates, *system.rates)
    return FirstOrderEquations(variables, slopes, tuple(system.start), observe)


class _Term(NDArrayOperatorsMixin):
    """A heyoka expression to which numpy's operators and functions can be applied."""

    def __init__(self, expression: Any) -> None:
        self.expression = expression

    def __array_ufunc__(
        self, function: Any, method: str, *inputs: Any, **options: Any
    ) -> _Term:
        import heyoka

        operators = {"subtract": "sub", "multiply": "mul", "divide": "truediv", "power": "pow"}
        operators["negative"] = "neg"
        name = function.__name__
        values = map(_expression, inputs)
        apply = getattr(operator, operators.get(name, name), None) or getattr(heyoka, name)
        return _Term(apply(*values))


def _expression(term: Any) -> Any:
    """The heyoka expression of a term; a number as it is."""
    return getattr(term, "expression", term)


def confirming(method: Method) -> tuple[Method, float]:
    """Returns the same method and its smallest tolerance."""
    return method, SMALLEST


ENGINE = Engine(
    "heyoka",
    "heyoka",
    METHODS,
    prepare,
    no_error,
    optional=True,
    abilities=(SecondRun(confirming),),
)
