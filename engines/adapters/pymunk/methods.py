"""The methods that pymunk offers: its one integrator, joints with default settings or closed in one
step, and three models of the capsule's supports."""

from __future__ import annotations

import math
from dataclasses import replace

from plumbob.analytic.errors.schemes import EULER, Scheme
from plumbob.engines.method import Method

# Moves first, then solves the velocities. With default settings a joint closes at a rate of 6.3/s:
# it stays open by some h w^2 L / 13, which lengthens the rod and takes energy. With error_bias 0 it
# closes in one step (analytic/errors/smooth_motion/jointed_euler.py has both).
EULER_STEP = Scheme(EULER, position_first=True)
CLOSING_RATE = -60.0 * math.log(0.9)  # [1/s], from the default error_bias (1 - 0.1)^60
SYSTEMS = ("simple-pendulum",)
# A line turned about stays a line, and the side view need not run every heading.
ONE_LINE = (
    *("capsule-line/[!h]*", "capsule-line/heavy-slider", "capsule-hold", "capsule-train"),
    "capsule-coast/translation",
)
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
    # The linear pendulum is a body on a spring, without a joint: Euler's step and no more.
    Method("pymunk/spring", EULER_STEP, 1, systems=("linear-pendulum",)),
    # No rotating platform in the plane: its moments about the axle are a torque, without a joint.
    Method("pymunk/torque", EULER_STEP, 1, settings={"torque": "within"}, systems=("cone-*",)),
    Method(
        "pymunk/feet",
        EULER_STEP,
        1,
        settings={"model": "feet", "iterations": 50},
        systems=("capsule-*",),
    ),
    Method(
        "pymunk/pivots",
        EULER_STEP,
        1,
        settings={"model": "pivots", "iterations": 50},
        systems=("capsule-*",),
    ),
    Method(
        "pymunk/side", EULER_STEP, 1, settings={"model": "side", "iterations": 30}, systems=ONE_LINE
    ),
)
