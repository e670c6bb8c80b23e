"""The slider of the capsule driven along its path, with its whole reaction on the body.

Chipmunk advances positions before it solves velocities, so a joint is set for the places at the end
of a step. On the body it is anchored where the slider then is: the two impulses are opposite and on
one line, and no momentum is made. On the slider its anchor offset equals the remaining position
error, which the joint turns into a velocity that closes it in one step.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator

import numpy as np

from plumbob.analytic.errors.sliding_motion.position_first import switches_on_grid
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.engines.adapters.pymunk.assembly import Assembly, vector
from plumbob.engines.adapters.pymunk.capsule_above import SetLimits

Act = Callable[[float], None]
Velocity = Callable[[Array], Array]
"""Slider's velocity in the body [m/s], body axes, shape (n, 2), at times [s], shape (n,)."""
BLOCK = 1024  # steps whose targets are computed at once


def on_the_line(setup: CapsuleSetup) -> Velocity | None:
    """Velocity of the slider on its line, or None where it does not move."""
    if (velocity := setup.relative_velocity) is None:
        return None
    unit = np.array([math.cos(setup.direction), math.sin(setup.direction)])
    return lambda times: np.asarray(velocity(times)[:, None] * unit)


def on_an_axis(velocity: Callable[[Array], Array]) -> Velocity:
    """The same with x along the line."""
    return lambda times: np.asarray(velocity(times)[:, None] * np.array([1.0, 0.0]))


def velocity_targets(
    velocity: Velocity, start: tuple[float, float], step: float
) -> Iterator[tuple[float, float]]:
    """Targets in the body [m, from C] at the end of the first step, of the second and so on: left
    Riemann sums of velocity, half a step late, which make it exact at every grid time."""
    here: Array = np.array(start, dtype=np.float64)
    first = 0
    while True:
        times = np.arange(first, first + BLOCK, dtype=np.float64) * step
        places: Array = here + np.cumsum(step * velocity(times), axis=0)
        yield from zip(*places.T.tolist(), strict=True)
        here, first = places[-1], first + BLOCK


def plane_targets(
    path: SliderPath, setup: CapsuleSetup, step: float
) -> Iterator[tuple[float, float]]:
    """Targets for a `path` in the plane: where its acceleration jumps on the grid alone, positions
    less half a step of the velocity, which do not drift turn after turn; else left sums."""
    place, velocity = setup.plane_place, setup.plane_velocity
    assert place is not None
    assert velocity is not None
    if not switches_on_grid(path, step):
        yield from velocity_targets(velocity, setup.slider, step)
    first = 1
    while True:
        times = np.arange(first, first + BLOCK, dtype=np.float64) * step
        places = place(times) - 0.5 * step * velocity(times)
        yield from zip(*places.T.tolist(), strict=True)
        first += BLOCK


def driven(
    assembly: Assembly, targets: Iterator[tuple[float, float]], step: float, set_limits: SetLimits
) -> Act:
    """Function to call before each step of `step` [s], for any path and a body that turns: computes
    where body and slider will be, and gives the slider's place from C to `set_limits`."""
    next(targets)
    body, slider, joint = assembly.body, assembly.slider, assembly.joint

    def act(time: float) -> None:
        turn = cmath.rect(1.0, body.angle + step * body.angular_velocity)
        arm = complex(*slider.position) - complex(*body.position)
        arm += step * (complex(*slider.velocity) - complex(*body.velocity))
        anchor = arm * turn.conjugate()
        joint.anchor_a = vector(anchor)
        place = anchor - assembly.centre
        joint.anchor_b = vector((place - complex(*next(targets))) * turn)
        set_limits(*vector(place))

    return act


def driven_along(
    assembly: Assembly,
    targets: Iterator[tuple[float, float]],
    heading: float,
    set_limits: SetLimits,
) -> Act:
    """The same for a body that keeps its `heading` [rad]: the slider will be at its last target,
    and no state is read. On a turn it would be beside that place, and make a torque."""
    joint = assembly.joint
    cx, cy = vector(assembly.centre)
    c, s = math.cos(heading), math.sin(heading)
    bx, by = next(targets)

    def act(time: float) -> None:
        nonlocal bx, by
        ax, ay = next(targets)
        dx, dy = bx - ax, by - ay
        joint.anchor_a = bx + cx, by + cy
        joint.anchor_b = c * dx - s * dy, s * dx + c * dy
        set_limits(bx, by)
        bx, by = ax, ay

    return act


def no_limits(x: float, y: float) -> None:
    """Sets nothing: contacts have their own normal forces."""
