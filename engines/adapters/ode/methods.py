"""The integrators of equations of motion: three with fixed steps, three of scipy's that adapt."""

from __future__ import annotations

from plumbob.engines.method import Method

# relative; of order 5 and implicit, Radau takes seconds for its tenth digit of a swing
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 14))

SMOOTH = ("*-pendulum",)  # dry friction has no equation of motion that they could follow


def _adaptive(scipys: str, step_sizes: tuple[float, ...]) -> Method:
    name = f"ode/{scipys.lower()}"
    return Method(name, "adaptive", None, "tolerance", {"method": scipys}, step_sizes, SMOOTH)


METHODS = (
    Method("ode/euler", "semi-implicit-euler", 1, systems=SMOOTH),
    Method("ode/leapfrog", "leapfrog", 2, systems=SMOOTH),
    Method("ode/rk4", "rk4", 4, systems=SMOOTH),
    _adaptive("DOP853", TOLERANCES),
    _adaptive("Radau", TOLERANCES[:5]),
    _adaptive("LSODA", TOLERANCES),
)
