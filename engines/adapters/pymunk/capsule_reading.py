"""What is read off a capsule seen from above."""

from __future__ import annotations

import cmath
from collections.abc import Callable, Mapping

import numpy as np

from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.capsule_space import Assembly, told_normal_forces

Read = Callable[[], Mapping[str, float]]


def on_the_line(setup: CapsuleSetup, assembly: Assembly) -> tuple[Read, Read]:
    """What is signed along the line; the N_i that statics gives for the place where the slider is;
    how fast the pins open; and once a step is done, the friction in it. Joints say how large their
    impulses are and not where they point: friction is what momentum gains beyond gravity's share.
    """
    body, slider, unit = assembly.body, assembly.slider, cmath.rect(1.0, setup.direction)
    start, back = complex(*setup.slider), cmath.exp(-1j * setup.heading) / unit
    pulled, before = sum(part.mass for part in assembly.parts) * setup.pull, 0j

    def read() -> Mapping[str, float]:
        nonlocal before
        before, (place, velocity) = momentum(assembly), centre_of(assembly)
        turned, later = cmath.exp(1j * body.angle), half_a_step(assembly)
        arm = complex(*slider.position) - place
        carried = velocity + 1j * body.angular_velocity * later * arm
        sliding = (complex(*slider.velocity) - carried) / (turned * later)
        gone, inside = place * back, arm / turned
        forces = told_normal_forces(setup, np.array([[inside.real, inside.imag]]))[0]
        return {
            "displacement": gone.real,
            "velocity": (velocity * back).real,
            "stroke": ((inside - start) / unit).real,
            "stroke_rate": (sliding / unit).real,
            "heading": body.angle - setup.heading,
            "sideways": gone.imag,
            **{f"normal_force_{i + 1}": float(forces[i]) for i in range(3)},
            "opening_rate": opening_rate(assembly),
        }

    def following() -> Mapping[str, float]:
        gained = (momentum(assembly) - before) * back
        return {"friction_force": gained.real / assembly.space.current_time_step - pulled}

    return read, following


def in_the_plane(setup: CapsuleSetup, assembly: Assembly) -> Read:
    """Place of C and heading in the axes of the start, and how fast the pins open."""
    body, back = assembly.body, cmath.exp(-1j * setup.heading)

    def read() -> Mapping[str, float]:
        place, velocity = (value * back for value in centre_of(assembly))
        return {
            "x": place.real,
            "y": place.imag,
            "velocity_x": velocity.real,
            "velocity_y": velocity.imag,
            "heading": body.angle - setup.heading,
            "body_angle": body.angle - setup.heading,
            "heading_rate": body.angular_velocity,
            "opening_rate": opening_rate(assembly),
        }

    return read


def momentum(assembly: Assembly) -> complex:
    """Of all that moves [kg m/s]."""
    return sum((part.mass * complex(*part.velocity) for part in assembly.parts), 0j)


def centre_of(assembly: Assembly) -> tuple[complex, complex]:
    """Place [m] and velocity [m/s] of C in the world."""
    body = assembly.body
    arm = cmath.exp(1j * body.angle) * assembly.centre
    spun = 1j * body.angular_velocity * half_a_step(assembly) * arm
    return complex(*body.position) + arm, complex(*body.velocity) + spun


def half_a_step(assembly: Assembly) -> complex:
    """Turn of the body in half a step: its velocities belong so much after its places."""
    return cmath.exp(0.5j * assembly.body.angular_velocity * assembly.space.current_time_step)


def opening_rate(assembly: Assembly) -> float:
    """Largest velocity of a part beside the place where it is pinned [m/s]: what the sweeps of a
    step have left of it."""
    body = assembly.body
    rates = [
        abs(body.velocity_at_local_point(pin.anchor_a) - pin.b.velocity) for pin in assembly.pins
    ]
    return max(rates, default=0.0)
