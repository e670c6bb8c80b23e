"""Errors of steps on a stack at rest: none, or the depths of its soft contacts."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.soft_friction import STEPPED, Held
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.stack import Stack
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors

CORNERS = 4  # of a face, which carry the same loads
DEEPEST = 0.4  # chosen, of an edge: beyond a half, a contact pushes the cube through


def corners(stack: Stack) -> list[Held]:
    """Loads on a corner of each cube's lower face, from the lowest to the top."""
    below = np.concatenate([[0.0], 1.0 / stack.masses[:-1]])
    weights, parts = below + 1.0 / stack.masses, stack.masses / CORNERS
    loads = stack.normal_forces / CORNERS
    return [
        Held(float(load), 0.0, np.zeros(2), float(weight), float(part))
        for load, weight, part in zip(loads, weights, parts, strict=True)
    ]


def stack_errors(stack: Stack) -> StepErrors:
    """The errors of steps on a stack; empty for schemes that are not stepped here, and where a
    contact is too deep to push the right way."""

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        still = np.zeros(len(times))
        if scheme.contact is None:
            return {"top": still} if scheme.integrator == EULER else {}
        depths = [held.depth(scheme.contact, step) for held in corners(stack)]
        if scheme.integrator not in STEPPED or max(depths) > DEEPEST * stack.size:
            return {}
        return SteppedErrors({"top": still - sum(depths)}, stack.uncertainty(times))

    return StepErrors(error)
