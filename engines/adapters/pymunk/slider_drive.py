"""Drives the capsule's slider along its path, with the whole reaction on the body.

Chipmunk advances positions before it solves for velocities, so the joint is set for the places at
the end of a step. On the body it is anchored where the slider will be: the two impulses are then
opposite and on one line, so that momentum is conserved. On the slider its anchor is displaced by
the remaining position error, which the joint turns into a velocity that closes it in one step."""

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

# Number of steps whose targets are computed at once. Another number changes the sums by rounding.
BLOCK = 4096


def targets(
    problem: CapsuleProblem, line: complex, start: complex, step: float
) -> Iterator[Any]:
    """Yields the places x + iy of the slider in the body, relative to C [m], at the ends of the
    steps, on a `line` or in the plane, from `start`.

    The places are left Riemann sums of the velocity: they lag by half a step, which makes the
    velocity exact at the ends of steps. If the acceleration of a path in the plane jumps only at
    ends of steps, the places are the path's places less half a step of the velocity, which do not
    drift from one turn to the next."""
    place = problem.setup.plane_place
    velocity = problem.setup.slider_velocity
    axes = np.array([line] if place is None else [1.0, 1.0j])
    if place is not None and switches_on_grid(problem.motion.path, step):

        def places(steps: Array, step: float) -> Array:
            """The places at the ends of steps with these numbers."""
            times = (steps + 1.0) * step
            return np.asarray((place(times) - 0.5 * step * velocity(times)) @ axes)

    else:
        last_place = start

        def places(steps: Array, step: float) -> Array:
            """The places at the ends of the steps with these numbers, which begin where the
            previous call ended."""
            nonlocal last_place
            sums = last_place + np.cumsum(step * (velocity(steps * step) @ axes))
            last_place = sums[-1]
            return np.asarray(sums)

    return _by_step(places, step)


def _by_step(rows: Callable[[Array, float], Array], step: float) -> Iterator[Any]:
    """Yields the rows of steps of `step` [s] one by one, without end. `rows` returns the rows of
    the steps with given indices."""
    first = 0.0
    while True:
        yield from rows(np.arange(first, first + BLOCK), step).tolist()
        first = first + BLOCK


def driven(
    view: View, places: Iterator[Any], step: float, turning: bool
) -> Callable[[float], None]:
    """A function to call before each step of `step` [s], which drives the slider through `places`.
    If the body is `turning`, the function computes where body and slider will be: the slider's last
    target would be beside that place, and make a torque. Otherwise the slider will be at its last
    target."""
    parts = view.assembly
    set_limits = view.set_limits
    place = next(places)  # place of the slider at the end of the last step, relative to C [m]
    body = parts.body
    slider = parts.slider
    joint = parts.joint
    centre = parts.centre
    turn = cmath.rect(1.0, body.angle)

    def act(time: float) -> None:
        """Moves the anchors of the slider's joint such that the next step brings the slider to its
        next target; the time is not used."""
        nonlocal turn, place
        if turning:
            turn = cmath.rect(1.0, body.angle + step * body.angular_velocity)
            arm = complex(*slider.position) - complex(*body.position)
            arm += step * (complex(*slider.velocity) - complex(*body.velocity))
            place = arm * turn.conjugate() - centre
        joint.anchor_a = vector(place + centre)
        target = next(places)
        joint.anchor_b = vector((place - target) * turn)
        set_limits(place)
        place = target

    return act
