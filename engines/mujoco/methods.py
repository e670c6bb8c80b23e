"""The methods that MuJoCo offers: its integrators, each with what its step is in theory."""

from __future__ import annotations

from engines.method import Method

EULER = "semi-implicit-euler"

# Without joint damping and springs `implicitfast` and `discrete` take Euler's step bit for bit;
# `implicit` adds the velocity derivative of the Coriolis forces, which has no share in the swing
# of a body whose platform keeps its rate (see the tests).
METHODS = (
    Method("mujoco/euler", EULER, 1, settings={"integrator": "Euler"}),
    Method("mujoco/implicit", EULER, 1, settings={"integrator": "implicit"}),
    Method("mujoco/implicitfast", EULER, 1, settings={"integrator": "implicitfast"}),
    Method("mujoco/discrete", EULER, 1, settings={"integrator": "discrete"}),
    Method("mujoco/rk4", "rk4", 4, settings={"integrator": "RK4"}),
)
