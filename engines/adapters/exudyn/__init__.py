"""Exudyn as an engine: kinematic trees and rigid bodies under its implicit generalised-alpha
solver, which is its default, and two of its explicit Runge-Kutta methods.

Loops, changing motions and contacts are the implicit solver's alone. Every module imports Exudyn
when it is called.
"""

from __future__ import annotations

from plumbob.analytic.schemes import RK4, Scheme
from plumbob.engines.abilities import SchemeOfCase
from plumbob.engines.adapters.stepping import no_error
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import ON_PLANE, ONE_SMOOTH, SMOOTH, Case

ALPHA = Scheme("generalised alpha")
RK4_OF_TURNS = Scheme("rk4 of rotation vectors")  # no theory here covers it
# Scenes on which the method of order 6 has four octaves of steps above round-off. Elsewhere it has
# two or three, and its verdict would be that nothing is claimed.
RESOLVED = ("linear-pendulum/free-large", "linear-pendulum/forced-large")
# Beside a separatrix no step of a method without theory shows to which side it goes.
AWAY_FROM_SADDLES = ("!cone-pendulum/*-barrier-*",)
# A constant acceleration leaves it no error of a step: rounding alone, of which no order follows.
WITH_AN_ERROR = "!projectile"
# A tolerance of 1e-13 is not reached where a loop is nearly singular.
SINGULAR = ("!four-bar/near-change-point", "!slider-crank/nearly-singular")
TURNS = ("free-body/flip", "free-body/symmetric")
CAPSULES = (  # a scene or two of each system
    *("capsule-line/heading-030", "capsule-coast/spin", "capsule-coast/edge"),
    *(
        "capsule-hold/0.999",
        "capsule-plan/near-free",
        "capsule-turn/0.3",
        "capsule-train/ten",
    ),
)
METHODS = (
    Method(
        "exudyn/default",
        ALPHA,
        2,
        settings={"solver": "GeneralizedAlpha"},
        systems=(*AWAY_FROM_SADDLES, WITH_AN_ERROR, *TURNS, *CAPSULES),
        kinds=(ONE_SMOOTH, SMOOTH, ON_PLANE),
    ),
    Method(
        "exudyn/alpha+tight",
        ALPHA,
        2,
        settings={"solver": "GeneralizedAlpha", "relativeTolerance": 1e-13},
        systems=(*AWAY_FROM_SADDLES, WITH_AN_ERROR, "!rolling-disc", *SINGULAR, TURNS[0]),
        kinds=(ONE_SMOOTH, SMOOTH),
    ),
    Method(
        "exudyn/rk44",
        Scheme(RK4),
        4,
        settings={"solver": "RK44"},
        systems=("!rolling-disc", "!four-bar", "!slider-crank", *TURNS),
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


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on this case; a free body by itself turns by rotation vectors."""
    if case.system.name == "free-body" and method.scheme.known:
        return RK4_OF_TURNS
    return method.scheme


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.exudyn.simulation import prepare

    return prepare(case, method, step)


ENGINE = Engine(
    "exudyn",
    "exudyn",
    METHODS,
    prepare,
    no_error,
    optional=True,
    abilities=(SchemeOfCase(scheme),),
)
