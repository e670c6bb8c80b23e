"""The integrators of equations of motion: three with fixed steps, three of scipy's that adapt."""

from __future__ import annotations

from engines.method import Method

METHODS = (
    Method("ode/euler", "semi-implicit-euler", 1),
    Method("ode/leapfrog", "leapfrog", 2),
    Method("ode/rk4", "rk4", 4),
    Method("ode/dop853", "adaptive", None, "tolerance", {"method": "DOP853"}),
    Method("ode/radau", "adaptive", None, "tolerance", {"method": "Radau"}),
    Method("ode/lsoda", "adaptive", None, "tolerance", {"method": "LSODA"}),
)
