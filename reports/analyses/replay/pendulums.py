"""Replays of the simple and of the linear pendulum, and what all pendulums have in common."""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.models.registry import case_of, systems
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case, Scene
from plumbob.reports.analyses.replay.picture import (
    Chart,
    Picture,
    around,
    observed,
    radians,
)
from plumbob.reports.analyses.replay.samples import Channels
from plumbob.reports.view.notation import number

COMPANIONS = MappingProxyType({"simple-pendulum": "linear-pendulum"})
"""Systems drawn together: the same start, without and with θ in place of sin θ."""
ANGLES = frozenset({"theta"})
CHANNELS = ("theta", "theta_dot")
SWINGS = 8.0  # in a chart over time: more would be too narrow to see


def pendulum(case: Case, seconds: float) -> Picture:
    """The replay of a simple or linear pendulum over `seconds` [s]."""
    length, linear = case.problem.length, case.problem.linear
    reach, fine = 1.2 * length, np.linspace(0.0, seconds, 2001)
    exact = case.reference.observe(fine)
    other = companion(case.scene)
    beside = (exact,) if other is None else (exact, other.reference.observe(fine))
    natural = math.sqrt(case.problem.gravity / length)
    shown = SWINGS * 2.0 * math.pi / natural if natural else seconds
    window = shown if shown < seconds else 0.0
    span = (-1.1 * length, 1.1 * length)
    over = (0.0, seconds)
    text = (
        f"The bob on a rod of {number(length)} m; θ is its angle from hanging down. Beside it the "
        "phase plane, θ̇ over θ, and the bob's place, x and y, over time. "
    ) + ("The equation is linear, with θ in place of sin θ." if linear else "")

    return Picture(
        "pendulum",
        text.strip(),
        (-reach, reach, -reach, reach),
        {"length": length, "trail": min(0.3 * (shown / SWINGS), seconds)},
        (
            phase(*beside),
            Chart("x [m]", "t", ("x",), (*over, *span), seconds=window),
            Chart("y [m]", "t", ("y",), (*over, *span), seconds=window),
        ),
        ANGLES,
        frozenset(CHANNELS),
        1.0,
        *observed(case.reference.observe, CHANNELS),
        apart,
        largest,
    )


def companion(scene: Scene) -> Case | None:
    """The same start in the system that a scene is drawn together with; None without one."""
    other = COMPANIONS.get(scene.system)
    if other is None:
        return None
    name = f"{other}/{scene.name.partition('/')[2]}"
    if name not in {candidate.name for candidate in systems()[other].scenes}:
        return None
    return case_of(find_scene(name))


def phase(*motions: Channels) -> Chart:
    """The phase plane of motions with samples `seen`."""
    thetas, rates = ([motion[name] for motion in motions] for name in CHANNELS)
    turns = max(float(np.ptp(theta)) for theta in thetas) > 2.0 * math.pi
    across = (-math.pi, math.pi) if turns else around(*thetas)
    box = (*across, *around(*rates))
    return Chart("θ̇ [rad/s] over θ [rad]", "theta", ("theta_dot",), box, turns=turns)


def apart(deviations: Channels) -> Array:
    """The size of deviations [rad], shape (n,)."""
    return np.abs(deviations["theta"])


def largest(deviations: Channels) -> str:
    """The largest deviation with its unit."""
    return radians(float(apart(deviations).max()))
