"""Errors of steps on a cube on a slope: friction that ends a slip within its step, or drifts."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.soft_friction import Held, drifted
from plumbob.analytic.errors.sliding_motion.sliding_errors import stepped
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.incline import Incline
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, apart

CORNERS = 4  # of the cube's face, which carry the same loads where it does not turn


def corner(cube: Incline) -> Held:
    """The load on one of the corners."""
    pull = cube.pull * np.array([np.cos(cube.heading), np.sin(cube.heading)])
    part = cube.mass / CORNERS
    return Held(part * cube.press, cube.friction, part * pull, 1.0 / cube.mass, part)


def incline_errors(cube: Incline) -> StepErrors:
    """The errors of steps on a cube; empty for schemes that are not stepped here, and of soft
    contacts on a cube that slides, whose contacts chatter."""

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        exact, marks = cube.observe(times), np.rint(times / step).astype(int)
        if scheme.contact is None and scheme.integrator == EULER:
            pulls, limit = [cube.pull] * int(marks[-1]), cube.friction * cube.press
            reached = stepped(scheme, step, cube.speed, pulls, limit)[:, marks]
            rounded = ULP * (abs(cube.speed) + cube.gravity * times)
            return SteppedErrors(
                apart(dict(zip(("x", "speed"), reached, strict=False)), exact),
                {"x": rounded * (step + times), "speed": rounded},
            )
        drift = drifted(scheme, corner(cube), step, marks)
        if cube.speed or not len(drift):
            return {}
        return SteppedErrors(dict(zip(exact, drift, strict=True)), cube.uncertainty(times))

    return StepErrors(error)
