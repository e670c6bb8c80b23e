"""ODE solvers as an engine: scenes as equations of motion, under three integrators with fixed steps
and three of scipy's adaptive solvers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plumbob.analytic.schemes import ADAPTIVE, EULER, LEAPFROG, RK4, Scheme
from plumbob.engines.abilities import OwnDerivative, SecondRun
from plumbob.engines.method import Engine, Method, Simulation, no_error
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import FREE_ROTATION, ONE_SMOOTH, SMOOTH, Case

if TYPE_CHECKING:
    from plumbob.models.gradient import Number

# Relative tolerances. Radau is implicit and of order 5: for the tenth digit of a swing it takes
# seconds, so that it is run at the first five tolerances alone.
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 14))
# Systems with dry friction are left out: they have no smooth equation of motion.
KINDS = (ONE_SMOOTH, SMOOTH, FREE_ROTATION)
# An equation of motion has no controls that a digital controller could hold.
CONTINUOUS = ("!servo/held-*",)
IMPACTS = ("bouncing-ball",)  # systems whose impacts end a step of an adaptive solver


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.ode.simulation import prepared

    return prepared(case, method, step)


def confirming(method: Method) -> tuple[Method, float]:
    """The method and the tolerance of a second run that confirms a first: the solver of the highest
    order at the smallest tolerance that scipy accepts."""
    from plumbob.engines.adapters.ode.simulation import SMALLEST

    (confirming_method,) = [
        candidate for candidate in METHODS if candidate.settings.get("method") == "DOP853"
    ]
    return confirming_method, SMALLEST


def _adaptive(solver: str, tolerances: tuple[float, ...]) -> Method:
    """The method of a solver of scipy at these relative tolerances."""
    return Method(
        f"ode/{solver.lower()}",
        Scheme(ADAPTIVE),
        order=None,
        control="tolerance",
        settings={"method": solver},
        step_sizes=tolerances,
        systems=(*CONTINUOUS, *IMPACTS),
        kinds=KINDS,
    )


METHODS = (
    Method("ode/euler", Scheme(EULER), 1, systems=CONTINUOUS, kinds=KINDS),
    Method("ode/leapfrog", Scheme(LEAPFROG), 2, systems=CONTINUOUS, kinds=KINDS),
    Method("ode/rk4", Scheme(RK4), 4, systems=CONTINUOUS, kinds=KINDS),
    _adaptive("DOP853", TOLERANCES),
    _adaptive("Radau", TOLERANCES[:5]),
    _adaptive("LSODA", TOLERANCES),
)


def _variational_derivatives(number: Number, method: Method, step: float) -> ByName:
    """Returns the derivatives of the observables at the end of a run; raises Unsupported."""
    from plumbob.engines.adapters.ode.forward import forward

    return forward(number, method, step)


ENGINE = Engine(
    "ode",
    "scipy",
    METHODS,
    prepare,
    no_error,
    abilities=(
        SecondRun(confirming),
        OwnDerivative("variational", _variational_derivatives),
    ),
)
