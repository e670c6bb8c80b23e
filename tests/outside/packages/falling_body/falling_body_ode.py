"""The falling body as an equation of motion, for the ODE solvers."""

from plumbob.engines.adapters.equation import Equation


def build(problem, method):
    """v' = g - c v, from rest at depth 0."""
    gravity = problem.gravity
    drag_rate = problem.drag_rate
    last = gravity / drag_rate
    return Equation(
        lambda time, depth, speed: gravity - drag_rate * speed,
        position=0.0,
        rate=0.0,
        speed=last,
        damping_rate=drag_rate,
        names=("depth",),
        rate_names=("speed",),
        size=last / drag_rate,
    )
