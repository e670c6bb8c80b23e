"""An exact smooth motion with its equations and its linearisation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.numerics.collocation import TimeGrid, gauss_collocation
from plumbob.analytic.numerics.linear_flow import LinearFlow
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference, Signals

STAGES = 10  # stages of the collocation, for a relative error of about 1e-9
MOST_STEPS = 2**20  # largest number of steps along a motion


@dataclass(frozen=True)
class SmoothMotion:
    """An exact motion with d numbers in its state, and its equations z' = f(t, z)."""

    start: Any  # state at time 0, shape (d,), in doubles or 34 digits
    slope: Callable[[Array, Array], Array]  # f(times (n,), states (d, n)), shape (d, n)
    jacobian: Callable[[Array, Array], Array]  # derivatives f_z, shape (d, d, n)
    state: Callable[[Array], Array]  # exact states, shape (d, n), at times [s], shape (n,)
    pace: float  # [1/s] rate of change that the motion does not exceed by much
    read: Callable[[Array, Array], Signals]  # observables from times and states

    def grid(self, until: float) -> TimeGrid:
        """Returns equal steps up to the time `until` [s], in each of which the motion changes
        little. Raises ParameterError for more than MOST_STEPS steps."""
        count = until * self.pace
        if not count <= MOST_STEPS:
            raise ParameterError("duration", until, "shorter: the motion is too fast")
        return TimeGrid(np.linspace(0.0, until, 2 + math.floor(count)))

    def linearised(
        self, grid: TimeGrid, stages: int = STAGES
    ) -> tuple[Array, Array, LinearFlow]:
        """Returns the times of the nodes of a grid's steps [s], shape (n,), the exact states there,
        shape (d, n), and the flow of small deviations, w' = f_z w."""
        edges = grid.breakpoints
        fractions = gauss_collocation(stages).nodes
        nodes = edges[:-1, None] + np.diff(edges)[:, None] * fractions
        times = np.minimum(nodes, grid.duration).ravel()
        states = self.state(times)
        matrix = np.moveaxis(self.jacobian(times, states), -1, 0)
        flow = LinearFlow(grid, matrix.reshape(*nodes.shape, *matrix.shape[1:]))
        return times, states, flow

    def tangents(self, times: Array) -> Array:
        """Returns the derivatives of the state at `times` [s], shape (n,), by the initial state, as
        shape (n, d, d)."""
        grid = self.grid(float(np.max(times, initial=0.0)) or 1.0)
        flow = self.linearised(grid)[2]
        return flow.respond(np.eye(flow.matrix.shape[-1]), np.zeros_like(flow.matrix)).at(times)


def with_equations(
    system: SmoothSystem, motion: Reference, pace: float = 0.0, start: Any = None
) -> SmoothMotion:
    """Returns an exact `motion` together with the equations of its `system`.

    `pace` is a rate of change [1/s]; if it is zero, the pace follows from the initial state.
    `start` is the initial state in 34 digits; if it is None, the system's start in doubles.
    """
    if not pace:
        jacobian = system.jacobian(0.0, system.start[:, None])[..., 0]
        pace = 4 * float(np.abs(np.linalg.eigvals(jacobian)).max())
    return SmoothMotion(
        start=system.start if start is None else start,
        slope=system.slope,
        jacobian=system.jacobian,
        state=lambda times: system.state(motion.observe(times)),
        pace=pace,
        read=lambda times, states: system.observed(states),
    )


def certified(motion: CertifiedMotion) -> SmoothMotion:
    """Returns a certified motion together with its equations."""
    return with_equations(motion.system, motion)
