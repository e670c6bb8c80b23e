"""The methods that pymunk offers: its one integrator, joints as they come or closed tightly, and
what stands for the capsule's supports."""

from __future__ import annotations

from plumbob.engines.adapters.pymunk.capsule_methods import CAPSULE
from plumbob.engines.method import Method

# Moves first, then solves the velocities. Left alone, a joint closes at a rate of 6.3/s: it stays
# open by some h w^2 L / 13, which lengthens the rod and takes energy. With error_bias 0 it closes
# in one step (analytic/stepping/jointed_euler.py has both).
SYSTEMS = ("simple-pendulum",)
METHODS = (
    Method("pymunk/default", "jointed-euler+drift", 1, systems=SYSTEMS),
    Method("pymunk/tight", "jointed-euler", 1, settings={"error_bias": 0.0}, systems=SYSTEMS),
    # The linear pendulum is a body on a spring, with no joint to err: Euler's step and no more.
    Method("pymunk/spring", "position-first-euler", 1, systems=("linear-pendulum",)),
    *CAPSULE,
)
