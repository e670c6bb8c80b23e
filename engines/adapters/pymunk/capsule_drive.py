"""The slider of the capsule driven along its path, with its whole reaction on the body.

Bodies advance before velocities are solved, so a joint is set for the places at the end of a step.
It takes hold of the body where the slider then is: their impulses are opposite and on one line, and
no momentum is made. It takes hold of the slider as far from it as it is from its aim, which closing
in one step makes its velocity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from plumbob.analytic.errors.position_first import switches_on_grid
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.engines.adapters.pymunk.capsule_space import Assembly, Tell, point

Act = Callable[[float], None]
Velocity = Callable[[Array], Array]
"""Slider's velocity in the body [m/s], body axes, shape (n, 2), at times [s], shape (n,)."""
BLOCK = 1024  # steps whose aims are worked out at once


def on_the_line(setup: CapsuleSetup) -> Velocity | None:
    """Velocity of the slider on its line, or None where it stays put."""
    if (velocity := setup.relative_velocity) is None:
        return None
    unit = np.array([math.cos(setup.direction), math.sin(setup.direction)])
    return lambda times: np.asarray(velocity(times)[:, None] * unit)


def on_an_axis(velocity: Callable[[Array], Array]) -> Velocity:
    """The same with x along the line."""
    return lambda times: np.asarray(velocity(times)[:, None] * np.array([1.0, 0.0]))


def aims(
    velocity: Velocity, start: tuple[float, float], step: float
) -> Iterator[tuple[float, float]]:
    """Places in the body [m, from C] at the end of the first step, of the second and so on: left
    sums of the velocity, which keep half a step behind it and leave it exact at every grid time."""
    here: Array = np.array(start, dtype=np.float64)
    first = 0
    while True:
        times = np.arange(first, first + BLOCK, dtype=np.float64) * step
        places: Array = here + np.cumsum(step * velocity(times), axis=0)
        yield from zip(*places.T.tolist(), strict=True)
        here, first = places[-1], first + BLOCK


def aims_in_the_plane(
    path: SliderPath, setup: CapsuleSetup, step: float
) -> Iterator[tuple[float, float]]:
    """The same for a `path` in the plane; where its acceleration jumps on the grid alone, places
    less half a step of the velocity, which do not drift turn after turn."""
    place, velocity = setup.plane_place, setup.plane_velocity
    assert place is not None
    assert velocity is not None
    if not switches_on_grid(path, step):
        yield from aims(velocity, setup.slider, step)
    first = 1
    while True:
        times = np.arange(first, first + BLOCK, dtype=np.float64) * step
        places = place(times) - 0.5 * step * velocity(times)
        yield from zip(*places.T.tolist(), strict=True)
        first += BLOCK


def driven(
    assembly: Assembly, aimed: Iterator[tuple[float, float]], step: float, tell: Tell
) -> Act:
    """Function to call before each step of `step` [s], for any path and a body that turns: looks up
    where body and slider will be. `tell` hears where the slider will be, from C."""
    next(aimed)
    body, slider, joint = assembly.body, assembly.slider, assembly.joint
    cx, cy = point(assembly.centre)
    cos, sin = math.cos, math.sin

    def act(time: float) -> None:
        x, y = body.position
        vx, vy = body.velocity
        sx, sy = slider.position
        wx, wy = slider.velocity
        angle = body.angle + step * body.angular_velocity
        c, s = cos(angle), sin(angle)
        dx, dy = sx - x + step * (wx - vx), sy - y + step * (wy - vy)
        bx, by = c * dx + s * dy, c * dy - s * dx
        joint.anchor_a = bx, by
        bx, by = bx - cx, by - cy
        ax, ay = next(aimed)
        dx, dy = bx - ax, by - ay
        joint.anchor_b = c * dx - s * dy, s * dx + c * dy
        tell(bx, by)

    return act


def driven_along(
    assembly: Assembly, aimed: Iterator[tuple[float, float]], heading: float, tell: Tell
) -> Act:
    """The same for a body that keeps its `heading` [rad]: the slider will be where it was to go,
    and nothing is looked up. On a turn it would be beside that place, and make a torque."""
    joint = assembly.joint
    cx, cy = point(assembly.centre)
    c, s = math.cos(heading), math.sin(heading)
    bx, by = next(aimed)

    def act(time: float) -> None:
        nonlocal bx, by
        ax, ay = next(aimed)
        dx, dy = bx - ax, by - ay
        joint.anchor_a = bx + cx, by + cy
        joint.anchor_b = c * dx - s * dy, s * dx + c * dy
        tell(bx, by)
        bx, by = ax, ay

    return act


def untold(x: float, y: float) -> None:
    """Nothing to tell: contacts find their forces themselves."""
