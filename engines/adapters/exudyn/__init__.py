"""Exudyn as an engine: kinematic trees and rigid bodies under its implicit generalised-alpha
solver, which is its default, and two of its explicit Runge-Kutta methods.

Every module imports Exudyn when it is called.
"""

from __future__ import annotations

from plumbob.analytic.schemes import RK4, Scheme
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Engine, Method
from plumbob.models.scene import ON_PLANE, ONE_SMOOTH, SMOOTH, later

# Of order 6, its error is at the round-off level after two or three octaves of steps: scenes that
# leave four. Elsewhere its verdict would be that nothing is claimed.
RESOLVED = ("linear-pendulum/free-large", "linear-pendulum/forced-large")
# Beside a separatrix no step of a method without theory shows to which side it goes.
AWAY_FROM_SADDLES = ("!cone-pendulum/*-barrier-*",)
METHODS = (
    Method(
        "exudyn/default",
        Scheme("generalised alpha"),
        2,
        settings={"solver": "GeneralizedAlpha"},
        systems=(*AWAY_FROM_SADDLES, "capsule-*", "free-body/flip", "free-body/symmetric"),
        kinds=(ONE_SMOOTH, SMOOTH, ON_PLANE),
    ),
    Method(
        "exudyn/alpha+tight",
        Scheme("generalised alpha"),
        2,
        settings={"solver": "GeneralizedAlpha", "relativeTolerance": 1e-13},
        systems=(*AWAY_FROM_SADDLES, "free-body/flip"),
        kinds=(ONE_SMOOTH, SMOOTH),
    ),
    Method(
        "exudyn/rk44",
        Scheme(RK4),
        4,
        settings={"solver": "RK44"},
        systems=("free-body/flip", "free-body/symmetric"),
        kinds=(ONE_SMOOTH, SMOOTH),
    ),
    Method(
        "exudyn/rk67",
        Scheme("runge-kutta of order 6"),
        6,
        settings={"solver": "RK67"},
        systems=RESOLVED,
    ),
)
ENGINE = Engine(
    "exudyn",
    "exudyn",
    METHODS,
    later(f"{__name__}.simulation.prepare"),
    no_error,
    optional=True,
)
