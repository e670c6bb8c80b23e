"""The methods that MuJoCo offers: its integrators, each with what its step is in theory."""

from __future__ import annotations

from engines.method import Method

EULER = "semi-implicit-euler+implicit-damping"
RK4 = "rk4"

# Without springs `implicitfast` and `discrete` take Euler's step bit for bit, and all treat a
# joint's damping implicitly; `implicit` adds the velocity derivative of the Coriolis forces, which
# has no share in the swing of a body whose platform keeps its rate (see the tests). `discrete`
# treats a joint's spring implicitly too, and so damps what it should not.
# A control is held over a step: read at its start, it leaves RK4 of first order, and read at its
# middle of second. Where nothing is controlled, the two are the same.
METHODS = (
    Method("mujoco/euler", f"{EULER}+start-control", 1, settings={"integrator": "Euler"}),
    Method("mujoco/implicit", f"{EULER}+start-control", 1, settings={"integrator": "implicit"}),
    Method(
        "mujoco/implicitfast", f"{EULER}+start-control", 1, settings={"integrator": "implicitfast"}
    ),
    Method(
        "mujoco/discrete",
        f"{EULER}+implicit-spring+start-control",
        1,
        settings={"integrator": "discrete"},
    ),
    Method("mujoco/rk4", f"{RK4}+start-control", 4, settings={"integrator": "RK4"}),
    Method(
        "mujoco/euler+midpoint",
        f"{EULER}+midpoint-control",
        1,
        settings={"integrator": "Euler", "control_at": 0.5},
    ),
    Method(
        "mujoco/rk4+midpoint",
        f"{RK4}+midpoint-control",
        4,
        settings={"integrator": "RK4", "control_at": 0.5},
    ),
)
