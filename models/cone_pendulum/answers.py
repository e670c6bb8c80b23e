"""Exact answers of a cone pendulum: phase and energies as functions of time, and time as a function
of the angle."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.platform_energy import energies
from plumbob.models.scene import Observable

PHASE = Observable("phase", "rad")
MOMENTUM = Observable("momentum", "kg m^2/s")
ENERGIES = MappingProxyType(
    {
        "T_translation": "translation",
        "T_coupling": "coupling",
        "T_rotation": "rotation",
        "U": "gravity",
        "T_plus_U": "total",
        "work_of_drive": "work",
    }
)


def over_time(problem: ConePendulum, times: Array) -> Mapping[Observable, Array]:
    """Returns phase (Sudakov 2015, eqs. 11 and 13), momentum (8), the three parts of T (3-5), U, T
    + U, and the work of the drive since the start, at `times` [s], shape (n,)."""
    observed = problem.reference.observe(np.append(0.0, times))
    along = energies(problem.started, observed["theta"], observed["theta_dot"])
    return {
        PHASE: problem.motion.phase(times),
        MOMENTUM: problem.body.inertia_x * observed["theta_dot"][1:],
        **{Observable(name, "J"): getattr(along, part)[1:] for name, part in ENERGIES.items()},
    }


def over_angle(problem: ConePendulum, theta: Array) -> Mapping[Observable, Array]:
    """Returns the motion as the source writes it, as functions of the angle `theta` [rad], shape
    (n,): the time at which the motion first reaches the angle (16), and the momentum (15), the rate
    and the phase (13) at this time. All are NaN if the motion never reaches the angle."""
    reference = problem.reference
    times = reference.time_at(theta)
    reached = np.isfinite(times)
    rate = reference.state(np.where(reached, times, 0.0))[1]
    # At a turning point, rounding may make a square negative.
    size = np.nan_to_num(np.abs(reference.momentum(theta)))
    momentum = np.where(reached, np.copysign(size, rate), np.nan)
    return {
        Observable("t", "s"): times,
        MOMENTUM: momentum,
        Observable("theta_dot", "rad/s"): momentum / problem.body.inertia_x,
        PHASE: problem.motion.phase(times),
    }
