"""Characteristic sizes of motions, which errors are compared with: they do not grow with time.

A libration's angle has its amplitude, a rotation's one radian, never the angle that has piled up; a
displacement, and the place or heading that a manoeuvre ends at, has its own final size; a body that
should stay at rest has a declared length.
"""

from __future__ import annotations

import math

import numpy as np

from plumbob.models.scene import Case, Quantity

RADIAN = 1.0  # the scale of an angle that keeps growing
AT_REST = 1e-3  # [m] the scale of a displacement that should be zero
_SAMPLES = 4001  # of a motion, for its amplitude: within 1e-5 of it for ten swings
_STILL = 1e-9  # [m], [rad]: a smaller change is no motion


def swing(case: Case, period: float = 0.0) -> tuple[Quantity, ...]:
    """The angle theta of a pendulum over the run. Its scale is one radian if it turns over, and its
    amplitude else: half its range over a `period` [s]; without one, the largest angle from 0, where
    the pendulum rests, over the run."""
    theta = case.reference.observe(np.linspace(0.0, period or case.scene.duration, _SAMPLES))[
        "theta"
    ]
    amplitude = float(np.ptp(theta)) / 2 if period else float(np.abs(theta).max())
    return (Quantity("theta", amplitude if 0.0 < amplitude < math.pi else RADIAN),)


def displaced(case: Case) -> tuple[Quantity, ...]:
    """Where a body ends along a line, with its own final size as the scale; over the whole run,
    with a declared length, if that is none."""
    final = abs(_final(case)["displacement"])
    if final == 0.0:
        return (Quantity("displacement", AT_REST),)
    return (Quantity("displacement", final, "end"),)


def turned(case: Case, observable: str) -> tuple[Quantity, ...]:
    """The angle that a manoeuvre turns a body by, at its end; the scale is the angle itself, or one
    radian if it is more."""
    final = abs(_final(case)[observable])
    return (Quantity(observable, min(final, RADIAN) or RADIAN, "end"),)


def pose(case: Case) -> tuple[Quantity, ...]:
    """The pose that a body ends in: its place, with the distance from where it was as the scale, if
    it moves, and its heading, with the angle turned or one radian, if it turns."""
    start = case.reference.observe(np.zeros(1))
    final = _final(case)
    moved = {name: final[name] - float(start[name][0]) for name in ("x", "y", "heading")}
    distance = math.hypot(moved["x"], moved["y"])
    quantities = []
    if distance > _STILL:
        quantities += [Quantity(name, distance, "end") for name in ("x", "y")]
    if abs(moved["heading"]) > _STILL:
        quantities.append(Quantity("heading", min(abs(moved["heading"]), RADIAN), "end"))
    return tuple(quantities) or (Quantity("x", AT_REST), Quantity("y", AT_REST))


def _final(case: Case) -> dict[str, float]:
    observed = case.reference.observe(np.array([case.scene.duration]))
    return {name: float(values[0]) for name, values in observed.items()}
