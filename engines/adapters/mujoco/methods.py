"""The methods of MuJoCo: its integrators with their schemes, alone and with contact settings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.method import ONE_LINE, Method
from plumbob.models.scene import (
    FREE_ROTATION,
    ON_PLANE,
    ON_SUPPORTS,
    ONE_SMOOTH,
    SMOOTH,
)

UNCOUPLED = (ONE_SMOOTH, FREE_ROTATION)
EVERY = (*UNCOUPLED, ON_SUPPORTS)
ALL = (*EVERY, SMOOTH, ON_PLANE)
DRIVEN = ("simple-pendulum/forced-*", "linear-pendulum/forced-*")
UNPLANNED = ("!capsule-plan",)  # plans show no more about contacts than short motions do
HELD = (*UNPLANNED, "pinch")
EULER_STEP = Scheme(EULER, "start", implicit_damping=True)
RK4_STEP = Scheme(RK4, "start")

# Without springs `implicitfast` and `discrete` take Euler's step bit for bit, and all of them treat
# a joint's damping implicitly. `implicit` adds the velocity derivative of the Coriolis forces,
# which has no effect on the swing of a body whose platform keeps its rate (see the tests).
# `discrete` also treats a joint's spring implicitly, which adds damping. A control is held over a
# step. If it is read at the start of the step, RK4 is of first order; if it is read at the middle,
# RK4 is of second order.
PLAIN = (
    Method("mujoco/euler", EULER_STEP, 1, settings={"integrator": "Euler"}, kinds=ALL),
    Method(
        "mujoco/implicit",
        EULER_STEP,
        1,
        settings={"integrator": "implicit"},
        kinds=UNCOUPLED,
    ),
    Method(
        "mujoco/implicitfast",
        EULER_STEP,
        1,
        settings={"integrator": "implicitfast"},
        kinds=EVERY,
    ),
    Method(
        "mujoco/discrete",
        replace(EULER_STEP, implicit_spring=True),
        1,
        settings={"integrator": "discrete"},
        kinds=UNCOUPLED,
    ),
    Method("mujoco/rk4", RK4_STEP, 4, settings={"integrator": "RK4"}, kinds=ALL),
    Method(
        "mujoco/euler+midpoint",
        replace(EULER_STEP, control="midpoint"),
        1,
        settings={"integrator": "Euler", "control_at": 0.5},
        systems=DRIVEN,
    ),
    Method(
        "mujoco/rk4+midpoint",
        replace(RK4_STEP, control="midpoint"),
        4,
        settings={"integrator": "RK4", "control_at": 0.5},
        systems=DRIVEN,
    ),
)


def _capsule(
    variant: str,
    integrator: str = "Euler",
    systems: tuple[str, ...] = (),
    surrogate: str = "",
    **settings: Any,
) -> Method:
    """A method for the capsule, or for the named systems, with one of MuJoCo's integrators and
    these settings, called "mujoco/<integrator>+<variant>"."""
    scheme, order = (RK4_STEP, 4) if integrator == "RK4" else (EULER_STEP, 1)
    return Method(
        f"mujoco/{integrator.lower()}+{variant}",
        replace(scheme, control="mean"),
        order,
        settings={"integrator": integrator, **settings},
        systems=systems,
        kinds=() if surrogate else (ON_SUPPORTS,),
        surrogate=surrogate,
    )


# On scenes of the capsule, a method that names no contacts has MuJoCo's default contacts, and every
# method is given the mean of the control over each step.
_REDUCED = "a body on a rail: friction is a joint's, and there are no contacts"
_TALL = "a body of another height"
METHODS = (
    *PLAIN,
    Method(
        "mujoco/euler+stiff",
        EULER_STEP,
        1,
        settings={"integrator": "Euler", "contact": "stiff"},
        systems=("stack",),
    ),
    _capsule("pyramidal", systems=HELD, contact="pyramidal"),
    _capsule("elliptic", systems=HELD, contact="elliptic"),
    _capsule("elliptic+noslip", systems=HELD, contact="elliptic+noslip"),
    _capsule(
        "coulomb",
        systems=("rolling-ball", "incline", "pinch", "rod-impact", "rolling-disc"),
        contact="coulomb",
    ),
    _capsule("coulomb+noslip", systems=UNPLANNED, contact="coulomb+noslip"),
    _capsule("coulomb", "implicitfast", UNPLANNED, contact="coulomb"),
    _capsule("coulomb", "RK4", contact="coulomb"),
    _capsule("reduced", systems=ONE_LINE, surrogate=_REDUCED, model="reduced"),
    _capsule("reduced", "RK4", systems=ONE_LINE, surrogate=_REDUCED, model="reduced"),
    _capsule(
        "tall", systems=("capsule-line/at-*",), surrogate=_TALL, contact="coulomb", height=0.05
    ),
)
