"""The picture of a system in a replay: its channels, its geometry, and the size of deviations."""

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
STILL = 1e-9  # [rad] largest angle that is not mentioned beside a distance
# direction of the camera: around the vertical, and above the horizontal
AZIMUTH = math.radians(25.0)
ELEVATION = math.radians(20.0)


@dataclass(frozen=True)
class Picture:
    """The picture of a case in a replay.

    `motion` returns the exact channels at times [s], shape (n,). `deviations` returns the
    differences of a run from these channels at the run's times. `apart` returns the magnitude of
    such differences by unit, shape (n,) each; a magnitude of `sizes[unit]` is as large as the
    picture."""

    kind: Literal["pendulum", "cone", "capsule", "body", "geoms"]
    box: Box  # [m] extent of the picture
    geometry: Mapping[str, Any]  # further values for the script, as JSON
    sizes: Mapping[str, float]  # by unit
    motion: Callable[[Array], Signals]
    deviations: Callable[[Trajectory], Signals]
    apart: Callable[[Signals], Signals]

    def part(self, deviations: Signals) -> float:
        """Returns the largest deviation relative to the size of the picture."""
        sizes = [values / self.sizes[unit] for unit, values in self.apart(deviations).items()]
        return float(np.max(np.sum(sizes, axis=0)))

    def largest(self, deviations: Signals) -> str:
        """Returns the largest deviations as text, by unit."""
        sizes = {unit: float(np.max(values)) for unit, values in self.apart(deviations).items()}
        texts = []
        for unit, size in sizes.items():
            if unit == "m":
                texts.append(notation.metres(size))
            elif unit != "rad" or size > STILL or len(sizes) == 1:
                texts.append(f"{notation.number(size)} {unit}".strip())
        return ", ".join(texts)


def channels_of_observables(
    observe: Callable[[Array], Signals], names: Sequence[str]
) -> tuple[Callable[[Array], Signals], Callable[[Trajectory], Signals]]:
    """Returns the functions `motion` and `deviations` of a picture whose channels are the
    observables `names`; `observe` returns the exact observables at times [s]."""

    def motion(times: Array) -> Signals:
        """Returns the exact channels at `times` [s], shape (n,)."""
        exact = observe(times)
        return {name: exact[name] for name in names}

    def deviations(run: Trajectory) -> Signals:
        """Returns the differences of a run from the exact channels; zero for one not observed."""
        exact = motion(run.times)
        return {
            name: run.observables.get(name, values) - values for name, values in exact.items()
        }

    return motion, deviations


def camera(azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> list[list[float]]:
    """Returns the world directions that an orthographic picture shows to the right, upwards and
    towards the viewer, as rows, shape (3, 3). The angles are in radians."""
    ca = math.cos(azimuth)
    sa = math.sin(azimuth)
    ce = math.cos(elevation)
    se = math.sin(elevation)
    return [[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]]
