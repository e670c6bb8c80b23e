"""What is read off a capsule seen from the side: its motion, and what its contacts give it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
import pymunk

from plumbob.analytic.systems.capsule import load_shares
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.capsule_reading import momentum
from plumbob.engines.adapters.pymunk.capsule_side import DEPTH, Stand, along

Read = Callable[[], Mapping[str, float]]


def on_the_line(setup: CapsuleSetup, stand: Stand) -> tuple[Read, Read]:
    """What is signed along the line; the N_i of the last step; heave and tilt, which are to be
    none; and once a step is done, the friction in it, and what is left of the balance of momentum
    [N]: the slider is inside, so contacts and gravity alone may change it."""
    body, slider = stand.assembly.body, stand.assembly.slider
    start, before = along(setup, setup.slider), 0.0
    pulled = (body.mass + slider.mass) * setup.pull

    def read() -> Mapping[str, float]:
        nonlocal before
        before, pace = momentum(stand.assembly).real, body.velocity.x
        gone, height = body.position
        return {
            "displacement": gone,
            "velocity": pace,
            "stroke": slider.position.x - gone - start,
            "stroke_rate": slider.velocity.x - pace,
            **normal_forces(setup, stand),
            "heave": height + DEPTH,
            "tilt": body.angle,
        }

    def following() -> Mapping[str, float]:
        friction = sum(force for force, _ in contact_forces(stand))
        gained = momentum(stand.assembly).real - before
        left = gained / stand.assembly.space.current_time_step - pulled - friction
        return {"friction_force": friction, "momentum_residual": left}

    return read, following


def in_the_plane(setup: CapsuleSetup, stand: Stand) -> Read:
    """Place of C in the axes of the start; heave and tilt."""
    body, line = stand.assembly.body, setup.direction

    def read() -> Mapping[str, float]:
        (gone, height), pace = body.position, body.velocity.x
        return {
            "x": gone * math.cos(line),
            "y": gone * math.sin(line),
            "velocity_x": pace * math.cos(line),
            "velocity_y": pace * math.sin(line),
            "heave": height + DEPTH,
            "tilt": body.angle,
        }

    return read


def normal_forces(setup: CapsuleSetup, stand: Stand) -> Mapping[str, float]:
    """N_i in the last step [N]: those of both feet and their centre, shared among three supports
    as statics across the line has it."""
    (_, hind), (_, fore) = contact_forces(stand)
    both, capsule = hind + fore, setup.capsule
    reach = np.dot((hind, fore), stand.reach) / both if both else math.nan
    x, y = setup.slider
    unit = np.array([math.cos(setup.direction), math.sin(setup.direction)])
    across = capsule.mass_ratio * (unit[0] * y - unit[1] * x)
    centre = reach * unit + across * np.array([-unit[1], unit[0]])
    forces = both * load_shares(capsule, centre)
    return {f"normal_force_{i + 1}": float(forces[i]) for i in range(3)}


def contact_forces(stand: Stand) -> list[tuple[float, float]]:
    """Force of the ground on each foot [N], along and up, in the last step."""
    step = stand.assembly.space.current_time_step
    found: dict[pymunk.Shape, tuple[float, float]] = {}

    def note(arbiter: pymunk.Arbiter) -> None:
        x, y = arbiter.total_impulse
        upwards = math.copysign(1.0 / step, y)
        for shape in arbiter.shapes:
            found[shape] = (upwards * x, upwards * y)

    stand.assembly.body.each_arbiter(note)
    return [found.get(foot, (0.0, 0.0)) for foot in stand.feet]
