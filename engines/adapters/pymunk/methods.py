"""The methods that pymunk offers: its one integrator, joints with default settings or closed in one
step, and three models of the capsule's supports."""

from __future__ import annotations

from plumbob.engines.method import Method

# Moves first, then solves the velocities. With default settings a joint closes at a rate of 6.3/s:
# it stays open by some h w^2 L / 13, which lengthens the rod and takes energy. With error_bias 0 it
# closes in one step (analytic/errors/joint_step.py has both).
SYSTEMS = ("simple-pendulum",)
CAPSULE = "semi-implicit-euler+position-first"
# A line turned about stays a line, and the side view need not run every heading.
ONE_LINE = (
    *("capsule-line/[!h]*", "capsule-line/heavy-slider", "capsule-hold", "capsule-train"),
    "capsule-coast/translation",
)
METHODS = (
    Method("pymunk/default", "jointed-euler+drift", 1, systems=SYSTEMS),
    Method("pymunk/tight", "jointed-euler", 1, settings={"error_bias": 0.0}, systems=SYSTEMS),
    # The linear pendulum is a body on a spring, without a joint: Euler's step and no more.
    Method("pymunk/spring", "position-first-euler", 1, systems=("linear-pendulum",)),
    Method(
        "pymunk/feet",
        CAPSULE,
        1,
        settings={"model": "feet", "iterations": 50},
        systems=("capsule-*",),
    ),
    Method(
        "pymunk/pivots",
        CAPSULE,
        1,
        settings={"model": "pivots", "iterations": 50},
        systems=("capsule-*",),
    ),
    Method(
        "pymunk/side", CAPSULE, 1, settings={"model": "side", "iterations": 30}, systems=ONE_LINE
    ),
)
