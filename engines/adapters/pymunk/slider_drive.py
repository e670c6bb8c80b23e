"""The slider of the capsule driven along its path, with its whole reaction on the body.

Chipmunk advances positions before it solves velocities, so a joint is set for the places at the end
of a step. On the body it is anchored where the slider then is: the two impulses are opposite and on
one line, and no momentum is made. On the slider its anchor offset equals the remaining position
error, which the joint turns into a velocity that closes it in one step.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from plumbob.analytic.errors.sliding_motion.position_first import switches_on_grid
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.adapters.pymunk.assembly import View
from plumbob.engines.adapters.pymunk.simulation import vector

# Steps whose targets are computed at once: sums of other blocks differ by rounding.
BLOCK = 4096


def targets(
    problem: CapsuleProblem, line: complex, start: complex, step: float
) -> Iterator[Any]:
    """Places x + iy of the slider in the body [m, from C] at the end of the first step, of the
    second and so on, on a `line`, or in the plane; from `start`.

    They are left Riemann sums of velocity, half a step late, which make it exact at every grid
    time. A path in the plane whose acceleration jumps on the grid alone has positions less half a
    step of the velocity, which do not drift turn after turn.
    """
    place = problem.setup.plane_place
    velocity = problem.setup.slider_velocity
    axes = np.array([line] if place is None else [1.0, 1.0j])
    if place is not None and switches_on_grid(problem.motion.path, step):

        def places(steps: Array, step: float) -> Array:
            times = (steps + 1.0) * step
            return np.asarray((place(times) - 0.5 * step * velocity(times)) @ axes)

    else:
        here = start

        def places(steps: Array, step: float) -> Array:
            nonlocal here
            summed = here + np.cumsum(step * (velocity(steps * step) @ axes))
            here = summed[-1]
            return np.asarray(summed)

    return _by_step(places, step)


def _by_step(rows: Callable[[Array, float], Array], step: float) -> Iterator[Any]:
    """The rows of steps of `step` [s], given their indices, one by one, without end."""
    first = 0.0
    while True:
        yield from rows(np.arange(first, first + BLOCK), step).tolist()
        first = first + BLOCK


def driven(
    view: View, places: Iterator[Any], step: float, turning: bool
) -> Callable[[float], None]:
    """Function to call before each step of `step` [s], on a way through `places`. Where the body is
    `turning`, computes where body and slider will be. Else the slider will be at its last target,
    and no state is read: on a turn it would be beside that place, and make a torque."""
    parts = view.assembly
    set_limits = view.set_limits
    here = next(places)
    body = parts.body
    slider = parts.slider
    joint = parts.joint
    centre = parts.centre
    turn = cmath.rect(1.0, body.angle)

    def act(time: float) -> None:
        nonlocal turn, here
        if turning:
            turn = cmath.rect(1.0, body.angle + step * body.angular_velocity)
            arm = complex(*slider.position) - complex(*body.position)
            arm += step * (complex(*slider.velocity) - complex(*body.velocity))
            here = arm * turn.conjugate() - centre
        joint.anchor_a = vector(here + centre)
        target = next(places)
        joint.anchor_b = vector((here - target) * turn)
        set_limits(here)
        here = target

    return act
