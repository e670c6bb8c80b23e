"""The methods that pymunk offers: its one integrator, joints as they come or closed tightly, and
what stands for the capsule's supports."""

from __future__ import annotations

import math
from dataclasses import replace

from plumbob.analytic.errors.schemes import EULER, Scheme
from plumbob.engines.adapters.pymunk.capsule_methods import CAPSULE
from plumbob.engines.method import Method

# Moves first, then solves the velocities. With default settings a joint closes at a rate of 6.3/s:
# it stays open by some h w^2 L / 13, which lengthens the rod and takes energy. With error_bias 0 it
# closes in one step (analytic/errors/jointed_euler.py has both).
EULER_STEP = Scheme(EULER, position_first=True)
CLOSING_RATE = -60.0 * math.log(0.9)  # [1/s], from the default error_bias (1 - 0.1)^60
SYSTEMS = ("simple-pendulum",)
METHODS = (
    Method(
        "pymunk/default", replace(EULER_STEP, joint_closing_rate=CLOSING_RATE), 1, systems=SYSTEMS
    ),
    Method(
        "pymunk/tight",
        replace(EULER_STEP, joint_closing_rate=math.inf),
        1,
        settings={"error_bias": 0.0},
        systems=SYSTEMS,
    ),
    # The linear pendulum is a body on a spring, with no joint to err: Euler's step and no more.
    Method("pymunk/spring", EULER_STEP, 1, systems=("linear-pendulum",)),
    *CAPSULE,
)
