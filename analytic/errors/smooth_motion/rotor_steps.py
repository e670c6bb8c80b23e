"""The driven rotor as the steps of schemes read it, and what is known of their errors on it."""

from __future__ import annotations

from dataclasses import asdict, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import READ_AT, Equations
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor, forces
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED, Scheme


def equations_of(
    rotor: DrivenRotor, scheme: Scheme, step: Any, library: Any = np, by: Any = 1.0
) -> Equations:
    """The equation in a `step` [s], a number, an array or a series: its coefficients are those of
    `rotor` times `by`; `library` has the functions, cmath or numpy."""
    p = SimpleNamespace(**{name: value * by for name, value in asdict(rotor).items()})
    if scheme.control == "mean" and rotor.forcing_frequency:
        half = 0.5 * step * p.forcing_frequency
        p.forcing_amplitude = p.forcing_amplitude * library.sin(half) / half
    force, part = forces(rotor, library), float(scheme.implicit_damping)
    implicit = part * p.damping_rate, p.stiffness if scheme.implicit_spring else 0.0
    if scheme.integrator == LEAPFROG:  # so that a damped step is symmetric
        implicit = p.damping_rate, 0.0
    return Equations(
        lambda time, q, v: force(p, time, q, v),
        1,
        (lambda state: implicit) if part or scheme.integrator == LEAPFROG else None,
    )


def in_series(scheme: Scheme) -> bool:
    """Whether the error of `scheme` on a rotor is known as a series in the step."""
    jointed = scheme.control == "mean" or scheme.joint_closing_rate is not None
    return scheme.integrator in STEPPED and not jointed


def orders(scheme: Scheme, rotor: DrivenRotor, terms: int) -> range:
    """Powers of the step in so many `terms` of the error on `rotor`, even ones alone of a symmetric
    scheme; a forcing held over the step may lower the first."""
    assert scheme.order is not None
    held, first = READ_AT.get(scheme.control), scheme.order
    if not rotor.autonomous and held is not None:
        first = min(first, 2 if held == 0.5 else 1)
    stride = 2 if scheme.integrator == LEAPFROG and scheme.control != "start" else 1
    return range(first, first + stride * terms, stride)


def simplest(scheme: Scheme, rotor: DrivenRotor) -> Scheme:
    """The scheme without those of its variants that change nothing on `rotor`: methods that differ
    in them alone have the same errors there."""
    if scheme.integrator not in STEPPED:
        return scheme
    spring = scheme.implicit_spring and rotor.stiffness != 0.0
    damping = spring or (scheme.implicit_damping if rotor.damping_rate else 0.0)
    at_start = scheme.integrator == EULER and scheme.control == "start"  # as EULER reads it anyway
    control = "continuous" if rotor.autonomous or at_start else scheme.control
    return replace(scheme, control=control, implicit_damping=damping, implicit_spring=spring)
