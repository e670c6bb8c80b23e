"""The methods that MuJoCo offers: its integrators, each with what its step is in theory."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.method import Method
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, ON_SUPPORTS, ONE_SMOOTH, SMOOTH
from plumbob.models.tripod_capsule.parameters import ONE_LINE

UNCOUPLED = (ONE_SMOOTH, FREE_ROTATION)
EVERY = (*UNCOUPLED, ON_SUPPORTS)
ALL = (*EVERY, SMOOTH, ON_PLANE)
DRIVEN = ("simple-pendulum/forced-*", "linear-pendulum/forced-*")
UNPLANNED = ("!capsule-plan",)  # plans show no more of contacts than short motions
HELD = (*UNPLANNED, "pinch")
EULER_STEP = Scheme(EULER, "start", implicit_damping=True)
RK4_STEP = Scheme(RK4, "start")

# Without springs `implicitfast` and `discrete` take Euler's step bit for bit, and all treat a
# joint's damping implicitly; `implicit` adds the velocity derivative of the Coriolis forces, which
# has no effect on the swing of a body whose platform keeps its rate (see the tests). `discrete`
# treats a joint's spring implicitly too, and so adds damping.
# A control is held over a step: read at its start, it leaves RK4 of first order, and read at its
# middle of second. Where nothing is controlled, the two are the same.
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


# In scenes of the capsule, methods that name no contacts have MuJoCo's default ones. Every method
# is given the control's mean over each step there.
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
