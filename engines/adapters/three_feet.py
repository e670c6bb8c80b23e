"""The capsule's slider as engines drive it: its tracks, and its motion along them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup

CAPSULE = "capsule"  # the family of systems that have its model
CAPSULES = (  # what tells contact models apart, and of plans the shortest ones
    *("capsule-line/ca1", "capsule-line/heading-000", "capsule-line/heading-030"),
    *("capsule-line/heading-045", "capsule-line/frictionless", "capsule-hold/0.999"),
    *("capsule-hold/unloading", "capsule-coast", "capsule-turn/0.3", "capsule-turn/heading-*"),
    *("capsule-turn/light-slider", "capsule-turn/heavy-slider", "capsule-plan/heading-*"),
    *("capsule-plan/light-slider", "capsule-plan/heavy-slider"),
)
# A line turned about stays a line: a model of one need not run every heading.
ONE_LINE = (
    *("capsule-line/[!h]*", "capsule-line/heavy-slider", "capsule-hold", "capsule-train"),
    "capsule-coast/translation",
)


@dataclass(frozen=True)
class ThreeFeet:
    """A capsule's slider, on one track or on two at right angles."""

    setup: CapsuleSetup
    tracks: tuple[tuple[float, float], ...]  # their directions, in the body's axes

    def slider_velocity(self, times: Array) -> Array:
        """Imposed velocity along the tracks [m/s] at times [s], shape (n,): (n, tracks)."""
        if (line := self.setup.relative_velocity) is not None:
            return np.asarray(line(times))[:, None]
        assert self.setup.plane_velocity is not None
        return self.setup.plane_velocity(times)

    def controls(self, steps: Array, step: float) -> Array:
        """Mean acceleration of the slider along its tracks [m/s^2] over the steps of `step` [s]
        with these indices, shape (n, tracks): with it the slider's velocity is right at every grid
        time, wherever the acceleration jumps."""
        # By index: the velocity that one step ends with is the one that the next begins with.
        times = np.concatenate([steps, steps + 1.0]) * step
        begun, ended = np.split(self.slider_velocity(times), 2)
        return (ended - begun) / step


def on_three_feet(setup: CapsuleSetup) -> ThreeFeet:
    """The slider of a capsule."""
    tracks: tuple[tuple[float, float], ...] = ()
    if setup.relative_velocity is not None:
        tracks = ((math.cos(setup.direction), math.sin(setup.direction)),)
    elif setup.plane_velocity is not None:
        tracks = ((1.0, 0.0), (0.0, 1.0))
    return ThreeFeet(setup, tracks)
