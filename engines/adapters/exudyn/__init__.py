"""Exudyn as an engine: kinematic trees and rigid bodies under its implicit generalised-alpha
solver, which is its default, and two of its explicit Runge-Kutta methods.

Only the implicit solver has loops, contacts, and prescribed velocities that change. Exudyn is
imported when a function of the other modules is called.
"""

from __future__ import annotations

from plumbob.analytic.schemes import RK4, Scheme
from plumbob.engines.abilities import SchemeOfCase
from plumbob.engines.method import Engine, Method, Simulation, no_error
from plumbob.models.scene import ON_PLANE, ONE_SMOOTH, SMOOTH, Case

ALPHA = Scheme("generalised alpha")
RK4_OF_TURNS = Scheme("rk4 of rotation vectors")  # scheme that no theory here covers
# On these scenes the errors of the method of order 6 are above round-off for four octaves of steps.
# On other scenes they are for two or three octaves, too few for a verdict that claims an order.
RESOLVED = ("linear-pendulum/free-large", "linear-pendulum/forced-large")
# Near a separatrix, a method without a predicted error cannot show to which side the motion goes.
AWAY_FROM_SADDLES = ("!cone-pendulum/*-barrier-*",)
# A projectile has a constant acceleration, which the solver integrates exactly: its error is
# rounding, which has no order.
WITH_AN_ERROR = (
    "!projectile",
    # A joint without damping under a held torque has a constant acceleration, too. The one scene
    # with damping is left to RK44, whose errors are predicted.
    "!servo/held-*",
)
# Near a singular configuration of a loop, Newton's method does not reach a tolerance of 1e-13.
SINGULAR = ("!four-bar/near-change-point", "!slider-crank/nearly-singular")
TURNS = ("free-body/flip", "free-body/symmetric")
CAPSULES = (  # one or two scenes of each system
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
        systems=(*AWAY_FROM_SADDLES, *WITH_AN_ERROR, *TURNS, *CAPSULES),
        kinds=(ONE_SMOOTH, SMOOTH, ON_PLANE),
    ),
    Method(
        "exudyn/alpha+tight",
        ALPHA,
        2,
        settings={"solver": "GeneralizedAlpha", "relativeTolerance": 1e-13},
        systems=(*AWAY_FROM_SADDLES, *WITH_AN_ERROR, "!rolling-disc", *SINGULAR, TURNS[0]),
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
    """The scheme of `method` on this case. A free body alone turns by rotation vectors: its RK4 is
    a scheme that no theory here covers."""
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
