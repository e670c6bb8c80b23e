"""The methods of pymunk: its integrator with joints that close slowly, by default, or in one step;
and three models of the capsule's supports."""

from __future__ import annotations

import math
from dataclasses import replace

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.method import ONE_LINE, Method
from plumbob.models.scene import ON_PLANE, ON_SUPPORTS, SMOOTH

# A step moves bodies first, then solves for velocities. With default settings a joint closes at a
# rate of 6.3/s: it stays open by about h w^2 L / 13, which lengthens the rod and takes energy. With
# error_bias 0 it closes in one step. analytic/errors/smooth_motion/stepped_rotor.py has both.
EULER_STEP = Scheme(EULER, position_first=True)
# [1/s] rate at which joints close by default: pymunk's error_bias is (1 - 0.1)^60, in single
# precision
CLOSING_RATE = -60.0 * math.log(0.899999976158142)
# Smooth systems that are linkages in the plane
SYSTEMS = ("simple-pendulum", "!heavy-top", "!rolling-disc", "!projectile")
# Moment of inertia of a point mass, as a fraction of m L^2: pymunk needs one above zero. The rod is
# shortened to balance its effect on the swing. A smaller one costs digits in the joint's equations:
# with 1e-12 and one iteration of the solver the bob flies off.
MOMENT = 1e-7
# [s] time for which a floor is long enough: no body reaches its ends earlier
FLOOR_TIME = 60.0
JOINTED = replace(EULER_STEP, joint_closing_rate=CLOSING_RATE, jointed_moment=MOMENT)
ABOVE = "seen from above: statics gives the support forces, and no contact"
SIDE = "seen from the side: a body that moves along a line"
METHODS = (
    Method("pymunk/default", JOINTED, 1, systems=SYSTEMS, kinds=(SMOOTH,)),
    Method(
        "pymunk/tight",
        replace(JOINTED, joint_closing_rate=math.inf),
        1,
        settings={"error_bias": 0.0},
        systems=SYSTEMS,
        kinds=(SMOOTH,),
    ),
    # The linear pendulum is a body on a spring, without a joint: its step is Euler's alone.
    Method("pymunk/spring", EULER_STEP, 1, systems=("linear-pendulum", "servo")),
    Method("pymunk/contact", EULER_STEP, 1, systems=("projectile",), kinds=(ON_PLANE,)),
    # There is no rotating platform in the plane: its moments about the axle are applied as a
    # torque.
    Method("pymunk/torque", EULER_STEP, 1, systems=("cone-pendulum",)),
    *(
        Method(
            f"pymunk/{model}",
            EULER_STEP,
            1,
            settings={"model": model, "iterations": 50},
            kinds=(ON_SUPPORTS,),
            surrogate=ABOVE,
        )
        for model in ("feet", "pivots")
    ),
    Method(
        "pymunk/side",
        EULER_STEP,
        1,
        settings={"model": "side", "iterations": 30},
        systems=ONE_LINE,
        surrogate=SIDE,
    ),
)
