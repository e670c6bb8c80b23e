"""Characteristic sizes of motions, with which errors are compared. They do not grow with time.

The size of a libration's angle is its amplitude. The size of a rotation's angle is one radian,
never the angle that has accumulated. The size of a displacement, or of the pose that a manoeuvre
ends in, is its final value. A body that should stay at rest has a declared length.
"""

from __future__ import annotations

import math

import numpy as np

from plumbob.models.scene import Case, Quantity

RADIAN = 1.0  # [rad] scale of an angle that keeps growing
AT_REST = 1e-3  # [m] scale of a displacement that should be zero
_SAMPLES = 4001  # samples of a motion: they show the amplitude of ten swings within 1e-5
_LARGEST_STILL = 1e-9  # [m], [rad] largest change that is no motion


def swing_quantities(case: Case, period: float = 0.0) -> tuple[Quantity, ...]:
    """Returns the angle theta of a pendulum over the run. Its scale is one radian if the pendulum
    turns over, otherwise its amplitude. With a `period` [s] the amplitude is half the range of the
    angle over the period. Without one it is the largest distance from the angle 0, where the
    pendulum rests, over the run."""
    times = np.linspace(0.0, period or case.scene.duration, _SAMPLES)
    theta = case.reference.observe(times)["theta"]
    amplitude = float(np.ptp(theta)) / 2 if period else float(np.abs(theta).max())
    scale = amplitude if 0.0 < amplitude < math.pi else RADIAN
    return (Quantity("theta", scale),)


def displacement_quantities(case: Case) -> tuple[Quantity, ...]:
    """Returns the displacement of a body along a line at the end; the scale is the displacement
    itself. If the final displacement is zero, returns the displacement over the whole run, with a
    declared length as the scale."""
    final = abs(_final_values(case)["displacement"])
    if final == 0.0:
        return (Quantity("displacement", AT_REST),)
    return (Quantity("displacement", final, "end"),)


def turn_quantities(case: Case, observable: str) -> tuple[Quantity, ...]:
    """Returns the angle `observable` at the end of a manoeuvre; the scale is the angle itself, at
    most one radian."""
    final = abs(_final_values(case)[observable])
    return (Quantity(observable, min(final, RADIAN) or RADIAN, "end"),)


def pose_quantities(case: Case) -> tuple[Quantity, ...]:
    """Returns the pose that a body ends in. If the body moves, x and y count, with the distance
    moved as the scale. If it turns, its heading counts, with the angle turned as the scale, at most
    one radian. If it does neither, x and y over the run count, with a declared length."""
    start = case.reference.observe(np.zeros(1))
    final = _final_values(case)
    moved = {name: final[name] - float(start[name][0]) for name in ("x", "y", "heading")}
    distance = math.hypot(moved["x"], moved["y"])
    quantities = []
    if distance > _LARGEST_STILL:
        quantities += [Quantity(name, distance, "end") for name in ("x", "y")]
    if abs(moved["heading"]) > _LARGEST_STILL:
        quantities.append(Quantity("heading", min(abs(moved["heading"]), RADIAN), "end"))
    return tuple(quantities) or (Quantity("x", AT_REST), Quantity("y", AT_REST))


def _final_values(case: Case) -> dict[str, float]:
    """Returns the exact observables at the end of a case."""
    observed = case.reference.observe(np.array([case.scene.duration]))
    return {name: float(values[0]) for name, values in observed.items()}
