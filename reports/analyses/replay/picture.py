"""The picture of a system in a replay: its channels, its geometry, and how far a run is off."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.view import notation

Box = tuple[float, float, float, float]  # left, right, bottom, top
STILL = 1e-9  # [m] or [rad]: beside another size, a smaller one is not mentioned
# Where the camera stands: its direction round the vertical and above the horizontal.
AZIMUTH = math.radians(25.0)
ELEVATION = math.radians(20.0)


@dataclass(frozen=True)
class Picture:
    """How a case is drawn. `motion` gives its channels at times [s], shape (n,); `deviations` what
    a run differs by, at the run's times, in the same channels; `apart` how far that is, by unit,
    beside which `sizes` are as large as the picture."""

    kind: Literal["pendulum", "cone", "capsule", "body", "geoms"]
    box: Box  # that the picture shows [m]
    geometry: Mapping[str, Any]  # what the script needs beside that, as JSON
    sizes: Mapping[str, float]
    motion: Callable[[Array], Signals]
    deviations: Callable[[Trajectory], Signals]
    apart: Callable[[Signals], Signals]

    def part(self, deviations: Signals) -> float:
        """The largest deviation, of the picture."""
        sizes = [values / self.sizes[unit] for unit, values in self.apart(deviations).items()]
        return float(np.max(np.sum(sizes, axis=0)))

    def largest(self, deviations: Signals) -> str:
        """The largest deviations, in words."""
        sizes = {unit: float(np.max(values)) for unit, values in self.apart(deviations).items()}
        return ", ".join(
            notation.metres(size) if unit == "m" else f"{notation.number(size)} {unit}".strip()
            for unit, size in sizes.items()
            if unit != "rad" or size > STILL or len(sizes) == 1
        )


def observed(
    observe: Callable[[Array], Signals], names: Sequence[str]
) -> tuple[Callable[[Array], Signals], Callable[[Trajectory], Signals]]:
    """The motion that `observe` gives at times [s], and the differences of a run from it, in
    channels that are observables."""

    def motion(times: Array) -> Signals:
        exact = observe(times)
        return {name: exact[name] for name in names}

    def deviations(run: Trajectory) -> Signals:
        exact = motion(run.times)
        return {
            name: run.observables.get(name, values) - values for name, values in exact.items()
        }

    return motion, deviations


def camera(azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> list[list[float]]:
    """Directions in the world that a picture shows to the right, upwards and towards the viewer,
    shape (3, 3): an orthographic projection."""
    ca = math.cos(azimuth)
    sa = math.sin(azimuth)
    ce = math.cos(elevation)
    se = math.sin(elevation)
    return [[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]]
