"""The driven rotor as a smooth system, and its exact motions as smooth motions."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor, forces
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion, with_equations
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Reference

ANGLE = ("theta", "theta_dot")


def smooth_system(
    rotor: DrivenRotor, theta: float, theta_dot: float, tilt: float = 0.0
) -> SmoothSystem:
    """Returns the equation of a `rotor` as a system that starts at `theta` [rad] and `theta_dot`
    [rad/s].

    The rotor's angle is theta plus a `tilt` [rad].
    """
    acceleration = forces(rotor)
    return SmoothSystem(
        coordinates=ANGLE[:1],
        rates=ANGLE[1:],
        mass_matrix=lambda p, q: ((1.0 + 0.0 * q[0],),),
        forces=lambda p, t, q, v: acceleration(p, t, (q[0] + tilt,), v),
        parameters=asdict(rotor),
        position=(theta,),
        rate=(theta_dot,),
        damped=rotor.damping_rate > 0.0,
    )


def rotor_motion(
    rotor: DrivenRotor, system: SmoothSystem, motion: Reference, start: Any = None
) -> SmoothMotion:
    """Returns an exact `motion` of a `rotor` together with the equations of its `system`.

    `start` is the initial state in 34 digits; if it is None, the system's start in doubles.
    """
    fastest = abs(float(system.start[1])) + 2 * rotor.rate()
    return with_equations(system, motion, fastest, start)
