"""ODE solvers as an engine: scenes as equations of motion, with three fixed-step integrators and
three of scipy's adaptive ones."""

from __future__ import annotations

from plumbob.analytic.schemes import ADAPTIVE, EULER, LEAPFROG, RK4, Scheme
from plumbob.engines.abilities import OwnDerivative, SecondRun
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Engine, Method
from plumbob.models.scene import FREE_ROTATION, ONE_SMOOTH, SMOOTH, later

# relative; of order 5 and implicit, Radau takes seconds for its tenth digit of a swing
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 14))
# dry friction has no equation of motion that they could follow
KINDS = (ONE_SMOOTH, SMOOTH, FREE_ROTATION)
IMPACTS = ("bouncing-ball",)  # but an impact ends a step of a solver that chooses them
prepare = later(f"{__name__}.simulation.prepared")


def confirming(method: Method) -> tuple[Method, float]:
    """The solver of the highest order at the smallest tolerance that scipy takes."""
    from plumbob.engines.adapters.ode.simulation import SMALLEST

    return next(m for m in METHODS if m.settings.get("method") == "DOP853"), SMALLEST


def _adaptive(solver: str, tolerances: tuple[float, ...]) -> Method:
    name = f"ode/{solver.lower()}"
    settings = {"method": solver}
    return Method(
        name, Scheme(ADAPTIVE), None, "tolerance", settings, tolerances, IMPACTS, kinds=KINDS
    )


METHODS = (
    Method("ode/euler", Scheme(EULER), 1, kinds=KINDS),
    Method("ode/leapfrog", Scheme(LEAPFROG), 2, kinds=KINDS),
    Method("ode/rk4", Scheme(RK4), 4, kinds=KINDS),
    _adaptive("DOP853", TOLERANCES),
    _adaptive("Radau", TOLERANCES[:5]),
    _adaptive("LSODA", TOLERANCES),
)
ENGINE = Engine(
    "ode",
    "scipy",
    METHODS,
    prepare,
    no_error,
    abilities=(
        SecondRun(confirming),
        OwnDerivative("variational", later(f"{__name__}.forward.forward")),
    ),
)
