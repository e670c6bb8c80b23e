"""Errors of steps on a cube on a slope: friction that ends a slip within its step, or drifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.errors.contact_models.soft_friction import Held, drifted
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.incline import Incline
from plumbob.analytic.theory import SteppedErrors, WithoutSeries

CORNERS = 4  # of the cube's face, which carry the same loads where it does not turn


def corner(cube: Incline) -> Held:
    """The load on one of the corners."""
    pull = cube.pull * np.array([np.cos(cube.heading), np.sin(cube.heading)])
    part = cube.mass / CORNERS
    return Held(part * cube.press, cube.friction, part * pull, 1.0 / cube.mass, part)


@dataclass(frozen=True)
class InclineErrors(WithoutSeries):
    """The errors of steps on a cube; empty for schemes that are not stepped here, and of soft
    contacts on a cube that slides, whose contacts chatter."""

    cube: Incline

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """See `plumbob.analytic.theory.ErrorTheory`."""
        cube, marks = self.cube, np.rint(times / step).astype(int)
        exact = cube.observe(times)
        if scheme.contact is None and scheme.integrator == EULER:
            stepped = self._hard(scheme, step, int(marks[-1]))[:, marks]
            errors = {n: v - exact[n] for n, v in zip(exact, stepped, strict=True)}
            rounded = ULP * (abs(cube.speed) + cube.gravity * times)
            return SteppedErrors(errors, {"x": rounded * (step + times), "speed": rounded})
        drift = drifted(scheme, corner(cube), step, marks)
        if cube.speed or not len(drift):
            return SteppedErrors({})
        return SteppedErrors(dict(zip(exact, drift, strict=True)), cube.uncertainty(times))

    def _hard(self, scheme: Scheme, step: float, steps: int) -> Array:
        """Place and speed after each step of EULER, shape (2, steps + 1)."""
        cube, speeds = self.cube, [self.cube.speed]
        most = step * cube.friction * cube.press
        for _ in range(steps):
            free = speeds[-1] + step * cube.pull
            speeds.append(free - min(max(free, -most), most))
        moved = speeds[:-1] if scheme.position_first else speeds[1:]
        return np.array([np.cumsum([0.0, *(step * speed for speed in moved)]), speeds])
