"""The integrators of equations of motion: three with fixed steps, three of scipy's that adapt."""

from __future__ import annotations

from plumbob.analytic.errors.schemes import ADAPTIVE, EULER, LEAPFROG, RK4, Scheme
from plumbob.engines.method import Method

# relative; of order 5 and implicit, Radau takes seconds for its tenth digit of a swing
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 14))

SMOOTH = ("*-pendulum",)  # dry friction has no equation of motion that they could follow


def _adaptive(scipys: str, step_sizes: tuple[float, ...]) -> Method:
    name = f"ode/{scipys.lower()}"
    return Method(name, Scheme(ADAPTIVE), None, "tolerance", {"method": scipys}, step_sizes, SMOOTH)


METHODS = (
    Method("ode/euler", Scheme(EULER), 1, systems=SMOOTH),
    Method("ode/leapfrog", Scheme(LEAPFROG), 2, systems=SMOOTH),
    Method("ode/rk4", Scheme(RK4), 4, systems=SMOOTH),
    _adaptive("DOP853", TOLERANCES),
    _adaptive("Radau", TOLERANCES[:5]),
    _adaptive("LSODA", TOLERANCES),
)
