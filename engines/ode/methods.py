"""The integrators of equations of motion: three with fixed steps, three of scipy's that adapt."""

from __future__ import annotations

from engines.method import Method

# relative; of order 5 and implicit, Radau takes seconds for its tenth digit of a swing
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 14))

METHODS = (
    Method("ode/euler", "semi-implicit-euler", 1),
    Method("ode/leapfrog", "leapfrog", 2),
    Method("ode/rk4", "rk4", 4),
    Method("ode/dop853", "adaptive", None, "tolerance", {"method": "DOP853"}, TOLERANCES),
    Method("ode/radau", "adaptive", None, "tolerance", {"method": "Radau"}, TOLERANCES[:5]),
    Method("ode/lsoda", "adaptive", None, "tolerance", {"method": "LSODA"}, TOLERANCES),
)
