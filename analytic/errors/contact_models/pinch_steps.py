"""Errors of steps on a body between two fingers: none, or the drift of soft friction."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.soft_friction import Held, drifted
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.pinch import Pinch
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors

FINGERS = 2
TIP = 0.2  # chosen: the radius of a fingertip over the cube's edge


def fingertip(pinch: Pinch) -> Held:
    """The load on one of the fingers."""
    weight = 1.0 / pinch.mass + 1.0 / pinch.finger_mass
    pull, part = pinch.pull / FINGERS, pinch.mass / FINGERS
    return Held(pinch.normal_force, pinch.friction, pull, weight, part)


def pinch_errors(pinch: Pinch) -> StepErrors:
    """The errors of steps on a pinched body; empty for schemes that are not stepped here, and where
    a friction pyramid does not hold it or a contact is too deep."""

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        held, still = fingertip(pinch), pinch.observe(times)
        if scheme.contact is None:
            return still if scheme.integrator == EULER else {}
        drift = drifted(scheme, held, step, np.rint(times / step).astype(int))
        deep = held.depth(scheme.contact, step) > TIP * pinch.size
        if deep or not len(drift) or drift[0].max() > pinch.size / 2.0:  # off the face
            return {}
        return SteppedErrors(dict(zip(still, drift, strict=True)), pinch.uncertainty(times))

    return StepErrors(error)
