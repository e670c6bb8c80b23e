"""The picture of a system in a replay: its channels, its geometry, and how far a run is off."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.samples import Channels
from plumbob.reports.view import notation

Box = tuple[float, float, float, float]  # left, right, bottom, top
MARGIN = 1.16  # of a chart's range
STILL = 1e-9  # [m] or [rad]: beside another size, a smaller one is not mentioned
MOST = 3  # observables that are drawn of a system without a picture
# Where the camera stands: its direction round the vertical and above the horizontal.
AZIMUTH, ELEVATION = math.radians(25.0), math.radians(20.0)


@dataclass(frozen=True)
class Chart:
    """A channel over time, of a system without a picture."""

    label: str
    channel: str
    low: float
    high: float


@dataclass(frozen=True)
class Picture:
    """How a case is drawn. `motion` gives its channels at times [s], shape (n,); `deviations` what
    a run differs by, at the run's times, in the same channels; `apart` how far that is, by unit,
    beside which `sizes` are as large as the picture."""

    kind: Literal["pendulum", "cone", "capsule", "body", "chart", "geoms"]
    box: Box  # that the picture shows [m]
    geometry: Mapping[str, Any]  # what the script needs beside that, as JSON
    sizes: Mapping[str, float]
    motion: Callable[[Array], Channels]
    deviations: Callable[[Trajectory], Channels]
    apart: Callable[[Channels], Mapping[str, Array]]
    held: Sequence[str]  # channels that are drawn to a pixel's fraction between samples
    cubic: bool = True  # these are interpolated by cubics
    charts: tuple[Chart, ...] = ()

    def part(self, deviations: Channels) -> float:
        """The largest deviation, of the picture."""
        sizes = [values / self.sizes[unit] for unit, values in self.apart(deviations).items()]
        return float(np.max(np.sum(sizes, axis=0)))

    def largest(self, deviations: Channels) -> str:
        """The largest deviations, in words."""
        sizes = {unit: float(np.max(values)) for unit, values in self.apart(deviations).items()}
        return ", ".join(
            notation.metres(size) if unit == "m" else f"{notation.number(size)} {unit}".strip()
            for unit, size in sizes.items()
            if unit != "rad" or size > STILL or len(sizes) == 1
        )


def observed(
    observe: Callable[[Array], Channels], names: Sequence[str]
) -> tuple[Callable[[Array], Channels], Callable[[Trajectory], Channels]]:
    """The motion that `observe` gives at times [s], and the differences of a run from it, in
    channels that are observables."""

    def motion(times: Array) -> Channels:
        exact = observe(times)
        return {name: exact[name] for name in names}

    def deviations(run: Trajectory) -> Channels:
        exact = motion(run.times)
        return {name: run.observables.get(name, values) - values for name, values in exact.items()}

    return motion, deviations


def camera(azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> list[list[float]]:
    """Directions in the world that a picture shows to the right, upwards and towards the viewer,
    shape (3, 3): an orthographic projection."""
    ca, sa = math.cos(azimuth), math.sin(azimuth)
    ce, se = math.cos(elevation), math.sin(elevation)
    return [[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]]


def charts(case: Case, seconds: float) -> Picture:
    """The replay of a system without a picture over `seconds` [s]: its first observables."""
    units = {o.name: o.unit for o in case.system.observables[:MOST]}
    first = next(iter(units))
    motion, deviations = observed(case.reference.observe, list(units))
    exact = motion(np.linspace(0.0, seconds, 801))
    middles = {name: 0.5 * (v.max() + v.min()) for name, v in exact.items()}
    halves = {name: 0.5 * MARGIN * np.ptp(v) or 1.0 for name, v in exact.items()}
    return Picture(
        "chart",
        (0.0, 1.0, 0.0, 1.0),
        {},
        {units[first]: float(np.ptp(exact[first])) or 1.0},
        motion,
        deviations,
        lambda differences: {units[first]: np.abs(differences[first])},
        [first],
        charts=tuple(
            Chart(
                f"{name} [{unit}]", name, middles[name] - halves[name], middles[name] + halves[name]
            )
            for name, unit in units.items()
        ),
    )
